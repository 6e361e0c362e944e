#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/inspection.hpp>

#include "inspection/hints.hpp"
#include "inspection/limits.hpp"
#include "inspection/mobility.hpp"
#include "inspection/start.hpp"
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

void inspect_nodes(const StartingNetwork& start, Inspection& result) {
  const Network& network = start.network();
  for (NodeIndex k = 0; k < network.nodes().size(); ++k) {
    const Node& node = network.nodes()[k];
    if (result.mass) {
      result.lower = result.lower.cwiseMin(node.position);
      result.upper = result.upper.cwiseMax(node.position);
    } else {
      result.lower = result.upper = node.position;
    }
    result.total_mass += node.mass;
    widen(result.mass, node.mass);
    result.fixed_nodes += start.is_free(k) ? 0 : 1;
    ++result.neurons[network.neurons()[node.neuron].id];
  }
}

void inspect_springs(const StartingNetwork& start, Inspection& result) {
  const Network& network = start.network();
  const std::vector<SpringAtStart>& springs = start.springs();
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const Spring& spring = network.springs()[s];
    const Material& material = network.materials()[spring.material];
    ++result.spring_functions[material.spring ? material.spring->id : "none"];
    ++result.viscosity_functions[material.viscosity ? material.viscosity->id : "none"];
    widen(result.length, springs[s].length);
    widen(result.rest_length, spring.rest_length);
    if (material.spring) widen(result.stiffness, springs[s].stiffness);
    if (material.viscosity || springs[s].damping() != 0.0) widen(result.damping, springs[s].damping());
    const bool relaxed = std::abs(springs[s].length - spring.rest_length) <= 1e-9 * spring.rest_length;
    result.springs_under_load += material.spring && !relaxed ? 1 : 0;
  }
}

// Fills result.parts; returns the part of each node.
std::vector<std::uint32_t> inspect_parts(const StartingNetwork& start, Inspection& result) {
  constexpr std::uint32_t none = 0xffffffffu;
  const std::vector<std::uint32_t>&first = start.layout().neighbour_start(), &neighbours = start.layout().neighbours();
  const std::vector<std::uint32_t>& user = start.layout().ordering().user;
  std::vector<std::uint32_t> part(user.size(), none);
  std::vector<Part> parts;
  std::vector<NodeIndex> front;
  for (NodeIndex node = 0; node < part.size(); ++node) {
    result.nodes_without_springs += start.has_neighbours(node) ? 0 : 1;
    if (part[node] != none) continue;
    Part next{node};
    const auto number = static_cast<std::uint32_t>(parts.size());
    part[node] = number;
    front.assign(1, node);
    while (!front.empty()) {
      const NodeIndex member = front.back();
      front.pop_back();
      ++next.nodes;
      next.fixed_nodes += start.is_free(member) ? 0 : 1;
      const std::uint32_t k = start.engine_node(member);
      for (std::uint32_t i = first[k]; i < first[k + 1]; ++i) {
        const NodeIndex other = user[neighbours[i]];
        if (part[other] != none) continue;
        part[other] = number;
        front.push_back(other);
      }
    }
    parts.push_back(next);
  }
  for (const Spring& spring : start.network().springs()) ++parts[part[spring.first]].springs;
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

double InspectionOptions::theta() const {
  const auto given = integrator.parameters.find("theta");
  return given != integrator.parameters.end() && given->second > 0.0 ? given->second : 1.0;
}

const TimeConstantLimit& Inspection::limit(std::string_view name) const {
  const auto found = std::find_if(limits.begin(), limits.end(), [&](const auto& each) { return each.name() == name; });
  if (found != limits.end()) return *found;
  throw Error(ErrorKind::input, fmt::format("no integrator has a largest time step under the name '{}'", name));
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
  for (const Element& element : network.elements()) {
    const Material& material = network.materials()[element.material];
    ++result.elements[std::string(name_of(element.invariant))];
    ++result.element_spring_functions[material.spring ? material.spring->id : "none"];
    ++result.element_viscosity_functions[material.viscosity ? material.viscosity->id : "none"];
  }
  const StartingNetwork start(network, plugins);
  inspect_nodes(start, result);
  inspect_springs(start, result);
  const std::vector<std::uint32_t> part = inspect_parts(start, result);
  find_limits(start, plugins, result);
  count_mechanisms(start, part, result);
  result.slowest = slowest_vibration(start, result.mobility);
  result.suspicions = find_suspicions(start);
  result.hints = find_hints(start, part, result);
  // Measured: peak of resident memory of `springnet run` with explicit steps, lattices of 1 to 8 million nodes and a
  // mesh of 1 million; see "What a network takes of memory" in propagation.md.
  constexpr double bytes_at_least = 10e6, bytes_per_node = 220.0, bytes_per_spring = 54.0;
  result.memory_bytes = bytes_at_least + bytes_per_node * static_cast<double>(result.nodes) +
                        bytes_per_spring * static_cast<double>(result.springs);
  return result;
}

}  // namespace springnet
