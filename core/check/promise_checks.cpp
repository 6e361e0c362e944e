// promises: what a law declares that nothing else tests.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "check/law_checks.hpp"

namespace springnet::check {
namespace {

constexpr double rounding = 1e-10;  // of forces that grow, relative to the largest

// Empty if the force never falls along a column.
std::string falls(const LawCall& call, const Point& from, std::size_t column, double low, double high) {
  constexpr int parts = 50;
  std::vector<Point> points(parts + 1, from);
  for (int k = 0; k <= parts; ++k) points[static_cast<std::size_t>(k)][column] = low + (high - low) * k / parts;
  const Answer answer = call(points);
  if (answer.status != SPRINGNET_OK) return {};
  const std::vector<double>& force = answer.rows[0];
  double largest = 0.0;
  for (const double f : force) largest = std::isfinite(f) ? std::max(largest, std::abs(f)) : largest;
  for (std::size_t k = 1; k < force.size(); ++k)
    if (force[k] < force[k - 1] - rounding * largest)
      return fmt::format(
          "it declares SPRINGNET_MONOTONE, but the force falls from {:.6g} to {:.6g} as {} grows from "
          "{:.4g} to {:.4g} {}",
          force[k - 1], force[k], call.column_name(column), points[k - 1][column], points[k][column],
          place(call, from));
  return {};
}

std::string check_monotone(ReadyLaw& ready) {
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  const Points& points = ready.points();
  for (const Point& from : ready.points().several(20)) {
    const double reference = from[l.reference()];
    const bool is_speed = call.law().invariant == SPRINGNET_RELATIVE_SPEED;
    std::string wrong = is_speed
                            ? falls(call, from, l.value(), 0.0, 3.0)
                            : falls(call, from, l.value(), points.lowest() * reference, points.highest() * reference);
    if (wrong.empty() && call.reads_rate()) wrong = falls(call, from, l.rate(), -2.0 * reference, 2.0 * reference);
    if (!wrong.empty()) return wrong;
  }
  return {};
}

// Pushing is a force below 0 in an element that is compressed, or becomes shorter. has_free_parameters: they are not
// those of a scene, with which a law that can push need not.
Outcome check_compression(ReadyLaw& ready, bool has_free_parameters) {
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  const bool declared = call.has(SPRINGNET_ACTS_IN_COMPRESSION);
  std::vector<Point> points = ready.points().several(400);
  double largest = 0.0;
  std::vector<Point> compressed;
  for (Point& point : points) {
    if (!call.is_viscosity()) {
      ready.points().stretch(point, std::max(ready.points().lowest(), ready.points().uniform(0.4, 0.99)));
      if (!declared) point[l.rate()] = -std::abs(point[l.rate()]);
    }
    // Some become shorter ever faster: a damper may push only then.
    point[l.rate()] = -std::abs(point[l.rate()]) * std::pow(30.0, declared ? ready.points().uniform(0.0, 1.0) : 0.0);
    for (std::size_t i = 0; i < l.states; ++i) point[l.state(i)] = call.law().states[i]->default_value;
    compressed.push_back(point);
  }
  const Answer answer = call(compressed);
  if (answer.status != SPRINGNET_OK) return {Result::failed, "it fails in compression: " + answer.message};
  for (const double f : answer.rows[0]) largest = std::max(largest, std::abs(f));
  for (std::size_t k = 0; k < compressed.size(); ++k) {
    if (!(answer.rows[0][k] < -rounding * largest)) continue;
    if (declared) return {};
    return {Result::failed, fmt::format("it pushes with {:.6g} {}: declare SPRINGNET_ACTS_IN_COMPRESSION",
                                        -answer.rows[0][k], place(call, compressed[k]))};
  }
  if (!declared || !has_free_parameters) return {};
  return {Result::warned, "it declares SPRINGNET_ACTS_IN_COMPRESSION, but never pushes: drop that if it pulls alone"};
}

}  // namespace

Outcome check_promises(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  if (call.has(SPRINGNET_HAS_RUPTURE)) {
    const double margin = call.rows_at(ready.points().at_rest())[l.margin()];
    if (!(margin > 0.0))
      return {Result::failed, fmt::format("the margin is {:.6g} at rest, so that elements break at once: it is 1 "
                                          "unloaded and falls to 0",
                                          margin)};
    // A law that is loaded at rest has a margin below 1.
    if (!call.has(SPRINGNET_NOT_ZERO_AT_REST) && std::abs(margin - 1.0) > 1e-9)
      return {Result::failed, fmt::format("the margin is {:.6g} unloaded: it must be 1", margin)};
  }
  if (call.has(SPRINGNET_MONOTONE) && !call.several())
    if (const std::string wrong = check_monotone(ready); !wrong.empty()) return {Result::failed, wrong};
  if (call.several() || call.law().invariant == SPRINGNET_RELATIVE_SPEED) return {};
  return check_compression(ready, subject.scene == nullptr);
}

}  // namespace springnet::check
