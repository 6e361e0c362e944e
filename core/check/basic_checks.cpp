// call, arrays, finite, rest: whether a law can be called at all, and what it answers.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "check/child.hpp"
#include "check/law_checks.hpp"

namespace springnet::check {
namespace {

constexpr double small_length = 1e-6;  // m: elements of cells, rather than of buildings

// "force" and so on if a value of element `i` is not finite.
std::string not_finite(const LawCall& call, const Answer& answer, std::size_t i) {
  for (std::size_t row = 0; row < answer.rows.size(); ++row)
    if (!answer.rows[row].empty() && !std::isfinite(answer.rows[row][i]))
      return fmt::format("the {} is {}", call.row_name(row), answer.rows[row][i]);
  return {};
}

// Along the stretches of the domain: a law of bounded extension may end within what is checked if it declares no bound.
struct Along {
  std::string inside;  // what is not finite, in a place surrounded by others that are
  double ends = 0.0;   // stretch from which on nothing is finite; 0: none
};
Along along_stretches(const LawCall& call, const Points& points, const Point& from) {
  constexpr int parts = 60;
  std::vector<Point> line;
  std::vector<double> stretches;
  const double low = points.lowest(), high = points.highest();
  for (int k = 0; k <= parts; ++k) {
    // Never beyond the bound by rounding.
    const double stretch = std::min(low + (high - low) * k / parts, high);
    line.push_back(from);
    points.stretch(line.back(), stretch);
    if (stretch == high && high < 2.0) line.back()[0] = std::nextafter(line.back()[0], 0.0);
    stretches.push_back(stretch);
  }
  const Answer answer = call(line);
  if (answer.status != SPRINGNET_OK) return {"it fails: " + answer.message, 0.0};
  std::size_t last = line.size();
  while (last > 0 && !not_finite(call, answer, last - 1).empty()) --last;
  for (std::size_t k = 0; k < last; ++k)
    if (const std::string what = not_finite(call, answer, k); !what.empty())
      return {fmt::format("{} {}", what, place(call, line[k])), 0.0};
  if (last == line.size()) return {};
  // A finite bound is a promise; beyond rest all may end only where none is declared.
  const bool declared = call.law().largest_stretch <= 2.0;
  if (declared || stretches[last] < 1.05)
    return {fmt::format("{} {}", not_finite(call, answer, last), place(call, line[last])), 0.0};
  return {{}, stretches[last]};
}

// On the coordinates of an element's nodes, up to the sign.
std::vector<double> nodal_forces(const LawCall& call, const std::vector<double>& rows, const Corners& corners) {
  const std::vector<std::vector<double>> gradients = gradients_of(call.law(), corners);
  std::vector<double> forces(3 * corners.size(), 0.0);
  for (std::size_t i = 0; i < call.layout().invariants; ++i)
    for (std::size_t k = 0; call.reads_value(i) && k < forces.size(); ++k) forces[k] += rows[i] * gradients[i][k];
  return forces;
}

Outcome finite_domain(ReadyLaw& ready, std::string& ends) {
  const LawCall& call = ready.call();
  Points& points = ready.points();
  const auto fail = [](const std::string& what) {
    return Outcome{Result::failed,
                   what + ": declare the stretches and bounds for which the formula holds, or correct it"};
  };
  std::vector<Point> all = points.several(200);
  const Point rest = points.at_rest();
  all.push_back(rest);
  all.push_back(points.at_rest(small_length));
  for (const Point& edge : points.edges(rest)) all.push_back(edge);
  // Elements that move, at each edge of the parameters.
  for (const Point& edge : points.edges(points.any())) all.push_back(edge);
  const Answer answer = call(all);
  if (answer.status != SPRINGNET_OK) return fail("it fails within its domain: " + answer.message);
  // Where a law ends without a declared bound is found along the stretches.
  const bool bounded = call.several() || call.law().largest_stretch <= 2.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double stretch = all[i][call.layout().value()] / all[i][call.layout().reference()];
    if (!bounded && stretch > 1.0) continue;
    if (const std::string what = not_finite(call, answer, i); !what.empty())
      return fail(fmt::format("{} {}", what, place(call, all[i])));
  }
  if (call.several() || call.law().invariant == SPRINGNET_RELATIVE_SPEED) return {};
  std::vector<Point> lines{rest, points.at_rest(small_length)};
  for (const Point& edge : points.edges(rest)) lines.push_back(edge);
  for (int k = 0; k < 10; ++k) lines.push_back(points.any());
  for (const Point& from : lines) {
    const Along along = along_stretches(call, points, from);
    if (!along.inside.empty()) return fail(along.inside);
    if (along.ends > 0.0)
      ends = fmt::format("not finite from a stretch of {:.3g} on {}", along.ends, place(call, from));
  }
  return {};
}

}  // namespace

Outcome check_call(const LawSubject& subject) {
  now_doing("preparing its tables");
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  now_doing("starting the states of one element");
  const Point rest = ready.points().at_rest();
  now_doing("evaluating one element at rest");
  Answer answer = call({rest});
  if (answer.status == SPRINGNET_OK) {
    now_doing("evaluating the derivatives of one element at rest");
    answer = call({rest}, {.derivatives = true});
  }
  if (answer.status == SPRINGNET_OK && call.layout().states > 0) {
    now_doing("making a step of the states of one element at rest");
    answer = call({rest}, {.derivatives = true, .time_step = 1e-3});
  }
  if (answer.status != SPRINGNET_OK) return {Result::failed, "it refuses an element at rest: " + answer.message};
  return {};
}

Outcome check_arrays(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const std::vector<Point> points = ready.points().several(19);
  const bool has_states = call.layout().states > 0;
  for (const Memory::Layout layout : {Memory::Layout::at_end, Memory::Layout::at_start}) {
    for (const std::size_t count : {1u, 3u, 8u, 19u}) {
      std::vector<Point> some(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count));
      for (const bool share : {false, true}) {
        if (share)  // one value for all elements
          for (Point& point : some)
            for (std::size_t c = call.layout().parameter(0); c < call.layout().time(); ++c) point[c] = points[0][c];
        for (const double step : {0.0, 1e-3}) {
          if (step > 0.0 && !has_states) continue;
          now_doing(fmt::format("{} {} elements", step > 0.0 ? "updating" : "evaluating", count).c_str());
          How how{.derivatives = true, .share = share, .time_step = step, .layout = layout};
          const Answer answer = call(some, how);
          // A step without a solution is the matter of another check.
          if (answer.status == SPRINGNET_FAILED) return {Result::failed, answer.message};
          how.derivatives = false;
          static_cast<void>(call(some, how));
        }
      }
    }
    now_doing("starting the states");
    static_cast<void>(call.start_states(points[0], layout));
  }
  return {};
}

Outcome check_finite(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const springnet_law& law = call.law();
  std::string ends;
  const Outcome outcome = finite_domain(ready, ends);
  if (outcome.result != Result::passed) return outcome;
  const bool one = !call.several() && law.invariant != SPRINGNET_RELATIVE_SPEED;
  if (one && !call.has(SPRINGNET_DIVIDES_BY_REFERENCE) && law.smallest_stretch <= 0.0 && law.largest_stretch > 1e300) {
    Point point = ready.points().at_rest();
    point[call.layout().reference()] = 0.0;
    const Answer answer = call({point});
    const std::string what = answer.status == SPRINGNET_OK ? not_finite(call, answer, 0) : "it fails";
    if (!what.empty())
      return {Result::failed, fmt::format("{} with a reference of 0: declare SPRINGNET_DIVIDES_BY_REFERENCE", what)};
  }
  // A finite force beyond the bound lets a step across it go unnoticed.
  if (one && law.largest_stretch < 1e300) {
    Point point = ready.points().at_rest();
    point[call.layout().value()] = 1.1 * law.largest_stretch * point[call.layout().reference()];
    const Answer answer = call({point});
    if (answer.status == SPRINGNET_OK && std::isfinite(answer.rows[0][0]))
      return {
          Result::warned,
          fmt::format("the force is {:.4g} at 1.1 times the largest stretch, {:g}: return NaN there, so that a step "
                      "across the limit is noticed",
                      answer.rows[0][0], law.largest_stretch)};
    return {Result::passed, fmt::format("beyond the largest stretch, {:g}, it answers nan", law.largest_stretch)};
  }
  if (!ends.empty())
    return {Result::warned, ends + ": declare largest_stretch unless the limit follows from parameters"};
  return {};
}

Outcome check_rest(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  if (call.has(SPRINGNET_NOT_ZERO_AT_REST)) return {Result::passed, "declares a force at rest"};
  // Rounding of the formula, in units of the force at a tenth of strain.
  constexpr double tolerance = 1e-9;
  for (const double size : {1.0, 0.37, small_length}) {
    Placed placed;
    const Point rest = ready.points().at_rest(size, &placed);
    if (!call.several() && rest[l.value()] != rest[l.reference()] && call.law().invariant != SPRINGNET_RELATIVE_SPEED)
      return {Result::passed, "a stretch of 1 is outside of its domain"};
    const std::vector<double> rows = call.rows_at(rest);
    if (!call.several()) {
      Point moved = rest;
      moved[l.value()] += 0.1 * rest[l.reference()];
      moved[l.rate()] = 0.1 * rest[l.reference()];
      const double scale = std::max(std::abs(call.rows_at(moved)[0]), 1e-300);
      if (!(std::abs(rows[0]) <= tolerance * scale))
        return {can_declare(call.component()) ? Result::failed : Result::warned,
                fmt::format("the force is {:.6g} {}: correct it, or declare SPRINGNET_NOT_ZERO_AT_REST", rows[0],
                            place(call, rest))};
      continue;
    }
    // Forces on several scalars may balance one another at the nodes. The scale is that of a tenth of strain.
    Corners strained = placed.rest;
    for (auto& corner : strained) corner[0] *= 1.1, corner[1] *= 0.95;
    Point moved = rest;
    const std::vector<double> values = scalars_of(call.law(), strained);
    for (std::size_t i = 0; i < l.invariants; ++i) {
      moved[l.value(i)] = values[i];
      moved[l.rate(i)] = values[i] - rest[l.value(i)];
    }
    // An angle at rest changes little.
    if (call.law().shape == SPRINGNET_HINGE || call.law().shape == SPRINGNET_CHAIN) moved[l.value()] += 0.1;
    const std::vector<double> at_rest = nodal_forces(call, rows, placed.rest);
    double scale = 1e-300;
    for (const double force : nodal_forces(call, call.rows_at(moved), strained))
      scale = std::max(scale, std::abs(force));
    for (std::size_t k = 0; k < at_rest.size(); ++k)
      if (!(std::abs(at_rest[k]) <= tolerance * scale))
        return {can_declare(call.component()) ? Result::failed : Result::warned,
                fmt::format("node {} gets the force {:.6g} {} (at a tenth of strain {:.3g}): correct it, or declare "
                            "SPRINGNET_NOT_ZERO_AT_REST",
                            k / 3, at_rest[k], place(call, rest), scale)};
  }
  return {};
}

}  // namespace springnet::check
