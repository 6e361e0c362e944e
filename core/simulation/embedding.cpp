// Changes of a simulation by the program that embeds it, and the local force models it gives to that program.
#include <springnet/simulation.hpp>

#include <cmath>

#include <fmt/format.h>

#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "simulation/embedding_changes.hpp"
#include "simulation/implementation.hpp"
#include "simulation/local_force.hpp"

namespace springnet {
namespace {

void check_finite(const Vector3& value, std::string_view what) {
  if (!value.allFinite())
    throw Error(ErrorKind::input, fmt::format("{}: ({}, {}, {}) is not finite", what, value[0], value[1], value[2]));
}

}  // namespace

void Simulation::set_force(NodeIndex node, const Vector3& force) {
  check_finite(force, fmt::format("force on node {}", node));
  impl_->between_steps().engine.model().loads.set_host_force(impl_->engine_node(node), force);
  impl_->engine.model().changed();
}
void Simulation::set_gravity(const Vector3& acceleration) {
  check_finite(acceleration, "gravity");
  impl_->between_steps().engine.model().loads.set_gravity(acceleration);
  impl_->engine.model().changed();
}
void Simulation::set_load_factor(std::size_t load, double factor) {
  static_cast<void>(load_factor(load));
  if (!std::isfinite(factor))
    throw Error(ErrorKind::input, fmt::format("the factor of load {} is {}; give a finite one", load, factor));
  Model& model = impl_->between_steps().engine.model();
  model.loads.set_factor(load, factor);
  model.changed();
}
double Simulation::load_factor(std::size_t load) const {
  const Loads& loads = impl_->engine.model().loads;
  if (load >= loads.count())
    throw Error(ErrorKind::input, fmt::format("load {} does not exist: the network has {}", load, loads.count()));
  return loads.factor(load);
}
Friction Simulation::surface_friction(std::size_t surface) const { return impl_->surface(surface).friction(); }
void Simulation::set_friction(std::size_t surface, double coefficient) {
  if (surface_friction(surface).kind != Friction::Kind::coulomb)
    throw Error(ErrorKind::input,
                fmt::format("{} has no coefficient of friction: give the network one (Friction::Kind::coulomb)",
                            impl_->engine.model().contact.name_of(surface)));
  if (!(coefficient >= 0.0 && std::isfinite(coefficient)))
    throw Error(ErrorKind::input, fmt::format("the coefficient of friction of {} is {}; give a finite one of 0 or more",
                                              impl_->engine.model().contact.name_of(surface), coefficient));
  Model& model = impl_->between_steps().engine.model();
  model.contact.set_friction(surface, coefficient);
  model.changed();
}
void Simulation::set_input(InputIndex input, double value) {
  Model& model = impl_->between_steps().engine.model();
  layers::check_input_value(impl_->input(input).readers, value, fmt::format("value of input signal {}:", input));
  model.layout.signals().hold(input, value);
  model.changed();
}
void Simulation::set_input(std::string_view name, double value) {
  const auto& inputs = impl_->engine.model().layout.laws().inputs;
  for (InputIndex k = 0; k < inputs.size(); ++k)
    if (!name.empty() && inputs[k].name == name) return set_input(k, value);
  std::vector<std::string> known;
  for (const auto& input : inputs)
    if (!input.name.empty()) known.push_back(input.name);
  const std::string nearest = suggestion(name, known);
  throw Error(ErrorKind::input,
              fmt::format("there is no input signal '{}'; {}", printable(std::string(name)),
                          known.empty()     ? std::string("none has a name: give it one, or use its number")
                          : nearest.empty() ? fmt::format("{} have other names, as '{}'", known.size(), known.front())
                                            : nearest));
}
double Simulation::input_value(InputIndex input) const {
  static_cast<void>(impl_->input(input));
  return impl_->engine.model().layout.signals().at(input, time());
}
void Simulation::set_position(NodeIndex node, const Vector3& position) {
  check_finite(position, fmt::format("position of node {}", node));
  const std::uint32_t k = impl_->engine_node(node);
  const Contact& contact = impl_->engine.model().contact;
  for (std::size_t j = 0; j < contact.obstacles().size() && contact.fixed()[k] == 0; ++j) {
    const double distance = contact.obstacles()[j].gap(impl_->pose(j), position);
    if (distance < 0.0)
      throw Error(ErrorKind::input,
                  fmt::format("position of node {}: it is {:.3g} m {} {}; move it outside, or fix the node first", node,
                              -distance, contact.obstacles()[j].is_plane() ? "behind" : "inside", contact.name_of(j)));
  }
  springnet::set_node(impl_->changed_state(), k, position, std::nullopt);
  impl_->changed();
}
void Simulation::set_velocity(NodeIndex node, const Vector3& velocity) {
  check_finite(velocity, fmt::format("velocity of node {}", node));
  const std::uint32_t k = impl_->engine_node(node);
  if (impl_->engine.model().contact.fixed()[k] != 0)
    throw Error(ErrorKind::input,
                fmt::format("node {} is fixed and has no velocity; set_fixed(node, false) first", node));
  springnet::set_node(impl_->changed_state(), k, std::nullopt, velocity);
  impl_->changed();
}
void Simulation::set_fixed(NodeIndex node, bool fixed) {
  springnet::set_fixed(impl_->changed_state(), impl_->engine_node(node), fixed);
  impl_->changed();
}
void Simulation::move_surface(std::size_t surface, const Vector3& position, double time) {
  impl_->check_surface_index(surface);
  impl_->check_arrival(position, time);
  springnet::move_surface(impl_->between_steps().engine.model(), surface, position, time);
}
void Simulation::move_node(NodeIndex node, const Vector3& position, double time) {
  impl_->check_arrival(position, time);
  springnet::move_node(impl_->between_steps().engine.model(), impl_->engine_node(node), position, time);
}
LocalForce Simulation::local_force(NodeIndex node, double over) {
  const std::uint32_t k = impl_->engine_node(node);
  if (impl_->engine.model().contact.fixed()[k] == 0)
    throw Error(ErrorKind::input, fmt::format("node {} is free: nothing holds it; set_fixed or move_node first", node));
  const double step = impl_->outside_of_steps().local_time(over);
  return {time(), position(node), -reaction(node), impl_->engine.local_force().stiffness_of_node(k, step)};
}
LocalForce Simulation::local_surface_force(std::size_t surface, double over) {
  impl_->check_surface_index(surface);
  const double step = impl_->outside_of_steps().local_time(over);
  return {time(), surface_position(surface), surface_force(surface),
          impl_->engine.local_force().stiffness_of_surface(surface, step)};
}
std::size_t Simulation::cut(const std::vector<SpringIndex>& springs) {
  for (const SpringIndex s : springs) impl_->check_spring(s);
  const std::size_t removed = impl_->between_steps().engine.topology().cut(springs);
  impl_->changed();
  return removed;
}
std::size_t Simulation::cut_polygon(const std::vector<Vector3>& corners) {
  const std::size_t removed = impl_->between_steps().engine.topology().cut(CuttingPolygon(corners));
  impl_->changed();
  return removed;
}

}  // namespace springnet
