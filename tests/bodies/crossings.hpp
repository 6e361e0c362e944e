// Counts where surfaces pass through each other.
#pragma once

#include <array>
#include <cstddef>
#include <numeric>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

#include "constraints/body_contacts.hpp"
#include "proximity/crossings.hpp"

namespace springnet::testing {

// Pairs of edges and faces that go through each other, exactly.
inline std::size_t count_crossings(const Network& net, const Simulation& s) {
  std::vector<std::uint32_t> numbers(net.nodes().size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  BodyContacts bodies(net, numbers, numbers);
  std::array<std::vector<double>, 3> x;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) x[c].push_back(s.position(k)[static_cast<Eigen::Index>(c)]);
  return find_crossings(bodies.primitives(), {{x[0].data(), x[1].data(), x[2].data()}, net.nodes().size()}).size();
}

}  // namespace springnet::testing
