#include "check/trial.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include <fmt/format.h>

#include <springnet/formula.hpp>
#include <springnet/host_laws.hpp>

namespace springnet::check {
namespace oscillator {

State State::after(double time) const {
  const double c = std::cos(frequency * time), s = std::sin(frequency * time);
  return {elongation * c + speed / frequency * s, speed * c - elongation * frequency * s};
}

LawUse hooke(double k) { return law_by_formula("k*e", {{"k", k}}); }

State forced(const State& state, double time, double force) {
  State moved = State{state.elongation - force / stiffness, state.speed}.after(time);
  moved.elongation += force / stiffness;
  return moved;
}

}  // namespace oscillator

LawUse law_by_formula(const std::string& force, const ParameterValues& values, const std::string& margin,
                      ComponentKind kind) {
  LawFormula law;
  law.kind = kind;
  law.force = force;
  law.margin = margin;
  for (const std::string& name : parameters_of(law)) law.parameters.push_back({name});
  return law_of(law, values);
}

Network pair(const LawUse& law, const oscillator::State& start, bool free) {
  Network net;
  Node first, second;
  first.mass = second.mass = oscillator::mass;
  first.fixed = !free;
  second.position = Vector3(oscillator::rest + start.elongation, 0.0, 0.0);
  second.velocity = Vector3(start.speed, 0.0, 0.0);
  if (free) first.velocity = Vector3(0.3, -0.2, 0.1);
  net.add_node(first);
  net.add_node(second);
  net.add_spring(0, 1, net.add_material({law, std::nullopt}), oscillator::rest);
  return net;
}

Trial::Trial(const Component& component, const PluginHost& others, bool with_forget)
    : component_(component), host_(std::make_shared<PluginHost>()) {
  if (component.file.empty()) throw std::runtime_error("only integrators in a file can be checked");
  if (with_forget) {
    // As it stands in its file.
    if (!host_->load(component.file)) throw std::runtime_error("its file cannot be loaded again");
  } else {
    springnet_integrator functions{};
    std::memcpy(&functions, &component.integrator(),
                std::min<std::size_t>(component.integrator().struct_size, sizeof functions));
    functions.forget = nullptr;
    functions.struct_size = std::min<std::uint32_t>(functions.struct_size, sizeof functions);
    springnet_component description = *component.description;
    description.implementation = &functions;
    static_cast<void>(
        host_->add(HostComponent(description, component.owner), component.plugin->id, component.plugin->version));
  }
  const auto neuron = others.find(ComponentKind::neuron, "point_mass");
  if (neuron == nullptr) throw std::runtime_error("the neuron 'point_mass' is not installed");
  if (host_->find(ComponentKind::neuron, "point_mass") == nullptr) static_cast<void>(host_->load(neuron->file));
}

Simulation Trial::run(const Network& network, double step, unsigned threads, const ParameterValues& integrator) const {
  SimulationOptions options;
  options.time_step = step;
  options.integrator = {std::string(component_.id()), integrator};
  options.threads = threads;
  options.renumber = false;
  return {network, host_, options};
}

double Trial::smooth_error(double step) const {
  constexpr double amplitude = 0.2, duration = 1.6;
  const oscillator::State start{amplitude, 0.0};
  Simulation simulation = run(pair(oscillator::hooke(), start), step);
  simulation.advance_to(duration);
  return distance(state_of(simulation), start.after(duration)) / amplitude;
}

oscillator::State state_of(const Simulation& simulation) {
  return {simulation.position(1).x() - oscillator::rest, simulation.velocity(1).x()};
}

double distance(const oscillator::State& a, const oscillator::State& b) {
  const double by_position = std::abs(a.elongation - b.elongation),
               by_speed = std::abs(a.speed - b.speed) / oscillator::frequency;
  return by_position <= by_speed ? by_speed : by_position;  // nan comes through
}

std::string bits_of(const Simulation& simulation) {
  std::string bits;
  const auto add = [&](double value) { bits.append(reinterpret_cast<const char*>(&value), sizeof value); };
  add(simulation.time());
  for (NodeIndex k = 0; k < simulation.node_count(); ++k)
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      add(simulation.position(k)[axis]);
      add(simulation.velocity(k)[axis]);
    }
  return bits;
}

bool is_finite(const Simulation& simulation) {
  return std::isfinite(simulation.time()) && simulation.positions().allFinite() && simulation.velocities().allFinite();
}

}  // namespace springnet::check
