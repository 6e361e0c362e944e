#include "check/neuron_checks.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "check/child.hpp"
#include "check/heap.hpp"
#include "check/instruction_sets.hpp"
#include "check/law_call.hpp"
#include "check/neuron_call.hpp"
#include "check/quadrature.hpp"

namespace springnet::check {
namespace {

using namespace node_inputs;

std::vector<NodeInputs> any_nodes(const Component& component, std::mt19937_64& random, std::size_t count) {
  std::vector<NodeInputs> nodes;
  for (std::size_t k = 0; k < count; ++k) nodes.push_back(any_node(component, random));
  for (NodeInputs& node : nodes) node[node_inputs::time] = nodes[0][node_inputs::time];
  return nodes;
}

// Whether nodes first ... of a whole have the bits of a part.
bool same_part(const std::vector<double>& whole, const std::vector<double>& part, std::size_t first) {
  for (std::size_t k = 0; k < part.size(); ++k)
    if (!same_bits(whole[3 * first + k], part[k])) return false;
  return true;
}

}  // namespace

Outcome check_neuron_call(const Component& component, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  now_doing("evaluating one node");
  static_cast<void>(call_neuron(component, {any_node(component, random)}));
  now_doing("evaluating the derivatives of one node");
  static_cast<void>(call_neuron(component, {any_node(component, random)}, {.derivatives = true}));
  return {};
}

Outcome check_neuron_arrays(const Component& component, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (const Memory::Layout layout : {Memory::Layout::at_end, Memory::Layout::at_start})
    for (const std::size_t count : {1u, 3u, 8u, 19u})
      for (const bool share : {false, true}) {
        std::vector<NodeInputs> nodes = any_nodes(component, random, count);
        if (share)
          for (NodeInputs& node : nodes)
            std::copy(nodes[0].begin() + parameter, nodes[0].end(), node.begin() + parameter);
        now_doing(fmt::format("evaluating {} nodes", count).c_str());
        for (const bool derivatives : {true, false})
          static_cast<void>(
              call_neuron(component, nodes, {.derivatives = derivatives, .share = share, .layout = layout}));
      }
  return {};
}

Outcome check_neuron_finite(const Component& component, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (int k = 0; k < 200; ++k) {
    NodeInputs at = any_node(component, random);
    if (k % 4 == 0) std::fill_n(at.begin() + velocity, 3, 0.0);  // a node at rest
    for (const double a : call_neuron(component, {at}).acceleration)
      if (!std::isfinite(a))
        return {Result::failed,
                fmt::format("the acceleration is {} at a mass of {:.4g} kg and the velocity {:.4g}, {:.4g}, "
                            "{:.4g} m/s",
                            a, at[mass], at[velocity], at[velocity + 1], at[velocity + 2])};
  }
  return {};
}

Outcome check_neuron_derivatives(const Component& component, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (int k = 0; k < 40; ++k) {
    const NodeInputs at = any_node(component, random);
    const std::size_t declared = call_neuron(component, {at}, {.derivatives = true}).by.size();
    for (std::size_t column = 0; column < at.size(); ++column) {
      const bool is_force = column < position;
      if (column >= parameter && component.description->parameters[column - parameter]->type != SPRINGNET_NUMBER)
        continue;
      if (!is_force && column >= declared) continue;
      // Of each axis the declared derivative, then 1 / mass.
      const Pairs pairs = [&](const std::vector<double>& xs) {
        std::vector<Pair> result(is_force ? 6 : 3);
        NodeInputs moved = at;
        for (const double x : xs) {
          moved[column] = x;
          const NeuronAnswer answer = call_neuron(component, {moved}, {.derivatives = true});
          for (std::size_t axis = 0; axis < 3; ++axis) {
            result[axis].values.push_back(answer.acceleration[axis]);
            if (column < answer.by.size()) result[axis].derivatives.push_back(answer.by[column][axis]);
            if (!is_force) continue;
            result[3 + axis].values.push_back(answer.acceleration[axis]);
            result[3 + axis].derivatives.push_back(column == axis ? 1.0 / at[mass] : 0.0);
          }
        }
        return result;
      };
      double step = 0.05 * std::max(std::abs(at[column]), 1e-2);
      if (column >= parameter) {
        const springnet_parameter& p = *component.description->parameters[column - parameter];
        step = std::min({step, 0.5 * (at[column] - p.smallest), 0.5 * (p.largest - at[column])});
      }
      if (!(step > 0.0)) continue;
      const std::vector<Comparison> found = compare_over(pairs, at[column] - step, at[column] + step);
      for (std::size_t pair = found.size(); pair-- > 0;) {  // F / m first
        if (found[pair].verdict != Verdict::differs) continue;
        const double slope = found[pair].change / (2.0 * step), claimed = found[pair].integral / (2.0 * step);
        if (pair >= 3)
          return {Result::failed,
                  fmt::format("the acceleration grows by {:.9g} with the force, not by 1 / mass, {:.9g}: constraints "
                              "rely on F / m",
                              slope, claimed)};
        return {
            Result::failed,
            fmt::format("the derivative of the acceleration by {} is {:.9g}, its change gives {:.9g} (within {:.1e})",
                        input_name(component, column), claimed, slope, found[pair].error / (2.0 * step))};
      }
    }
  }
  return {};
}

Outcome check_neuron_batches(const Component& component, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const std::vector<NodeInputs> nodes = any_nodes(component, random, 67);
  const NeuronAnswer whole = call_neuron(component, nodes, {.derivatives = true});
  now_doing("evaluating batches of several sizes");
  for (const InstructionSetName& set : instruction_sets())
    for (const std::size_t size : {nodes.size(), std::size_t{1}, std::size_t{5}, std::size_t{8}, std::size_t{33}})
      for (const std::size_t offset : {0u, 1u, 3u})
        for (const bool derivatives : {true, false})
          for (std::size_t first = 0; first < nodes.size(); first += size) {
            const auto begin = nodes.begin() + static_cast<std::ptrdiff_t>(first);
            const auto end = nodes.begin() + static_cast<std::ptrdiff_t>(std::min(nodes.size(), first + size));
            const NeuronAnswer part = call_neuron(
                component, {begin, end},
                {.instruction_set = set.number, .derivatives = derivatives, .share = true, .offset = offset});
            bool same = same_part(whole.acceleration, part.acceleration, first);
            for (std::size_t column = 0; column < part.by.size(); ++column)
              same = same && same_part(whole.by[column], part.by[column], first);
            if (!same)
              return {Result::failed, fmt::format("with the instruction set {}, {} nodes at a time, a node has other "
                                                  "bits: its answer must depend on its own inputs alone",
                                                  set.name, size)};
          }
  return {};
}

Outcome check_neuron_leaks(const Component& component, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const std::vector<NodeInputs> nodes = any_nodes(component, random, 3);
  constexpr int calls = 100;
  const double kept =
      kept_by_each([&] { static_cast<void>(call_neuron(component, nodes, {.derivatives = true})); }, calls);
  if (kept > 0.0)
    return {Result::failed,
            fmt::format("each evaluation keeps {:.0f} bytes: give back what it takes, or use the stack", kept)};
  return {};
}

}  // namespace springnet::check
