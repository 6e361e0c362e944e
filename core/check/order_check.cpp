// order: the law in a small net, the fixed-point integrator against CVODE.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "check/child.hpp"
#include "check/law_checks.hpp"

namespace springnet::check {
namespace {

// What makes the net's time scale 1 s: the steepest slope of the force by the invariant or its rate.
double mass_of(ReadyLaw& ready) {
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  Point point = ready.points().at_rest();
  if (call.law().invariant != SPRINGNET_RELATIVE_SPEED)
    ready.points().stretch(point, std::min(1.1, ready.points().highest()));
  double mass = 0.0;
  for (const std::size_t column : {l.value(), l.rate()}) {
    if (!call.reads(column, false)) continue;
    Point moved = point;
    const double step = 0.01 * point[l.reference()];
    moved[column] += step;
    mass = std::max(mass, std::abs(call.rows_at(moved)[0] - call.rows_at(point)[0]) / step);
  }
  return std::isfinite(mass) && mass > 1e-9 ? mass : 1.0;
}

// Five nodes in a row, the first fixed, stretched a little and moving apart. rest: length of the springs, m.
Network chain(const LawUse& law, bool is_viscosity, double mass, double rest) {
  Network net;
  constexpr int count = 5;
  for (int k = 0; k < count; ++k) {
    Node node;
    node.position = rest * Vector3(1.05 * k, 0.02 * k * k, 0.0);
    node.mass = mass;
    node.fixed = k == 0;
    if (k > 0) node.velocity = rest * Vector3(0.06 * k, 0.01 * k, 0.02 * k);
    net.add_node(node);
  }
  const LawUse hooke{"linear", {{"stiffness", mass}}};
  const MaterialIndex material = is_viscosity ? net.add_material({hooke, law}) : net.add_material({law, std::nullopt});
  for (NodeIndex k = 0; k + 1 < count; ++k) net.add_spring(k, k + 1, material, rest);
  return net;
}

constexpr double duration = 0.5;             // s, half of the net's time scale
constexpr int coarsest = 10, finest = 5120;  // steps within it

// 1/s: the fastest of the law's states relaxes at this rate.
double fastest_state(ReadyLaw& ready) {
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  double fastest = 0.0;
  for (const double stretch : {1.0, 1.05, 1.1}) {
    Point point = ready.points().at_rest();
    if (call.law().invariant != SPRINGNET_RELATIVE_SPEED)
      ready.points().stretch(point, std::clamp(stretch, ready.points().lowest(), ready.points().highest()));
    const std::vector<double> rows = call.rows_at(point);
    for (std::size_t i = 0; i < l.states; ++i) {
      const springnet_parameter& state = *call.law().states[i];
      Point moved = point;
      moved[l.state(i)] += (moved[l.state(i)] + 0.01 * state.scale <= state.largest ? 0.01 : -0.01) * state.scale;
      const double step = moved[l.state(i)] - point[l.state(i)];
      const double slope = (call.rows_at(moved)[l.state_row(i)] - rows[l.state_row(i)]) / step;
      if (std::isfinite(slope)) fastest = std::max(fastest, std::abs(slope));
    }
  }
  return fastest;
}

// left: springs that are left then, where wanted.
Eigen::Matrix3Xd end_of(const Network& net, const LawSubject& subject, const LawUse& integrator, double step,
                        std::size_t* left = nullptr) {
  SimulationOptions options;
  options.time_step = step;
  options.integrator = integrator;
  options.threads = 1;
  options.renumber = false;
  Simulation simulation(net, subject.host, options);
  simulation.advance_to(duration);
  if (left != nullptr) *left = simulation.live_spring_count();
  return simulation.positions();
}

// How the error falls with the step. Steps are halved until the order is seen: a law may vary faster than the net.
struct Fall {
  double order = 0.0;                            // of the last two errors
  double first = 0.0, before = 0.0, last = 0.0;  // errors, m
  int steps = 0;                                 // the most
  bool is_noise = false;                         // tolerances make up the last error
};
template <class Error>
Fall fall_of(const Error& error_with, double wanted, double noise) {
  Fall fall;
  fall.first = fall.last = error_with(coarsest);
  for (fall.steps = 2 * coarsest; fall.steps <= finest; fall.steps *= 2) {
    fall.before = fall.last;
    fall.last = error_with(fall.steps);
    fall.order = std::log2(fall.before / fall.last);
    fall.is_noise = fall.last < noise;
    if (fall.steps > 2 * coarsest && (fall.is_noise || fall.order > wanted - 0.3)) return fall;
  }
  fall.steps /= 2;
  return fall;
}

}  // namespace

Outcome check_order(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  if (call.several() || (call.law().invariant != SPRINGNET_LENGTH && call.law().invariant != SPRINGNET_RELATIVE_SPEED))
    return {Result::skipped, "not a law of springs"};
  if (!call.has(SPRINGNET_HAS_DERIVATIVES)) return {Result::skipped, "has no derivatives, which implicit steps need"};
  if (subject.host == nullptr || subject.host->find(ComponentKind::integrator, "recurrent") == nullptr ||
      subject.host->find(ComponentKind::integrator, "cvode") == nullptr)
    return {Result::skipped, "the integrators recurrent and cvode are not installed"};
  LawUse use{std::string(call.component().id()), {}, ready.tables(), subject.component};
  for (std::size_t i = 0; i < l.parameters; ++i)
    use.parameters[call.component().description->parameters[i]->name] = ready.parameters()[i];
  const double mass = mass_of(ready);
  const double rest = ready.points().at_rest()[l.reference()];
  const Network net = chain(use, call.is_viscosity(), mass, rest);
  const LawUse cvode{"cvode", {{"relative_tolerance", 1e-11}}};
  now_doing("simulating a chain of five nodes with cvode");
  std::size_t left = 0;
  const Eigen::Matrix3Xd exact = end_of(net, subject, cvode, duration, &left);
  if (left < net.springs().size())
    return {Result::skipped,
            fmt::format("{} of {} springs of the test's chain break, so that no order is seen; check the "
                        "law with parameters with which springs last that are stretched by a tenth",
                        net.springs().size() - left, net.springs().size())};
  std::string report;
  for (const double theta : {1.0, 0.5}) {
    now_doing("simulating a chain of five nodes with recurrent");
    const LawUse recurrent{"recurrent", {{"theta", theta}, {"force_tolerance", 1e-12 * mass * rest}}};
    const auto error_with = [&](int steps) {
      return (end_of(net, subject, recurrent, duration / steps) - exact).cwiseAbs().maxCoeff();
    };
    const double wanted = theta == 1.0 ? 1.0 : 2.0;
    const Fall fall = fall_of(error_with, wanted, 1e-8 * rest);
    const double step = duration / fall.steps;
    report += fmt::format("{}theta {:g}: {:.2f}", report.empty() ? "" : ", ", theta, fall.order);
    if (fall.steps > 4 * coarsest) report += fmt::format(" with steps of {:.2g} s", step);
    if (fall.is_noise || fall.order > wanted - 0.3) continue;
    const std::string seen = fmt::format(
        "in a chain of 5 nodes the error of `recurrent` falls with the order {:.2f} at theta {:g}, {:g} is expected "
        "({:.2e}, {:.2e} m from `cvode` with steps of {:.2g}, {:.2g} s)",
        fall.order, theta, wanted, fall.before, fall.last, 2.0 * step, step);
    // Steps much longer than a state takes to relax: of first order, whatever the method.
    if (const double fastest = fastest_state(ready); fastest * step > 0.5)
      return {Result::skipped,
              fmt::format("a state relaxes within {:.2g} s, too fast to see an order: {}", 1.0 / fastest, seen)};
    if (fall.last > 0.5 * fall.first) return {Result::failed, seen + ": both do not approach the same motion"};
    return {Result::warned, seen + ": a kink in the force or in a state's rate, or a law that varies faster"};
  }
  return {Result::passed, report};
}

}  // namespace springnet::check
