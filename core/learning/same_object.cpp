#include "learning/same_object.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/surface_frictions.hpp"

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

std::vector<std::string> notes_of_differences(const std::vector<Experiment>& experiments,
                                              const std::vector<Learnable>& learnables) {
  using Kind = LearnedValues::Kind;
  const auto is_learned = [&](Kind kind) {
    return std::any_of(learnables.begin(), learnables.end(),
                       [&](const Learnable& each) { return each.values.kind == kind; });
  };
  const Network& first = *experiments.front().network;
  const auto nodes = static_cast<NodeIndex>(first.nodes().size());
  const auto springs = static_cast<SpringIndex>(first.springs().size());
  std::vector<std::string> notes;
  for (std::size_t k = 1; k < experiments.size(); ++k) {
    const Network& other = *experiments[k].network;
    std::string what;
    const auto add = [&](const char* values) { what += (what.empty() ? "" : " and ") + std::string(values); };
    bool differ = false;
    for (NodeIndex n = 0; n < nodes && !differ; ++n) differ = first.nodes()[n].mass != other.nodes()[n].mass;
    if (differ && !is_learned(Kind::mass)) add("masses");
    differ = false;
    for (SpringIndex s = 0; s < springs && !differ; ++s)
      differ = first.springs()[s].rest_length != other.springs()[s].rest_length;
    if (differ && !is_learned(Kind::rest_length)) add("rest lengths");
    if (!what.empty())
      notes.push_back(fmt::format("Experiment {} has other {} than the first: what is not learned is as each has it.",
                                  k + 1, what));
  }
  return notes;
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

void check_same_friction(const std::vector<Experiment>& experiments, const std::vector<Learnable>& learnables) {
  for (const Learnable& each : learnables) {
    if (each.values.kind != LearnedValues::Kind::friction) continue;
    const auto surfaces_of = [](const Network& network) {
      std::vector<std::pair<std::string, Friction>> result;
      for_each_surface(network,
                       [&](const std::string& name, const Friction& friction) { result.emplace_back(name, friction); });
      return result;
    };
    const auto first = surfaces_of(*experiments.front().network);
    for (std::size_t k = 1; k < experiments.size(); ++k) {
      const auto own = surfaces_of(*experiments[k].network);
      for (const std::uint32_t member : each.values.members)
        if (member < first.size() && (member >= own.size() || own[member].first != first[member].first ||
                                      own[member].second.kind != first[member].second.kind ||
                                      own[member].second.coefficient != first[member].second.coefficient))
          throw Error(ErrorKind::input,
                      fmt::format("learning: the friction of surface {}{} is learned for all experiments, which need "
                                  "the same planes and instruments in the same order, with the same friction at first: "
                                  "experiment {} has {}",
                                  member, first[member].first.empty() ? "" : ", '" + first[member].first + "',", k + 1,
                                  member >= own.size()                       ? "none of this number"
                                  : own[member].first != first[member].first ? "another one of this number"
                                                                             : "another friction of it"));
    }
  }
}

}  // namespace springnet::learning
