#include "learning/same_object.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet::learning {

namespace {

// What the other one has instead; empty: all is the same.
std::string difference_of(const Network& first, const Network& other) {
  const auto counts = [](const Network& of) {
    return fmt::format("{} nodes, {} springs and {} elements", of.nodes().size(), of.springs().size(),
                       of.elements().size());
  };
  if (counts(first) != counts(other)) return fmt::format("{} in place of {}", counts(other), counts(first));
  for (std::size_t k = 0; k < first.springs().size(); ++k) {
    const Spring here = first.springs()[k], there = other.springs()[k];
    if (here.first != there.first || here.second != there.second)
      return fmt::format("spring {} between the nodes {} and {} in place of {} and {}", k, there.first, there.second,
                         here.first, here.second);
  }
  for (std::size_t k = 0; k < first.elements().size(); ++k) {
    const Element &here = first.elements()[k], &there = other.elements()[k];
    if (here.invariant != there.invariant || here.nodes != there.nodes)
      return fmt::format("another invariant, or other nodes, of element {}", k);
  }
  return {};
}

}  // namespace

void check_same_object(const std::vector<Experiment>& experiments) {
  for (std::size_t k = 0; k < experiments.size(); ++k) {
    const Experiment& each = experiments[k];
    const auto name = [&](std::size_t number) {
      const std::string& own = experiments[number].name;
      return fmt::format("experiment {}{}", number + 1, own.empty() ? "" : fmt::format(" ({})", own));
    };
    if (!each.network) throw Error(ErrorKind::input, fmt::format("learning: {} has no network", name(k)));
    const std::string difference = difference_of(*experiments.front().network, *each.network);
    if (!difference.empty())
      throw Error(
          ErrorKind::input,
          fmt::format("learning: {} is of another object than {}: it has {}; all experiments have the nodes, springs "
                      "and elements of the first one, and only loads, the start and what is fixed may differ",
                      name(k), name(0), difference));
  }
}

void check_same_gravity(const std::vector<Experiment>& experiments, const std::vector<Learnable>& learnables) {
  const auto is_gravity = [](const Learnable& each) { return each.values.kind == LearnedValues::Kind::gravity; };
  if (std::none_of(learnables.begin(), learnables.end(), is_gravity)) return;
  for (std::size_t k = 1; k < experiments.size(); ++k)
    if (experiments[k].network->gravity() != experiments.front().network->gravity())
      throw Error(ErrorKind::input,
                  fmt::format("learning: gravity is learned for all experiments, and experiment {} starts with another "
                              "one than the first; give them the same, or leave gravity as it is known",
                              k + 1));
}

}  // namespace springnet::learning
