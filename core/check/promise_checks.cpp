// promises: what a law declares that nothing else tests.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "check/law_checks.hpp"

namespace springnet::check {
namespace {

constexpr double rounding = 1e-10;  // of forces that grow, relative to the largest

// Where a force falls most as an argument grows.
struct Descent {
  double part = rounding;  // relative to the largest force along the line
  double before = 0.0, after = 0.0, from = 0.0, to = 0.0;
  std::size_t row = 0, column = 0;
  Point element;
  [[nodiscard]] bool found() const noexcept { return part > rounding; }
};

// Follows the force `row` along a column; what falls more than `worst` takes its place.
void follow(const LawCall& call, const Point& element, std::size_t row, std::size_t column, double low, double high,
            Descent& worst) {
  constexpr int parts = 50;
  std::vector<Point> points(parts + 1, element);
  for (int k = 0; k <= parts; ++k) points[static_cast<std::size_t>(k)][column] = low + (high - low) * k / parts;
  const Answer answer = call(points);
  if (answer.status != SPRINGNET_OK) return;
  const std::vector<double>& force = answer.rows[row];
  double largest = 0.0;
  for (const double f : force) largest = std::isfinite(f) ? std::max(largest, std::abs(f)) : largest;
  std::size_t top = 0;
  for (std::size_t k = 1; k < force.size(); ++k) {
    if (!(force[k] < force[top])) {
      if (std::isfinite(force[k])) top = k;
    } else if (const double part = (force[top] - force[k]) / largest; part > worst.part) {
      worst = {part, force[top], force[k], points[top][column], points[k][column], row, column, element};
    }
  }
}

// Of a law over several scalars each force along its own scalar.
Descent find_fall(ReadyLaw& ready) {
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  const Points& points = ready.points();
  const bool is_speed = !call.several() && call.law().invariant == SPRINGNET_RELATIVE_SPEED;
  Descent worst;
  for (const Point& element : ready.points().several(20)) {
    for (std::size_t i = 0; i < l.invariants; ++i) {
      if (!call.reads_value(i)) continue;
      const double reference = std::abs(element[l.reference(i)]), value = element[l.value(i)];
      const double span = 0.3 * points.magnitude(l.value(i), element);
      if (is_speed)
        follow(call, element, i, l.value(i), 0.0, 3.0, worst);
      else if (call.several())
        follow(call, element, i, l.value(i), value - span, value + span, worst);
      else
        follow(call, element, i, l.value(i), points.lowest() * reference, points.highest() * reference, worst);
      const double speed = 2.0 * (reference > 0.0 ? reference : 1.0);
      if (call.reads_rate()) follow(call, element, i, l.rate(i), -speed, speed, worst);
    }
  }
  return worst;
}

// Empty if no force falls.
std::string check_monotone(ReadyLaw& ready) {
  const Descent fall = find_fall(ready);
  if (!fall.found()) return {};
  const LawCall& call = ready.call();
  return fmt::format(
      "it declares {}, but the {} falls by {:.3g}, {:.2g} of the largest, from {:.6g} to {:.6g}, as {} grows from "
      "{:.4g} "
      "to {:.4g} {}",
      is_formula(call.component()) ? "\"monotone\"" : "SPRINGNET_MONOTONE", call.row_name(fall.row),
      fall.before - fall.after, fall.part, fall.before, fall.after, call.column_name(fall.column), fall.from, fall.to,
      place(call, fall.element));
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
    return {Result::failed, fmt::format("it pushes with {:.6g} {}: {}", -answer.rows[0][k], place(call, compressed[k]),
                                        is_formula(call.component()) ? "take \"pulls only\" out of its `declares`"
                                                                     : "declare SPRINGNET_ACTS_IN_COMPRESSION")};
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
  if (call.has(SPRINGNET_MONOTONE))
    if (const std::string wrong = check_monotone(ready); !wrong.empty()) return {Result::failed, wrong};
  if (call.several() || call.law().invariant == SPRINGNET_RELATIVE_SPEED) return {};
  return check_compression(ready, subject.scene == nullptr);
}

}  // namespace springnet::check
