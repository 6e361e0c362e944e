#include "check/integrator_checks.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include <springnet/simulation.hpp>

#include "check/child.hpp"

namespace springnet::check {
namespace {

constexpr double stiffness = 4.0, mass = 1.0;  // N/m, kg: 2 rad/s
constexpr double displacement = 0.2;           // m

// The integrator as it stands in its file, beside what else a simulation needs.
std::shared_ptr<const PluginHost> host_with(const Component& component, const PluginHost& others) {
  auto host = std::make_shared<PluginHost>();
  if (component.file.empty() || !host->load(component.file))
    throw std::runtime_error("only integrators in a file can be checked");
  for (const auto& [kind, id] :
       {std::pair(ComponentKind::spring_function, "linear"), std::pair(ComponentKind::neuron, "point_mass")}) {
    const auto other = others.find(kind, id);
    if (other == nullptr) throw std::runtime_error(fmt::format("'{}' is not installed", id));
    static_cast<void>(host->load(other->file));
  }
  return host;
}

// Two nodes on the x axis, `displacement` beyond the rest length of 1 m.
Network pair(bool fixed) {
  Network net;
  Node first, second;
  first.mass = second.mass = mass;
  first.fixed = fixed;
  second.position = Vector3(1.0 + displacement, 0.0, 0.0);
  if (!fixed) first.velocity = Vector3(0.3, -0.2, 0.1);
  net.add_node(first);
  net.add_node(second);
  net.add_spring(0, 1, net.add_material({LawUse{"linear", {{"stiffness", stiffness}}}, std::nullopt}), 1.0);
  return net;
}

Simulation simulation_of(const Component& component, const PluginHost& host, bool fixed, double step) {
  SimulationOptions options;
  options.time_step = step;
  options.integrator = {std::string(component.id()), {}};
  options.threads = 1;
  options.renumber = false;
  return {pair(fixed), host_with(component, host), options};
}

}  // namespace

Outcome check_integrator_call(const Component& component, const PluginHost& host) {
  now_doing("making a step of an oscillator");
  Simulation simulation = simulation_of(component, host, true, 0.01);
  static_cast<void>(simulation.step());
  return {};
}

Outcome check_integrator_order(const Component& component, const PluginHost& host) {
  now_doing("simulating an oscillator");
  constexpr double duration = 1.6;  // s, half of a period
  const double frequency = std::sqrt(stiffness / mass);
  std::array<double, 3> errors{};
  double energy = 0.0;  // at the end, in units of that at the start
  for (std::size_t level = 0; level < errors.size(); ++level) {
    Simulation simulation = simulation_of(component, host, true, 0.02 / static_cast<double>(1 << level));
    simulation.advance_to(duration);
    const double x = simulation.positions()(0, 1) - 1.0, v = simulation.velocities()(0, 1);
    errors[level] = std::abs(x - displacement * std::cos(frequency * duration)) / displacement;
    energy = (stiffness * x * x + mass * v * v) / (stiffness * displacement * displacement);
  }
  const double order = std::log2(errors[1] / errors[2]);
  const std::string numbers =
      fmt::format("with steps of 0.02, 0.01, 0.005 s the error is {:.2g}, {:.2g}, {:.2g} of the amplitude", errors[0],
                  errors[1], errors[2]);
  // An integrator that chooses its steps keeps a tolerance instead: its error does not depend on the time step.
  constexpr double exact = 1e-3;
  const bool declared = (component.description->capabilities & SPRINGNET_CHOOSES_STEPS) != 0;
  if (errors[2] < exact && (declared || std::abs(order) < 0.1))
    return {Result::passed, fmt::format("{}; it chooses its steps{}", numbers,
                                        declared ? "" : ", and may declare SPRINGNET_CHOOSES_STEPS")};
  if (!(order > 0.8))
    return {Result::failed, fmt::format("an oscillator does not approach its closed form: {}", numbers)};
  return {Result::passed,
          fmt::format("order {:.2f}; the energy changes by {:.2g} in half a period with the smallest step", order,
                      energy - 1.0)};
}

Outcome check_integrator_momentum(const Component& component, const PluginHost& host) {
  now_doing("simulating two free masses");
  Simulation simulation = simulation_of(component, host, false, 0.01);
  const Vector3 before = mass * simulation.velocities().rowwise().sum();
  simulation.advance_to(1.0);
  const Vector3 after = mass * simulation.velocities().rowwise().sum();
  // Of what the spring exchanges between the two, up to tolerances of an iteration.
  const double scale = displacement * std::sqrt(stiffness * mass);
  const double change = (after - before).norm() / scale;
  constexpr double tolerance = 1e-6;
  if (!(change <= tolerance))
    return {Result::failed, fmt::format("the momentum of two free masses changes by {:.3g} of what they exchange: each "
                                        "force needs its opposite",
                                        change)};
  return {Result::passed, fmt::format("changes by {:.1g} of what the masses exchange", change)};
}

}  // namespace springnet::check
