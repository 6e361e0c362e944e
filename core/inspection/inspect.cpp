#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <nlohmann/json.hpp>
#include <springnet/inspection.hpp>

#include "inspection/linearised.hpp"

namespace springnet {

namespace {

using Json = nlohmann::ordered_json;

void widen(std::optional<Range>& range, double value) {
  if (std::isnan(value)) return;
  if (!range) range = Range{value, value};
  range->smallest = std::min(range->smallest, value);
  range->largest = std::max(range->largest, value);
}

// Union of sets with path halving.
class Parts {
 public:
  explicit Parts(std::size_t count) : parent_(count), parts_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  void join(NodeIndex a, NodeIndex b) {
    a = root(a);
    b = root(b);
    if (a == b) return;
    parent_[std::max(a, b)] = std::min(a, b);
    --parts_;
  }
  [[nodiscard]] std::size_t count() const { return parts_; }

 private:
  NodeIndex root(NodeIndex node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  std::vector<NodeIndex> parent_;
  std::size_t parts_;
};

void inspect_nodes(const Network& network, Inspection& result) {
  for (const Node& node : network.nodes()) {
    if (result.mass) {
      result.lower = result.lower.cwiseMin(node.position);
      result.upper = result.upper.cwiseMax(node.position);
    } else {
      result.lower = result.upper = node.position;
    }
    result.total_mass += node.mass;
    widen(result.mass, node.mass);
    result.fixed_nodes += node.fixed ? 1 : 0;
    ++result.neurons[network.neurons()[node.neuron].id];
  }
}

void inspect_springs(const Network& network, const std::vector<LinearSpring>& linear, Inspection& result) {
  Parts parts(network.nodes().size());
  std::vector<bool> connected(network.nodes().size());
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
    parts.join(spring.first, spring.second);
    connected[spring.first] = connected[spring.second] = true;
  }
  result.parts = parts.count();
  result.nodes_without_springs = static_cast<std::size_t>(std::count(connected.begin(), connected.end(), false));
}

Json json_of(const std::optional<Range>& range) {
  if (!range) return nullptr;
  return {{"smallest", range->smallest}, {"largest", range->largest}};
}

Json json_of(const Vector3& vector) { return Json::array({vector.x(), vector.y(), vector.z()}); }

}  // namespace

Inspection inspect(const Network& network, const PluginHost& plugins) {
  Inspection result;
  result.nodes = network.nodes().size();
  result.springs = network.springs().size();
  result.bodies = network.bodies().size();
  result.planes = network.planes().size();
  result.loads = network.loads().size();
  result.cuts = network.cuts().size();
  for (const LawUse& neuron : network.neurons()) {
    static_cast<void>(plugins.require(ComponentKind::neuron, neuron.id));
  }
  const std::vector<LinearSpring> linear = linearise(network, plugins);
  inspect_nodes(network, result);
  inspect_springs(network, linear, result);
  result.synchronous_time_constant = synchronous_limit(network, linear);
  // Measured: peak of resident memory of `springnet run`, lattices of 0.2 to 1 million nodes with 3 to 13 damped
  // springs a node.
  constexpr double bytes_at_least = 10e6, bytes_per_node = 350.0, bytes_per_spring = 108.0;
  result.memory_bytes = bytes_at_least + bytes_per_node * static_cast<double>(result.nodes) +
                        bytes_per_spring * static_cast<double>(result.springs);
  return result;
}

std::string to_json(const Inspection& inspection) {
  const Json document{
      {"nodes", inspection.nodes},
      {"springs", inspection.springs},
      {"bodies", inspection.bodies},
      {"fixed_nodes", inspection.fixed_nodes},
      {"planes", inspection.planes},
      {"loads", inspection.loads},
      {"cuts", inspection.cuts},
      {"neurons", inspection.neurons},
      {"spring_functions", inspection.spring_functions},
      {"viscosity_functions", inspection.viscosity_functions},
      {"total_mass_kg", inspection.total_mass},
      {"mass_kg", json_of(inspection.mass)},
      {"length_m", json_of(inspection.length)},
      {"rest_length_m", json_of(inspection.rest_length)},
      {"stiffness_n_per_m", json_of(inspection.stiffness)},
      {"damping_ns_per_m", json_of(inspection.damping)},
      {"springs_under_load", inspection.springs_under_load},
      {"lower_m", json_of(inspection.lower)},
      {"upper_m", json_of(inspection.upper)},
      {"parts", inspection.parts},
      {"nodes_without_springs", inspection.nodes_without_springs},
      {"memory_bytes", inspection.memory_bytes},
      {"synchronous_time_constant_s",
       inspection.synchronous_time_constant ? Json(*inspection.synchronous_time_constant) : Json(nullptr)},
  };
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace springnet
