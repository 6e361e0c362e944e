// Simulation's changes of laws, neurons, rest states and masses, the present values, and removals.
#include <springnet/simulation.hpp>

#include <string_view>
#include <vector>

#include "simulation/implementation.hpp"
#include "simulation/law_setting.hpp"

namespace springnet {

void Simulation::set_parameter(const std::vector<SpringIndex>& springs, ComponentKind law, std::string_view parameter,
                               const std::vector<double>& values) {
  for (const SpringIndex s : springs) impl_->check_spring(s);
  Engine& engine = impl_->between_steps().engine;
  set_values(engine, {engine.model().layout, false}, springs, {law, parameter, false}, values);
}
void Simulation::set_element_parameter(const std::vector<ElementIndex>& elements, ComponentKind law,
                                       std::string_view parameter, const std::vector<double>& values) {
  for (const ElementIndex e : elements) impl_->check_element(e);
  Engine& engine = impl_->between_steps().engine;
  set_values(engine, {engine.model().layout, true}, elements, {law, parameter, false}, values);
}
void Simulation::set_law_input(const std::vector<SpringIndex>& springs, ComponentKind law, std::string_view input,
                               const std::vector<double>& values) {
  for (const SpringIndex s : springs) impl_->check_spring(s);
  Engine& engine = impl_->between_steps().engine;
  set_values(engine, {engine.model().layout, false}, springs, {law, input, true}, values);
}
void Simulation::set_element_input(const std::vector<ElementIndex>& elements, ComponentKind law, std::string_view input,
                                   const std::vector<double>& values) {
  for (const ElementIndex e : elements) impl_->check_element(e);
  Engine& engine = impl_->between_steps().engine;
  set_values(engine, {engine.model().layout, true}, elements, {law, input, true}, values);
}
void Simulation::set_rest_lengths(const std::vector<SpringIndex>& springs, const std::vector<double>& values) {
  for (const SpringIndex s : springs) impl_->check_spring(s);
  Engine& engine = impl_->between_steps().engine;
  springnet::set_references(engine, {engine.model().layout, false}, springs, values);
}
void Simulation::set_references(const std::vector<ElementIndex>& elements, const std::vector<double>& values) {
  for (const ElementIndex e : elements) impl_->check_element(e);
  Engine& engine = impl_->between_steps().engine;
  springnet::set_references(engine, {engine.model().layout, true}, elements, values);
}
void Simulation::set_neuron_parameter(const std::vector<NodeIndex>& nodes, std::string_view parameter,
                                      const std::vector<double>& values) {
  for (const NodeIndex node : nodes) static_cast<void>(impl_->engine_node(node));
  set_neurons(impl_->between_steps().engine, nodes, parameter, values);
}
void Simulation::set_masses(const std::vector<NodeIndex>& nodes, const std::vector<double>& values) {
  for (const NodeIndex node : nodes) static_cast<void>(impl_->engine_node(node));
  springnet::set_masses(impl_->between_steps().engine, nodes, values);
}

double Simulation::parameter(SpringIndex spring, ComponentKind law, std::string_view parameter) const {
  impl_->check_spring(spring);
  return value_of({impl_->engine.model().layout, false}, spring, {law, parameter, false});
}
double Simulation::element_parameter(ElementIndex element, ComponentKind law, std::string_view parameter) const {
  impl_->check_element(element);
  return value_of({impl_->engine.model().layout, true}, element, {law, parameter, false});
}
double Simulation::neuron_parameter(NodeIndex node, std::string_view parameter) const {
  static_cast<void>(impl_->engine_node(node));
  return neuron_value(impl_->engine.model().layout, node, parameter);
}
double Simulation::rest_length(SpringIndex spring) const {
  impl_->check_spring(spring);
  return Members{impl_->engine.model().layout, false}.value(spring, 0);
}
double Simulation::reference(ElementIndex element) const {
  impl_->check_element(element);
  return impl_->engine.model().layout.elements().reference(element);
}
double Simulation::mass(NodeIndex node) const { return impl_->engine.model().mass[impl_->engine_node(node)]; }

std::size_t Simulation::remove_elements(const std::vector<ElementIndex>& elements) {
  for (const ElementIndex e : elements) impl_->check_element(e);
  const std::size_t removed = impl_->between_steps().engine.topology().remove_elements(elements);
  impl_->changed();
  return removed;
}
void Simulation::remove_nodes(const std::vector<NodeIndex>& nodes) {
  for (const NodeIndex node : nodes) static_cast<void>(impl_->engine_node(node));
  static_cast<void>(impl_->changed_state());
  springnet::remove_nodes(impl_->engine, nodes);
  impl_->changed();
}
void Simulation::set_integrator(const LawUse& integrator) { impl_->between_steps().exchange(integrator); }

}  // namespace springnet
