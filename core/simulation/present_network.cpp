#include "simulation/present_network.hpp"

#include <bit>
#include <map>
#include <string>
#include <utility>

#include "constraints/vectors.hpp"
#include "simulation/implementation.hpp"
#include "simulation/later.hpp"

namespace springnet {
namespace {

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

// The new network's copies of materials and neurons, with the values that parameters have now.
class Laws {
 public:
  Laws(const Network& network, const layers::CompiledLaws& laws, Network& result)
      : network_(network), laws_(laws), result_(result), same_(network.materials().size(), none) {}

  // Of a spring or element of this material whose values are in a row of a group.
  MaterialIndex material(MaterialIndex number, std::uint32_t group, std::uint32_t row) {
    const layers::Group& values = laws_.groups[group];
    const Material& given = network_.materials()[number];
    if (is_as_given(values, values.spring, row, given.spring) &&
        is_as_given(values, values.viscosity, row, given.viscosity)) {
      if (same_[number] == none) same_[number] = result_.add_material(given);
      return same_[number];
    }
    Material changed = given;
    if (changed.spring) take(values, values.spring, row, *changed.spring);
    if (changed.viscosity) take(values, values.viscosity, row, *changed.viscosity);
    return result_.add_material(changed);
  }
  std::uint32_t neuron(std::uint32_t number, const layers::NeuronKind& now) {
    LawUse use = network_.neurons()[number];
    take_values(
        *now.component->description, [&](std::size_t i) { return now.parameters[i]; }, use);
    return result_.add_neuron(use);
  }

 private:
  static constexpr MaterialIndex none = 0xffffffffu;

  // Calls differs(parameter, present value) for each that is not what the use says, or the default.
  template <class Value, class Differs>
  static void compare(const springnet_component& component, const Value& value, const LawUse& use,
                      const Differs& differs) {
    for (std::uint32_t i = 0; i < component.parameter_count; ++i) {
      const springnet_parameter& declared = *component.parameters[i];
      const auto given = use.parameters.find(std::string_view(declared.name));
      if (!same_bits(given != use.parameters.end() ? given->second : declared.default_value, value(i)))
        differs(declared, value(i));
    }
  }
  template <class Value>
  static void take_values(const springnet_component& component, const Value& value, LawUse& use) {
    std::vector<std::pair<const char*, double>> changed;
    compare(component, value, use,
            [&](const springnet_parameter& each, double now) { changed.emplace_back(each.name, now); });
    for (const auto& [name, now] : changed) use.parameters[name] = now;
  }
  static bool is_as_given(const layers::Group& group, const layers::Law& law, std::uint32_t row,
                          const std::optional<LawUse>& use) {
    bool same = true;
    if (law && use)
      compare(
          *law.component->description, [&](std::size_t i) { return group.columns[law.first_column + i][row]; }, *use,
          [&](const springnet_parameter&, double) { same = false; });
    return same;
  }
  static void take(const layers::Group& group, const layers::Law& law, std::uint32_t row, LawUse& use) {
    if (!law) return;
    take_values(
        *law.component->description, [&](std::size_t i) { return group.columns[law.first_column + i][row]; }, use);
  }

  const Network& network_;
  const layers::CompiledLaws& laws_;
  Network& result_;
  std::vector<MaterialIndex> same_;  // [material] that has no changes; none: not added yet
};

// Springs and elements that read a signal which no input of the network gives them.
class SetInputs {
 public:
  SetInputs(const Network& network, const layers::Layout& layout, double time)
      : network_(network), layout_(layout), time_(time) {}

  void note(std::uint32_t group, std::uint32_t row, std::uint32_t number, bool element) {
    const layers::Group& values = layout_.laws().groups[group];
    for (const layers::Law* law : values.laws())
      for (std::size_t i = 0; *law && i < law->input_count; ++i) {
        const auto signal = static_cast<std::uint32_t>(values.columns[law->first_input_column + i][row]);
        if (signal < network_.inputs().size()) continue;
        const springnet_parameter& declared = *law->component->law().inputs[i];
        const double value = layout_.laws().signals->at(signal, time_);
        if (same_bits(value, declared.default_value) && network_.inputs().empty()) continue;
        Input& input = by_value_[{declared.name, std::bit_cast<std::uint64_t>(value)}];
        input.input = declared.name;
        input.signal.mean = value;
        (element ? input.elements : input.springs).push_back(number);
      }
  }
  void add_to(Network& result) const {
    for (const auto& [key, input] : by_value_) result.add_input(input);
  }

 private:
  const Network& network_;
  const layers::Layout& layout_;
  double time_;
  std::map<std::pair<std::string, std::uint64_t>, Input> by_value_;
};

class Builder {
 public:
  Builder(const Network& network, Engine& engine, const std::vector<std::uint8_t>& torn)
      : network_(network),
        engine_(engine),
        layout_(engine.model().layout),
        torn_(torn),
        laws_(network, layout_.laws(), result_),
        set_(network, layout_, engine.model().time) {}

  Network build() {
    numbers_.spring.assign(network_.springs().size(), NewNumbers::removed);
    numbers_.element.assign(network_.elements().size(), NewNumbers::removed);
    result_.reserve_nodes(network_.nodes().size());
    result_.reserve_springs(layout_.live_count());
    for (const Body& body : network_.bodies()) {
      add_until(body.first_node, body.first_spring, body.first_element, body.first_face);
      result_.begin_body(body.name);
      add_until(body.first_node + body.node_count, body.first_spring + body.spring_count,
                body.first_element + body.element_count, body.first_face + body.face_count);
      for (const NodeGroup& group : body.groups) result_.add_group(group.name, group.nodes);
      result_.end_body();
      result_.set_extent(result_.bodies().size() - 1, body.thickness, body.radius);
    }
    add_until(network_.nodes().size(), network_.springs().size(), network_.elements().size(), network_.faces().size());
    add_rigids();
    add_inputs();
    add_surroundings(network_, engine_, numbers_, result_);
    return std::move(result_);
  }

 private:
  void add_until(std::size_t nodes, std::size_t springs, std::size_t elements, std::size_t faces) {
    for (; node_ < nodes; ++node_) add_node(static_cast<NodeIndex>(node_));
    for (; spring_ < springs; ++spring_) add_spring(static_cast<SpringIndex>(spring_));
    for (; element_ < elements; ++element_) add_element(static_cast<ElementIndex>(element_));
    for (; face_ < faces; ++face_)
      if (torn_[face_] == 0) result_.add_face(network_.faces()[face_]);
  }

  void add_node(NodeIndex k) {
    const Model& model = engine_.model();
    const std::uint32_t at = layout_.ordering().engine[k];
    Node node = network_.nodes()[k];
    node.position = vector_at(model.state.view.position, at);
    node.fixed = model.contact.fixed()[at] != 0;
    node.velocity = node.fixed ? Vector3(Vector3::Zero()) : vector_at(model.state.view.velocity, at);
    node.mass = model.mass[at];
    node.neuron = laws_.neuron(node.neuron, layout_.laws().neurons[layout_.neuron_kind()[at]]);
    result_.add_node(node);
  }

  void add_spring(SpringIndex s) {
    if (!layout_.alive(s)) return;
    const Spring spring = network_.springs()[s];
    const std::uint32_t group = layout_.laws().group[s], row = layout_.laws().row[s];
    const double rest_length = layout_.group_of(s).columns[0][row];
    numbers_.spring[s] =
        result_.add_spring(spring.first, spring.second, laws_.material(spring.material, group, row), rest_length);
    set_.note(group, row, numbers_.spring[s], false);
  }

  void add_element(ElementIndex e) {
    const layers::ElementLayout& elements = layout_.elements();
    if (!elements.alive(e)) return;
    const Element& element = network_.elements()[e];
    const MaterialIndex material = laws_.material(element.material, elements.group(e), elements.row(e));
    numbers_.element[e] =
        reads_several(element.invariant)
            ? result_.add_element(element.invariant, element.nodes, material, element.rest, element.direction)
            : result_.add_element(element.invariant, element.nodes, material, elements.reference(e));
    set_.note(elements.group(e), elements.row(e), numbers_.element[e], true);
  }

  void add_rigids() {
    for (const Rigid& rigid : network_.rigids()) {
      const double distance = (result_.nodes()[rigid.second].position - result_.nodes()[rigid.first].position).norm();
      // What the run has left of its length within the tolerance of a network.
      const bool exact = std::abs(distance - rigid.length) <= 0.5e-8 * rigid.length;
      result_.add_rigid(rigid.first, rigid.second, exact ? std::optional<double>(rigid.length) : std::nullopt);
    }
  }

  void add_inputs() {
    const double time = engine_.model().time;
    const layers::Signals& signals = *layout_.laws().signals;
    for (InputIndex k = 0; k < network_.inputs().size(); ++k) {
      const Input& given = network_.inputs()[k];
      Input input{given.input, given.name, {}, {}, later(given.signal, time)};
      if (signals.is_held(k)) {
        input.signal = {};
        input.signal.mean = signals.at(k, time);
      }
      for (const SpringIndex s : given.springs)
        if (numbers_.spring[s] != NewNumbers::removed) input.springs.push_back(numbers_.spring[s]);
      for (const ElementIndex e : given.elements)
        if (numbers_.element[e] != NewNumbers::removed) input.elements.push_back(numbers_.element[e]);
      if (!input.springs.empty() || !input.elements.empty()) result_.add_input(input);
    }
    set_.add_to(result_);
  }

  const Network& network_;
  Engine& engine_;
  const layers::Layout& layout_;
  const std::vector<std::uint8_t>& torn_;
  Network result_;
  Laws laws_;
  SetInputs set_;
  NewNumbers numbers_;
  std::size_t node_ = 0, spring_ = 0, element_ = 0, face_ = 0;  // the next ones of the given network
};

}  // namespace

Network present_network(const Network& network, Engine& engine, const std::vector<std::uint8_t>& torn) {
  return Builder(network, engine, torn).build();
}

Network Simulation::present_network() const {
  const std::vector<std::uint8_t>& torn = impl_->torn_faces.of(*impl_->network, impl_->engine.model().layout);
  return springnet::present_network(*impl_->network, impl_->engine, torn);
}

}  // namespace springnet
