// Random networks that mix elements over several scalars, laws with memory, viscosities, rigid connections and contact:
// what a step of an integrator is, evaluated again by formulas of plain.hpp.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "generator.hpp"
#include "judge.hpp"
#include "mixture.hpp"
#include "nets.hpp"
#include "repetitions.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Network mixed_net(std::uint64_t seed, double smallest_share = 1e-6) {
  Network network = RandomNet(seed, smallest_share).network;
  Mixture(network, seed, smallest_share);
  return network;
}

}  // namespace

TEST_CASE("mixed random networks: a settled step solves its equation, in every update rule, at theta 1 and 1/2") {
  struct Method {
    std::string name;
    double rule, acceleration;
  };
  const Method rules[] = {{"newton", newton, 0},
                          {"synchronous", synchronous, 0},
                          {"wavefront", wavefront, 0},
                          {"block", block, 0},
                          {"coloured", coloured, 0},
                          {"automatic", automatic, 0},
                          {"synchronous, accelerated", synchronous, 5},
                          {"block, accelerated", block, 3}};
  constexpr std::size_t methods = std::size(rules);
  std::size_t settled[methods] = {}, tried[methods] = {};
  const std::uint64_t count = repetitions("SPRINGNET_RANDOM_NETS", 240);
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    const std::size_t m = seed % methods;
    const Network network = mixed_net(seed);
    Dice dice(seed + 7000000);
    SimulationOptions options;
    const double theta = dice.chance(0.5) ? 1.0 : 0.5;
    // Sweeps that are not Newton's settle where the step resolves the motion.
    options.time_step = dice.decades(1e-4, 1e-2) * (m == 0 || m == 5 ? 1.0 : 0.1);
    options.threads = 1 + dice.below(2);
    const double tolerance = 1e-9 * force_scale(network);
    options.integrator = recurrent(rules[m].rule, tolerance,
                                   {{"theta", theta}, {"acceleration", rules[m].acceleration}, {"max_sweeps", 400}});
    CAPTURE(seed);
    CAPTURE(rules[m].name);
    CAPTURE(theta);
    CAPTURE(options.time_step);
    ++tried[m];
    settled[m] += settles(network, options, tolerance, 3) ? 1 : 0;
  }
  if (count < 100) return;  // too few of each method to say more
  for (std::size_t m = 0; m < methods; ++m) {
    MESSAGE(rules[m].name << ": " << settled[m] << " of " << tried[m] << " networks settled");
    CHECK(settled[m] >= tried[m] / 5);  // sweeps without derivatives have a limit of the step; Newton's has none
  }
  CHECK(settled[0] >= tried[0] * 3 / 4);
}
