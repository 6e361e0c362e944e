#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <springnet/inspection.hpp>

#include "inspection/hints.hpp"
#include "inspection/limits.hpp"
#include "inspection/linearised.hpp"
#include "inspection/mobility.hpp"
#include "inspection/orders.hpp"
#include "inspection/suspicions.hpp"
#include "inspection/vibration.hpp"

namespace springnet {

namespace {

void widen(std::optional<Range>& range, double value) {
  if (std::isnan(value)) return;
  if (!range) range = Range{value, value};
  range->smallest = std::min(range->smallest, value);
  range->largest = std::max(range->largest, value);
}

void inspect_nodes(const Network& network, const LinearNetwork& linear, Inspection& result) {
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    const Node& node = network.nodes()[k];
    if (result.mass) {
      result.lower = result.lower.cwiseMin(node.position);
      result.upper = result.upper.cwiseMax(node.position);
    } else {
      result.lower = result.upper = node.position;
    }
    result.total_mass += node.mass;
    widen(result.mass, node.mass);
    result.fixed_nodes += linear.nodes[k].free ? 0 : 1;
    ++result.neurons[network.neurons()[node.neuron].id];
  }
}

void inspect_springs(const Network& network, const std::vector<LinearSpring>& linear, Inspection& result) {
  for (std::size_t s = 0; s < linear.size(); ++s) {
    const Spring& spring = network.springs()[s];
    const Material& material = network.materials()[spring.material];
    ++result.spring_functions[material.spring ? material.spring->id : "none"];
    ++result.viscosity_functions[material.viscosity ? material.viscosity->id : "none"];
    widen(result.length, linear[s].length);
    widen(result.rest_length, spring.rest_length);
    if (material.spring) widen(result.stiffness, linear[s].stiffness);
    if (material.viscosity) widen(result.damping, linear[s].axial_damping + linear[s].general_damping);
    const bool relaxed = std::abs(linear[s].length - spring.rest_length) <= 1e-9 * spring.rest_length;
    result.springs_under_load += material.spring && !relaxed ? 1 : 0;
  }
}

// Fills result.parts; returns the part of each node.
std::vector<std::uint32_t> inspect_parts(const Network& network, const LinearNetwork& linear, const Joints& joints,
                                         Inspection& result) {
  constexpr std::uint32_t none = 0xffffffffu;
  std::vector<std::uint32_t> part(network.nodes().size(), none);
  std::vector<Part> parts;
  std::vector<NodeIndex> front;
  for (NodeIndex node = 0; node < part.size(); ++node) {
    if (part[node] != none) continue;
    Part next{node};
    const auto number = static_cast<std::uint32_t>(parts.size());
    part[node] = number;
    front.assign(1, node);
    std::size_t ends = 0;  // of springs
    while (!front.empty()) {
      const NodeIndex member = front.back();
      front.pop_back();
      ++next.nodes;
      next.fixed_nodes += linear.nodes[member].free ? 0 : 1;
      for (const Joint& joint : joints.of(member)) {
        ends += joint.spring == no_spring ? 0 : 1;
        if (part[joint.other] != none) continue;
        part[joint.other] = number;
        front.push_back(joint.other);
      }
    }
    next.springs = ends / 2;
    result.nodes_without_springs += joints.of(node).empty() ? 1 : 0;
    parts.push_back(next);
  }
  // By falling size; they were found by rising first node.
  std::vector<std::uint32_t> place(parts.size()), order(parts.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return parts[a].nodes > parts[b].nodes; });
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    place[order[i]] = i;
    result.parts.push_back(parts[order[i]]);
  }
  for (std::uint32_t& number : part) number = place[number];
  return part;
}

}  // namespace

std::string_view name_of(UpdateRule rule) noexcept {
  switch (rule) {
    case UpdateRule::synchronous:
      return "synchronous";
    case UpdateRule::wavefront:
      return "wavefront";
    case UpdateRule::block:
      return "block";
    case UpdateRule::coloured:
      return "coloured";
    default:
      return "newton";
  }
}

Inspection inspect(const Network& network, const PluginHost& plugins, const InspectionOptions& options) {
  Inspection result;
  result.options = options;
  result.nodes = network.nodes().size();
  result.springs = network.springs().size();
  result.bodies = network.bodies().size();
  result.planes = network.planes().size();
  result.instruments = network.instruments().size();
  result.rigids = network.rigids().size();
  result.loads = network.loads().size();
  result.cuts = network.cuts().size();
  for (const Move& move : network.moves()) result.moved_nodes += move.nodes.size();
  for (const Element& element : network.elements()) ++result.elements[std::string(name_of(element.invariant))];
  const LinearNetwork linear = linearise(network, plugins);
  const Joints joints(network);
  inspect_nodes(network, linear, result);
  inspect_springs(network, linear.springs, result);
  const std::vector<std::uint32_t> part = inspect_parts(network, linear, joints, result);
  find_limits(network, linear, joints, result);
  count_mechanisms(network, linear, part, result);
  result.slowest = slowest_vibration(network, linear, result.mobility);
  result.suspicions = find_suspicions(network, linear, joints);
  result.hints = find_hints(network, linear, part, result);
  // Measured: peak of resident memory of `springnet run`, lattices of 0.2 to 1 million nodes with 3 to 13 damped
  // springs a node.
  constexpr double bytes_at_least = 10e6, bytes_per_node = 350.0, bytes_per_spring = 108.0;
  result.memory_bytes = bytes_at_least + bytes_per_node * static_cast<double>(result.nodes) +
                        bytes_per_spring * static_cast<double>(result.springs);
  return result;
}

}  // namespace springnet
