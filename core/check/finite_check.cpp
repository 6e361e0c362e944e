// finite: whether a law answers numbers over all of its domain, and none outside of it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "check/law_checks.hpp"
#include "check/pole.hpp"

namespace springnet::check {
namespace {

constexpr double unbounded = 1e300;  // greater stretches are no bound

// "force" and so on if a value of element `i` is not finite.
std::string not_finite(const LawCall& call, const Answer& answer, std::size_t i) {
  for (std::size_t row = 0; row < answer.rows.size(); ++row)
    if (!answer.rows[row].empty() && !std::isfinite(answer.rows[row][i]))
      return fmt::format("the {} is {}", call.row_name(row), answer.rows[row][i]);
  return {};
}

// Elements like one, along the stretches of the domain: fine steps, and below a tenth equal ratios.
class Line {
 public:
  Line(const LawCall& call, const Points& points, const Point& from) : call_(call), points_(points), from_(from) {
    constexpr int ratios = 60, steps = 400;
    const double low = points.lowest(), high = points.highest(), bend = std::min(std::max(low, 0.1), high);
    for (int k = 0; k < ratios && low < bend; ++k) stretches_.push_back(low * std::pow(bend / low, k / double{ratios}));
    for (int k = 0; k <= steps; ++k) stretches_.push_back(std::min(bend + (high - bend) * k / steps, high));
    if (!stretches_.empty() && stretches_.front() < low) stretches_.front() = low;
    stretches_.erase(std::unique(stretches_.begin(), stretches_.end()), stretches_.end());
  }
  [[nodiscard]] const std::vector<double>& stretches() const noexcept { return stretches_; }
  [[nodiscard]] Point at(double stretch) const {
    Point point = from_;
    points_.stretch(point, stretch);
    // Never beyond a bound by rounding.
    const springnet_law& law = call_.law();
    if (law.largest_stretch < unbounded && stretch >= law.largest_stretch) point[0] = std::nextafter(point[0], 0.0);
    if (law.smallest_stretch > 0.0 && stretch <= law.smallest_stretch)
      point[0] = std::nextafter(point[0], std::numeric_limits<double>::infinity());
    return point;
  }
  [[nodiscard]] Answer answers(const std::vector<double>& stretches) const {
    std::vector<Point> points;
    for (const double stretch : stretches) points.push_back(at(stretch));
    return call_(points);
  }
  [[nodiscard]] bool is_finite_at(double stretch) const {
    const Answer answer = answers({stretch});
    return answer.status == SPRINGNET_OK && not_finite(call_, answer, 0).empty();
  }
  // Where answers begin to be finite, between a stretch at which they are not and one at which they are.
  [[nodiscard]] double end_between(double outside, double inside) const {
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (outside + inside);
      (is_finite_at(middle) ? inside : outside) = middle;
    }
    return inside;
  }

 private:
  const LawCall& call_;
  const Points& points_;
  Point from_;
  std::vector<double> stretches_;
};

// What is found along a line. A law of bounded extension may end within the stretches that are checked if it declares
// no bound.
struct Along {
  std::string inside;               // what is not finite, in a place surrounded by others that are
  std::optional<double> low, high;  // stretches between which all is finite; none: up to those checked
  std::optional<Pole> pole;         // of the force
};
Along along(const LawCall& call, const Points& points, const Point& from) {
  const Line line(call, points, from);
  const std::vector<double>& stretches = line.stretches();
  const Answer answer = line.answers(stretches);
  if (answer.status != SPRINGNET_OK) return {"it fails: " + answer.message, {}, {}, {}};
  const auto is_finite = [&](std::size_t k) { return not_finite(call, answer, k).empty(); };
  const auto told = [&](std::size_t k) {
    return fmt::format("{} {}", not_finite(call, answer, k), place(call, line.at(stretches[k])));
  };
  // From the place nearest to rest to both sides.
  const auto rest =
      static_cast<std::size_t>(std::lower_bound(stretches.begin(), stretches.end(), 1.0) - stretches.begin());
  std::size_t first = std::min(rest, stretches.size() - 1), last = first;
  if (!is_finite(first)) return {told(first), {}, {}, {}};
  while (first > 0 && is_finite(first - 1)) --first;
  while (last + 1 < stretches.size() && is_finite(last + 1)) ++last;
  Along result;
  const Curve force = [&](const std::vector<double>& xs) {
    const Answer part = line.answers(xs);
    return part.status == SPRINGNET_OK ? part.rows[0] : std::vector<double>{};
  };
  result.pole = find_pole(force, stretches, answer.rows[0]);
  for (std::size_t k = 0; k < stretches.size(); ++k)
    if ((k < first || k > last) && is_finite(k)) {
      const std::size_t gap = k < first ? first - 1 : last + 1;
      result.inside = told(gap);
      return result;
    }
  // A bound that is declared is a promise.
  const springnet_law& law = call.law();
  if (first > 0) {
    if (law.smallest_stretch > 0.0) result.inside = told(first - 1);
    result.low = line.end_between(stretches[first - 1], stretches[first]);
  }
  if (last + 1 < stretches.size()) {
    if (law.largest_stretch < unbounded) result.inside = told(last + 1);
    result.high = line.end_between(stretches[last + 1], stretches[last]);
  }
  return result;
}

// Whether an end moves along with a parameter or the reference: no constant stretch could be declared then.
bool follows(const LawCall& call, const Points& points, const Point& from, const Along& found) {
  constexpr double change = 1.05, least = 1e-6;
  const sdk::JacobianLayout& l = call.layout();
  const auto differs = [](const std::optional<double>& a, const std::optional<double>& b) {
    return a.has_value() != b.has_value() || (a && std::abs(*a - *b) > least * std::abs(*a));
  };
  std::vector<std::size_t> columns{l.reference()};
  for (std::size_t i = 0; i < l.parameters; ++i)
    if (call.component().description->parameters[i]->type == SPRINGNET_NUMBER) columns.push_back(l.parameter(i));
  return std::any_of(columns.begin(), columns.end(), [&](std::size_t column) {
    Point changed = from;
    changed[column] /= change;
    const Along other = along(call, points, changed);
    return other.inside.empty() && (differs(found.low, other.low) || differs(found.high, other.high));
  });
}

std::string told(const Along& found) {
  if (found.low && found.high)
    return fmt::format("finite from a stretch of {:.4g} to {:.4g} alone", *found.low, *found.high);
  return found.low ? fmt::format("finite from a stretch of {:.4g} on alone", *found.low)
                   : fmt::format("finite up to a stretch of {:.4g} alone", *found.high);
}

Outcome fail(const LawCall& call, const std::string& what) {
  const char* const advice = is_formula(call.component())
                                 ? "correct the formula, or write for which stretches it holds, stretch = [a, b], and "
                                   "the bounds of its parameters"
                                 : "declare the stretches and bounds for which the formula holds, or correct it";
  return {Result::failed, fmt::format("{}: {}", what, advice)};
}

// Random elements, elements at rest of each size, and each bound of parameters, states and inputs.
Outcome finite_points(ReadyLaw& ready) {
  const LawCall& call = ready.call();
  Points& points = ready.points();
  std::vector<Point> all = points.several(200);
  for (std::size_t size = 0; size < Points::sizes; ++size) {
    all.push_back(points.at_rest(size));
    for (const Point& edge : points.edges(all.back())) all.push_back(edge);
  }
  // Elements that move, at each edge of the parameters.
  for (const Point& edge : points.edges(points.any())) all.push_back(edge);
  const Answer answer = call(all);
  if (answer.status != SPRINGNET_OK) return fail(call, "it fails within its domain: " + answer.message);
  const bool has_ends = !call.several() && call.law().invariant != SPRINGNET_RELATIVE_SPEED;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::string what = not_finite(call, answer, i);
    if (what.empty()) continue;
    if (has_ends) {
      // Beyond an end of its own?
      const double stretch = all[i][call.layout().value()] / all[i][call.layout().reference()];
      const Along found = along(call, points, all[i]);
      if (found.inside.empty() && ((found.low && stretch < *found.low) || (found.high && stretch > *found.high)))
        continue;
    }
    return fail(call, fmt::format("{} {}", what, place(call, all[i])));
  }
  return {};
}

// Along the stretches: what is found of the law's ends.
Outcome finite_lines(ReadyLaw& ready) {
  const LawCall& call = ready.call();
  Points& points = ready.points();
  std::vector<Point> lines;
  for (std::size_t size = 0; size < Points::sizes; ++size) lines.push_back(points.at_rest(size));
  for (const Point& edge : points.edges(lines.front())) lines.push_back(edge);
  for (int k = 0; k < 10; ++k) lines.push_back(points.any());
  Outcome outcome;
  for (const Point& from : lines) {
    const Along found = along(call, points, from);
    if (found.pole) {
      Point at = from;
      points.stretch(at, found.pole->at);
      const char* const advice = is_formula(call.component())
                                     ? "write if(…, nan) for nan beyond it, or stretch = [a, b] up to there"
                                     : "answer nan beyond it, or declare the stretches up to there";
      return {Result::failed,
              fmt::format("the force has a pole at a stretch of {:.6g}, {:.3g} before and {:.3g} beyond, {}: a step "
                          "across it would go unnoticed; {}",
                          found.pole->at, found.pole->below, found.pole->above, place(call, at), advice)};
    }
    if (!found.inside.empty()) return fail(call, found.inside);
    if (!found.low && !found.high) continue;
    const double nearest = std::max(found.low.value_or(0.0), 1.0 / found.high.value_or(unbounded));
    if (nearest > 1.0 / 1.05) {
      Point at = from;
      points.stretch(at, 1.0);
      return fail(call, told(found) + ", too close to rest, " + place(call, at));
    }
    if (!follows(call, points, from, found))
      return fail(call, fmt::format("{}, whatever the parameters, {}", told(found), place(call, from)));
    if (outcome.why.empty()) outcome.why = fmt::format("{}, which follows from parameters", told(found));
  }
  return outcome;
}

// A finite force beyond a bound that is declared lets a step across it go unnoticed.
Outcome beyond_bounds(ReadyLaw& ready) {
  const LawCall& call = ready.call();
  const springnet_law& law = call.law();
  std::string told;
  const auto try_at = [&](const char* name, double bound, double factor) -> Outcome {
    Point point = ready.points().at_rest();
    point[call.layout().value()] = factor * bound * point[call.layout().reference()];
    const Answer answer = call({point});
    if (answer.status == SPRINGNET_OK && std::isfinite(answer.rows[0][0]))
      return {Result::warned,
              fmt::format("the force is {:.4g} at {:g} times the {} stretch, {:g}: {} there, so that a step across the "
                          "limit is noticed",
                          answer.rows[0][0], factor, name, bound,
                          is_formula(call.component()) ? "write if(…, nan) for nan" : "return NaN")};
    told += fmt::format("{} the {} stretch, {:g}, it answers nan", told.empty() ? "beyond" : ", beyond", name, bound);
    return {};
  };
  Outcome outcome;
  if (law.largest_stretch < unbounded) outcome = try_at("largest", law.largest_stretch, 1.1);
  if (outcome.result == Result::passed && law.smallest_stretch > 0.0)
    outcome = try_at("smallest", law.smallest_stretch, 0.9);
  if (outcome.result == Result::passed) outcome.why = told;
  return outcome;
}

}  // namespace

Outcome check_finite(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const springnet_law& law = call.law();
  const Outcome points = finite_points(ready);
  if (points.result != Result::passed || call.several() || law.invariant == SPRINGNET_RELATIVE_SPEED) return points;
  const Outcome lines = finite_lines(ready);
  if (is_bad(lines.result)) return lines;
  if (!call.has(SPRINGNET_DIVIDES_BY_REFERENCE) && law.smallest_stretch <= 0.0 && law.largest_stretch > unbounded) {
    // A law that holds up to an elongation given by a parameter may be nan at some of these, not at all.
    std::string what;
    for (const double part : {1.0, 1e-2, 1e-4, 1e-6}) {
      Point point = ready.points().at_rest();
      point[call.layout().value()] = part * point[call.layout().reference()];
      point[call.layout().reference()] = 0.0;
      const Answer answer = call({point});
      what = answer.status == SPRINGNET_OK ? not_finite(call, answer, 0) : "it fails";
      if (what.empty()) break;
    }
    if (!what.empty())
      return {Result::failed,
              fmt::format("{} with a reference of 0: {}", what,
                          is_formula(call.component())
                              ? "use `strain` or `stretch`, so that elements with that reference are refused"
                              : "declare SPRINGNET_DIVIDES_BY_REFERENCE")};
  }
  const Outcome beyond = beyond_bounds(ready);
  return lines.result != Result::passed || beyond.why.empty() ? lines : beyond;
}

}  // namespace springnet::check
