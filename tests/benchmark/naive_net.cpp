#include "naive_net.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet::benchmark {
namespace {

[[noreturn]] void refuse(std::string_view what) {
  throw Error(ErrorKind::input, fmt::format("the naive net has no {}; take a net without, or add it to naive.c", what));
}

bool is(const layers::Law& law, std::string_view id) { return law.component->description->id == id; }

// A law's parameter in a row of its group; 0 without a law.
double parameter(const layers::Group& group, const layers::Law& law, const char* name, std::uint32_t row) {
  if (!law) return 0.0;
  const auto place = static_cast<std::size_t>(parameter_index(*law.component->description, name));
  return group.columns[law.first_column + place][row];
}

int number(std::uint32_t node) { return static_cast<int>(node); }

}  // namespace

PlainNet::PlainNet(const Network& network, const layers::Layout& layout, Order order) {
  take_nodes(network, layout);
  take_springs(layout);
  take_elements(network, layout);
  if (order == Order::file) number_as_file(network, layout);
  net_.nodes = nodes_.data();
  net_.node_count = static_cast<int>(nodes_.size());
  net_.springs = springs_.data();
  net_.spring_count = static_cast<int>(springs_.size());
  net_.hinges = hinges_.data();
  net_.hinge_count = static_cast<int>(hinges_.size());
  net_.triangles = triangles_.data();
  net_.triangle_count = static_cast<int>(triangles_.size());
  for (int i = 0; i < 3; ++i) net_.gravity[i] = network.gravity()[i];
}

void PlainNet::take_nodes(const Network& network, const layers::Layout& layout) {
  nodes_.resize(layout.node_count());
  for (std::uint32_t k = 0; k < layout.node_count(); ++k) {
    const Node& node = network.nodes()[layout.ordering().user[k]];
    if (layout.neuron_kind()[k] != layout.neuron_kind()[0]) refuse("nodes of several neurons");
    for (int i = 0; i < 3; ++i) {
      nodes_[k].position[i] = node.position[i];
      nodes_[k].velocity[i] = node.fixed ? 0.0 : node.velocity[i];
      nodes_[k].force[i] = 0.0;
    }
    nodes_[k].inverse_mass = node.fixed ? 0.0 : 1.0 / node.mass;
  }
  for (const Move& move : network.moves()) {
    for (const NodeIndex user : move.nodes) {
      NaiveNode& node = nodes_[layout.ordering().engine[user]];
      node.inverse_mass = 0.0;
      for (double& component : node.velocity) component = 0.0;
    }
  }
  if (nodes_.empty()) return;
  const layers::NeuronKind& neuron = layout.laws().neurons[layout.neuron_kind()[0]];
  const std::string_view id = neuron.component->description->id;
  if (id == "dragged") {
    net_.drag = neuron.parameters[0];
  } else if (id != "point_mass") {
    refuse(fmt::format("neuron '{}'", id));
  }
}

void PlainNet::take_springs(const layers::Layout& layout) {
  springs_.reserve(layout.live_count());
  for (const layers::Unit& unit : layout.units()) {
    for (const std::uint32_t s : unit.spring) {
      if (s == layers::no_spring) continue;
      const auto [first, second] = std::minmax({layout.first(s), layout.second(s)});
      if (first < unit.first_node) continue;  // it is in an earlier unit as well
      take_spring(layout, first, second, s);
    }
  }
  if (relative_ > 0 && relative_ < springs_.size()) refuse("springs of both 'linear' and 'relative' viscosity");
  net_.relative_damping = relative_ > 0 ? 1 : 0;
}

void PlainNet::take_spring(const layers::Layout& layout, std::uint32_t first, std::uint32_t second,
                           std::uint32_t spring) {
  const layers::Group& group = layout.group_of(spring);
  if (!group.spring || !(is(group.spring, "linear") || is(group.spring, "rupturing")))
    refuse("springs that are neither 'linear' nor 'rupturing'");
  if (group.viscosity && !(is(group.viscosity, "linear") || is(group.viscosity, "relative")))
    refuse("viscosity but 'linear' and 'relative'");
  const std::uint32_t row = layout.laws().row[spring];
  springs_.push_back({number(first), number(second), parameter(group, group.spring, "stiffness", row),
                      parameter(group, group.viscosity, "damping", row), group.columns[0][row]});
  if (group.viscosity.relative) ++relative_;
}

// Springs alone: hinges and triangles keep the engine's numbers.
void PlainNet::number_as_file(const Network& network, const layers::Layout& layout) {
  if (!network.elements().empty()) refuse("elements in the order of the file");
  std::vector<NaiveNode> nodes(nodes_.size());
  for (std::uint32_t k = 0; k < nodes_.size(); ++k) nodes[layout.ordering().user[k]] = nodes_[k];
  nodes_ = std::move(nodes);
  springs_.clear();
  for (std::uint32_t s = 0; s < layout.spring_count(); ++s)
    take_spring(layout, network.springs()[s].first, network.springs()[s].second, s);
}

void PlainNet::take_elements(const Network& network, const layers::Layout& layout) {
  const layers::ElementLayout& elements = layout.elements();
  const auto stiffness = [&](std::uint32_t e) {
    const layers::Group& group = layout.laws().groups[elements.group(e)];
    if (!group.spring || !is(group.spring, "linear") || group.viscosity) refuse("elements that are not linear springs");
    return parameter(group, group.spring, "stiffness", elements.row(e));
  };
  for (const std::uint32_t e : elements.batched()) {
    if (elements.invariant(e) != Invariant::dihedral) refuse("elements but hinges and one enclosed volume");
    const auto corners = elements.nodes(e);
    hinges_.push_back({{number(corners[0]), number(corners[1]), number(corners[2]), number(corners[3])},
                       stiffness(e),
                       elements.reference(e)});
  }
  if (elements.live_enclosures() > 1) refuse("second enclosed volume");
  for (const auto& enclosure : elements.enclosures()) {
    net_.filling_stiffness = stiffness(enclosure.element);
    net_.rest_volume = elements.reference(enclosure.element);
    const std::vector<NodeIndex>& corners = network.elements()[enclosure.element].nodes;
    const std::vector<std::uint32_t>& engine = layout.ordering().engine;
    for (std::size_t t = 0; t < corners.size(); t += 3) {
      triangles_.push_back(
          {{number(engine[corners[t]]), number(engine[corners[t + 1]]), number(engine[corners[t + 2]])}});
    }
  }
}

}  // namespace springnet::benchmark
