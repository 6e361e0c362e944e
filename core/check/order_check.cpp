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

constexpr double duration = 0.5;  // s, half of the net's time scale

Eigen::Matrix3Xd end_of(const Network& net, const LawSubject& subject, const LawUse& integrator, double step) {
  SimulationOptions options;
  options.time_step = step;
  options.integrator = integrator;
  options.threads = 1;
  options.renumber = false;
  Simulation simulation(net, subject.host, options);
  simulation.advance_to(duration);
  return simulation.positions();
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
  const Eigen::Matrix3Xd exact = end_of(net, subject, cvode, duration);
  std::string report;
  for (const double theta : {1.0, 0.5}) {
    std::array<double, 3> errors{};
    now_doing("simulating a chain of five nodes with recurrent");
    const double tolerance = 1e-12 * mass * rest;
    const LawUse recurrent{"recurrent", {{"theta", theta}, {"force_tolerance", tolerance}}};
    for (std::size_t level = 0; level < errors.size(); ++level)
      errors[level] =
          (end_of(net, subject, recurrent, duration / static_cast<double>(10 << level)) - exact).cwiseAbs().maxCoeff();
    const double order = std::log2(errors[1] / errors[2]), wanted = theta == 1.0 ? 1.0 : 2.0;
    report += fmt::format("{}theta {:g}: {:.2f}", report.empty() ? "" : ", ", theta, order);
    // Below this, tolerances make up the error.
    const double noise = 1e-8 * rest;
    if (errors[2] < noise || order > wanted - 0.3) continue;
    return {
        Result::failed,
        fmt::format("in a chain of 5 nodes the error of `recurrent` falls with the order {:.2f} at theta {:g}, {:g} "
                    "is expected ({:.2e}, {:.2e} m from `cvode`): derivatives, or a kink in the force",
                    order, theta, wanted, errors[1], errors[2])};
  }
  return {Result::passed, report};
}

}  // namespace springnet::check
