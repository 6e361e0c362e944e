// call, order, momentum, states: whether an integrator solves the equations of motion.
#include "check/integrator_checks.hpp"

#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include <springnet/formula.hpp>

#include "check/child.hpp"
#include "check/trial.hpp"

namespace springnet::check {
namespace {

constexpr double amplitude = 0.2;  // m

// An integrator that chooses its steps keeps a tolerance instead: its error does not depend on the time step.
constexpr double exact = 1e-3;
bool is_independent(const Trial& trial, double error, double order) {
  return error < exact && (trial.declares(SPRINGNET_CHOOSES_STEPS) || std::abs(order) < 0.1);
}

}  // namespace

Outcome check_integrator_call(const Component& component, const PluginHost& host) {
  now_doing("making a step of an oscillator");
  Simulation simulation = Trial(component, host).run(pair(oscillator::hooke(), {amplitude, 0.0}), 0.01);
  static_cast<void>(simulation.step());
  return {};
}

Outcome check_integrator_order(const Component& component, const PluginHost& host) {
  now_doing("simulating an oscillator");
  const Trial trial(component, host);
  constexpr double duration = 1.6;  // s, half of a period
  const oscillator::State start{amplitude, 0.0};
  std::array<double, 3> errors{};
  double energy = 0.0;  // at the end, in units of that at the start
  for (std::size_t level = 0; level < errors.size(); ++level) {
    Simulation simulation = trial.run(pair(oscillator::hooke(), start), 0.02 / static_cast<double>(1 << level));
    simulation.advance_to(duration);
    const oscillator::State end = state_of(simulation);
    errors[level] = distance(end, start.after(duration)) / amplitude;
    energy = (oscillator::stiffness * end.elongation * end.elongation + oscillator::mass * end.speed * end.speed) /
             (oscillator::stiffness * amplitude * amplitude);
  }
  const double order = std::log2(errors[1] / errors[2]);
  const std::string numbers =
      fmt::format("with steps of 0.02, 0.01, 0.005 s the error is {:.2g}, {:.2g}, {:.2g} of the amplitude", errors[0],
                  errors[1], errors[2]);
  if (is_independent(trial, errors[2], order))
    return {Result::passed,
            fmt::format("{}; it chooses its steps{}", numbers,
                        trial.declares(SPRINGNET_CHOOSES_STEPS) ? "" : ", and may declare SPRINGNET_CHOOSES_STEPS")};
  if (!(order > 0.8))
    return {Result::failed, fmt::format("an oscillator does not approach its closed form: {}", numbers)};
  return {Result::passed,
          fmt::format("order {:.2f}; the energy changes by {:.2g} in half a period with the smallest step", order,
                      energy - 1.0)};
}

Outcome check_integrator_momentum(const Component& component, const PluginHost& host) {
  now_doing("simulating two free masses");
  Simulation simulation = Trial(component, host).run(pair(oscillator::hooke(), {amplitude, 0.0}, true), 0.01);
  const Vector3 before = simulation.momentum();
  simulation.advance_to(1.0);
  // Of what the spring exchanges between the two, up to tolerances of an iteration.
  const double scale = amplitude * std::sqrt(oscillator::stiffness * oscillator::mass);
  const double change = (simulation.momentum() - before).norm() / scale;
  constexpr double tolerance = 1e-6;
  if (!(change <= tolerance))
    return {Result::failed, fmt::format("the momentum of two free masses changes by {:.3g} of what they exchange: each "
                                        "force needs its opposite",
                                        change)};
  return {Result::passed, fmt::format("changes by {:.1g} of what the masses exchange", change)};
}

// Held at an elongation x, a dashpot in series with a spring follows as z = x (1 - exp(-t / tau)).
Outcome check_integrator_states(const Component& component, const PluginHost& host) {
  const Trial trial(component, host);
  if (!trial.declares(SPRINGNET_INTEGRATES_STATES))
    return {Result::passed, "declares that it integrates none, so that networks with them are refused"};
  now_doing("relaxing a spring and a dashpot in series");
  constexpr double tau = 0.5, duration = 0.8, elongation = 0.2;
  LawFormula law;
  law.force = "k*(e - flow)";
  law.parameters = {{"k"}, {"tau"}};
  law.states = {{"flow", "(e - flow)/tau"}};
  const LawUse maxwell = law_of(law, {{"k", oscillator::stiffness}, {"tau", tau}});
  // A third node, on a spring of its own, so that something moves.
  Network net = pair(maxwell, {elongation, 0.0});
  net.fix(1);
  Node third;
  third.position = Vector3(0.0, 1.1, 0.0);
  net.add_node(third);
  net.add_spring(0, 2, net.add_material({oscillator::hooke(), std::nullopt}), 1.0);
  const double expected = elongation * (1.0 - std::exp(-duration / tau));
  std::array<double, 3> errors{};
  for (std::size_t level = 0; level < errors.size(); ++level) {
    Simulation simulation = trial.run(net, 0.04 / static_cast<double>(1 << level));
    simulation.advance_to(duration);
    errors[level] = std::abs(simulation.internal_states(0).at(0) - expected) / elongation;
  }
  const double order = std::log2(errors[1] / errors[2]);
  constexpr double rounding = 1e-9;
  if (errors[2] < rounding || is_independent(trial, errors[2], order))
    return {Result::passed, "exact to its tolerance"};
  if (!(order > 0.8))
    return {Result::failed,
            fmt::format("the state of a Maxwell element does not approach its closed form: with steps of 0.04, 0.02, "
                        "0.01 s it is off by {:.2g}, {:.2g}, {:.2g} of its limit: step the states of laws, or do not "
                        "declare SPRINGNET_INTEGRATES_STATES",
                        errors[0], errors[1], errors[2])};
  return {Result::passed, fmt::format("order {:.2f}", order)};
}

}  // namespace springnet::check
