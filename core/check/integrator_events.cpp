// events, contact, rigid: what happens between the ends of steps, and what restricts nodes.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include <fmt/format.h>

#include <springnet/formula.hpp>

#include "check/child.hpp"
#include "check/integrator_checks.hpp"
#include "check/trial.hpp"

namespace springnet::check {
namespace {

using oscillator::State;

constexpr double step = 0.02;  // s; events below are at no multiple of it

// How far a state may be off. A method that leaves events to the ends of steps is late by up to one.
struct Allowed {
  double smooth;  // m, of the method without events: ten times its error
  bool locates;   // declared
  [[nodiscard]] double by(double late) const { return smooth + (locates ? 1e-6 : late); }
};
Allowed allowed_by(const Trial& trial) {
  constexpr double length = 0.3;  // m, of the motions below
  return {10.0 * length * trial.smooth_error(step) + 1e-6, trial.declares(SPRINGNET_LOCATES_EVENTS)};
}

std::string off(const char* what, double error, double allowed) {
  return fmt::format("{} the state is off by {:.3g} m, of which the step of {:g} s and the method explain {:.2g}", what,
                     error, step, allowed);
}

std::size_t count(const Simulation& simulation, Event::Kind kind) {
  return static_cast<std::size_t>(std::count_if(simulation.events().begin(), simulation.events().end(),
                                                [&](const Event& event) { return event.kind == kind; }));
}

const Event* first(const Simulation& simulation, Event::Kind kind) {
  for (const Event& event : simulation.events())
    if (event.kind == kind) return &event;
  return nullptr;
}

// Empty if an event is where it should be. error: of the method in time, s.
std::string event_at(const Trial& trial, const Event& event, double expected, double error, const char* what) {
  const double late = trial.declares(SPRINGNET_LOCATES_EVENTS) ? 0.1 * step : 1.001 * step;
  if (std::abs(event.time - expected) > late + error)
    return fmt::format("{} at {:.6g} s is told at {:.6g} s", what, expected, event.time);
  const double steps = event.time / step;
  if (trial.declares(SPRINGNET_LOCATES_EVENTS) && std::abs(steps - std::round(steps)) < 1e-9)
    return fmt::format(
        "it declares SPRINGNET_LOCATES_EVENTS, but {} at {:.6g} s takes place at the end of a step, {:.6g} s", what,
        expected, event.time);
  return {};
}

// Loads are averaged over steps, so that a jump between their ends costs no order.
std::string load(const Trial& trial, const Allowed& allowed) {
  constexpr double from = 0.373, duration = 1.2, force = 1.0;
  const State start{0.2, 0.0};
  Network net = pair(oscillator::hooke(), start);
  Load push;
  push.nodes = {1};
  push.force = Vector3(force, 0.0, 0.0);
  push.from = from;
  net.add_load(push);
  Simulation simulation = trial.run(net, step);
  simulation.advance_to(duration);
  const State end = oscillator::forced(start.after(from), duration - from, force);
  const double error = distance(state_of(simulation), end);
  const double explained = allowed.smooth + 2.0 * force / oscillator::mass * step * step;
  return error <= explained ? "" : off("after a load that begins within a step", error, explained);
}

// The same by an input signal of the law, which jumps.
std::string signal(const Trial& trial, const Allowed& allowed) {
  constexpr double from = 0.373, duration = 1.2, force = 1.0;
  const State start{0.2, 0.0};
  LawFormula law;
  law.force = "k*e - drive";
  law.parameters = {{"k"}};
  law.inputs = {{"drive"}};
  Network net = pair(law_of(law, {{"k", oscillator::stiffness}}), start);
  Input drive;
  drive.input = "drive";
  drive.springs = {0};
  drive.signal.interpolation = Signal::Interpolation::hold;
  drive.signal.times = {0.0, from};
  drive.signal.values = {0.0, force};
  net.add_input(drive);
  Simulation simulation = trial.run(net, step);
  simulation.advance_to(duration);
  const double error = distance(state_of(simulation), oscillator::forced(start.after(from), duration - from, force));
  const double explained = allowed.by(2.0 * force / oscillator::mass * step * duration);
  return error <= explained ? "" : off("after an input signal that jumps within a step", error, explained);
}

std::string cut(const Trial& trial, const Allowed& allowed) {
  constexpr double at = 0.373, duration = 1.2;
  const State start{0.2, 0.0};
  Network net = pair(oscillator::hooke(), start);
  net.add_cut({at, {0}, {}});
  Simulation simulation = trial.run(net, step);
  simulation.advance_to(duration);
  const State free = start.after(at);
  const double error = distance(state_of(simulation), {free.elongation + (duration - at) * free.speed, free.speed});
  const double acceleration = oscillator::stiffness * start.elongation / oscillator::mass;
  const double explained = allowed.by(2.0 * acceleration * step * duration);
  if (count(simulation, Event::Kind::cut) != 1 || simulation.alive(0)) return "a cut is not carried out once";
  return error <= explained ? "" : off("after a cut within a step", error, explained);
}

// Elongation v / omega sin(omega t), up to 0.8 of its amplitude.
std::string rupture(const Trial& trial, const Allowed& allowed) {
  constexpr double speed = 0.5, strength = 0.2, duration = 1.2;
  const State start{0.0, speed};
  const LawUse law = law_by_formula("k*e", {{"k", oscillator::stiffness}, {"strength", strength}}, "1 - e/strength");
  Simulation simulation = trial.run(pair(law, start), step);
  simulation.advance_to(duration);
  const double at = std::asin(strength * oscillator::frequency / speed) / oscillator::frequency;
  const Event* const event = first(simulation, Event::Kind::ruptured);
  if (event == nullptr || count(simulation, Event::Kind::ruptured) != 1 || simulation.alive(0))
    return "a spring whose margin falls to 0 does not break once";
  const State free = start.after(at);
  const std::string wrong = event_at(trial, *event, at, allowed.smooth / free.speed, "a rupture");
  if (!wrong.empty()) return wrong;
  const double error = distance(state_of(simulation), {strength + (duration - at) * free.speed, free.speed});
  const double acceleration = oscillator::stiffness * strength / oscillator::mass;
  const double explained = allowed.by(2.0 * acceleration * step * duration) + allowed.smooth;
  return error <= explained ? "" : off("after a rupture within a step", error, explained);
}

// Node 0 begins to move at constant speed; seen from it the elongation's rate jumps by that.
std::string motion(const Trial& trial, const Allowed& allowed) {
  constexpr double from = 0.373, until = 10.0, speed = 0.5, duration = 1.2;
  const State start{0.2, 0.0};
  Network net = pair(oscillator::hooke(), start);
  Move move;
  move.nodes = {0};
  move.motion.interpolation = Motion::Interpolation::linear;
  move.motion.times = {0.0, from, until};
  move.motion.displacements = {Vector3::Zero(), Vector3::Zero(), Vector3(speed * (until - from), 0.0, 0.0)};
  net.add_move(move);
  Simulation simulation = trial.run(net, step);
  simulation.advance_to(duration);
  State relative = start.after(from);
  relative.speed -= speed;
  relative = relative.after(duration - from);
  const double moved = speed * (duration - from);
  const double error = distance(state_of(simulation), {relative.elongation + moved, relative.speed + speed});
  const double explained = allowed.smooth + 4.0 * oscillator::frequency * speed * step * step;
  if (std::abs(simulation.position(0).x() - moved) > 1e-9) return "a moved node is not where its motion takes it";
  return error <= explained ? "" : off("after a node begins to move within a step", error, explained);
}

}  // namespace

Outcome check_integrator_events(const Component& component, const PluginHost& host) {
  const Trial trial(component, host);
  const Allowed allowed = allowed_by(trial);
  const auto first_wrong = [&]() -> std::string {
    for (const auto& [doing, each] :
         {std::pair("a load within a step", &load), std::pair("an input signal that jumps within a step", &signal),
          std::pair("a cut within a step", &cut), std::pair("a rupture within a step", &rupture),
          std::pair("a motion that begins within a step", &motion)}) {
      now_doing(doing);
      if (std::string wrong = each(trial, allowed); !wrong.empty()) return wrong;
    }
    return {};
  };
  const std::string wrong = first_wrong();
  if (!wrong.empty()) return {Result::failed, wrong};
  return {Result::passed, allowed.locates ? "located within steps" : "at the ends of steps"};
}

// z = h - g t^2 / 2 to the plane, where it stays; a force of twice the weight takes it off again.
Outcome check_integrator_contact(const Component& component, const PluginHost& host) {
  const Trial trial(component, host);
  if (trial.declares(SPRINGNET_WITHOUT_CONTACT)) return {Result::passed, "declares that it has none"};
  now_doing("dropping a mass onto a plane");
  constexpr double height = 0.23, gravity = 10.0, mass = 1.0, pulled_from = 0.5, duration = 0.8;
  Network net;
  Node node;
  node.position = Vector3(0.0, 0.0, height);
  node.mass = mass;
  net.add_node(node);
  net.set_gravity(Vector3(0.0, 0.0, -gravity));
  net.add_plane({.name = "floor"});
  Load pull;
  pull.nodes = {0};
  pull.force = Vector3(0.0, 0.0, 2.0 * mass * gravity);
  pull.from = pulled_from;
  net.add_load(pull);
  Simulation simulation = trial.run(net, step);
  double deepest = 0.0;
  constexpr double depth = 1e-6;  // m, of rounding and tolerances
  const auto advance = [&](double until) {
    while (simulation.time() < until - 0.5 * step) {
      simulation.step();
      deepest = std::min(deepest, simulation.position(0).z());
    }
  };
  const double touches = std::sqrt(2.0 * height / gravity);
  advance(0.4);
  const auto fail = [](const std::string& why) {
    return Outcome{Result::failed,
                   why + ": apply the host's constraints in each step, or declare SPRINGNET_WITHOUT_CONTACT"};
  };
  if (deepest < -depth) return fail(fmt::format("a mass that falls onto a plane is {:.3g} m below it", -deepest));
  if (std::abs(simulation.position(0).z()) > depth || simulation.velocity(0).norm() > 1e-6)
    return fail(
        fmt::format("a mass that fell onto a plane is at {:.3g} m and moves with {:.3g} m/s, instead of staying",
                    simulation.position(0).z(), simulation.velocity(0).norm()));
  if (!(std::abs(simulation.reaction(0).z() - mass * gravity) <= 1e-6 * mass * gravity))
    return fail(
        fmt::format("the reaction of a mass of 10 N at rest on a plane is {:.6g} N", simulation.reaction(0).z()));
  const Event* const touched = first(simulation, Event::Kind::touched);
  if (touched == nullptr) return fail("a mass falls onto a plane without an event");
  const double touched_at = touched->time;
  const double slow = 10.0 * trial.smooth_error(step) * touches;  // s, of the method
  if (const std::string wrong = event_at(trial, *touched, touches, slow + 0.1 * step, "a touch"); !wrong.empty())
    return {Result::failed, wrong};
  advance(duration);
  const double since = duration - pulled_from, expected = 0.5 * gravity * since * since;
  const double explained = 10.0 * trial.smooth_error(step) * expected + gravity * since * step;
  if (!(std::abs(simulation.position(0).z() - expected) <= explained))
    return fail(fmt::format("a mass that is pulled off a plane is at {:.4g} m instead of {:.4g} m",
                            simulation.position(0).z(), expected));
  return {Result::passed, fmt::format("touches {:.2g} s after the closed form", touched_at - touches)};
}

Outcome check_integrator_rigid(const Component& component, const PluginHost& host) {
  const Trial trial(component, host);
  if (trial.declares(SPRINGNET_WITHOUT_RIGID)) return {Result::passed, "declares that it has none"};
  now_doing("turning two masses on a rod");
  constexpr double length = 1.0, speed = 0.5, duration = 1.0, small = 0.01;
  Network net;
  Node node;
  node.velocity = Vector3(0.0, speed, 0.0);
  node.position = Vector3(0.5 * length, 0.0, 0.0);
  net.add_node(node);
  net.add_node({-node.position, -node.velocity});
  net.add_rigid(0, 1);
  Simulation simulation = trial.run(net, small);
  simulation.advance_to(duration);
  const Vector3 rod = simulation.position(0) - simulation.position(1);
  const auto fail = [](const std::string& why) {
    return Outcome{Result::failed,
                   why + ": apply the host's constraints in each step, or declare SPRINGNET_WITHOUT_RIGID"};
  };
  if (!(std::abs(rod.norm() - length) <= 1e-6))
    return fail(fmt::format("a rod of 1 m is {:.9g} m long after a radian of turning", rod.norm()));
  const double angle = std::atan2(rod.y(), rod.x()), expected = 2.0 * speed / length * duration;
  if (!(std::abs(angle - expected) <= 0.05))
    return fail(fmt::format("two masses on a rod turn by {:.4g} instead of {:.4g}", angle, expected));
  if (!(simulation.momentum().norm() <= 1e-6)) return fail("two masses on a rod do not keep their momentum");
  return {Result::passed, fmt::format("turns by {:.5g} instead of {:.5g}", angle, expected)};
}

}  // namespace springnet::check
