// energy, derivatives, dissipation, promises: what a law says of its force against differences of it.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "check/differences.hpp"
#include "check/law_checks.hpp"
#include "check/quadrature.hpp"

namespace springnet::check {
namespace {

// Answers along one column. A column that all elements share, the time, takes a call for each.
Answer answers_along(const LawCall& call, const Point& point, std::size_t column, const std::vector<double>& xs,
                     const How& how) {
  std::vector<Point> points(xs.size(), point);
  for (std::size_t k = 0; k < xs.size(); ++k) points[k][column] = xs[k];
  if (column != call.layout().time()) return call(points, how);
  Answer all;
  const auto append = [](std::vector<std::vector<double>>& to, const std::vector<std::vector<double>>& from) {
    to.resize(from.size());
    for (std::size_t k = 0; k < from.size(); ++k) to[k].insert(to[k].end(), from[k].begin(), from[k].end());
  };
  for (const Point& each : points) {
    const Answer one = call({each}, how);
    if (one.status != SPRINGNET_OK) return one;
    append(all.rows, one.rows);
    append(all.matrix, one.matrix);
    append(all.named, one.named);
  }
  return all;
}

// A law's rows as functions of one column.
Functions along(const LawCall& call, const Point& point, std::size_t column) {
  return [&call, point, column](const std::vector<double>& xs) {
    Answer answer = answers_along(call, point, column, xs, {});
    if (answer.status != SPRINGNET_OK) answer.rows.assign(call.layout().rows(), {});
    return answer.rows;
  };
}

// How far from a value a law is called: a tenth of its size, no further than half of the way to the bounds.
double reach(const ReadyLaw& ready, const Points& points, const Point& point, std::size_t column) {
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  double step = 0.1 * points.magnitude(column, point);
  const auto keep_within = [&](const springnet_parameter& p) {
    step = std::min({step, 0.5 * (point[column] - p.smallest), 0.5 * (p.largest - point[column])});
  };
  if (column >= l.parameter(0) && column < l.state(0))
    keep_within(*call.component().description->parameters[column - l.parameter(0)]);
  if (column >= l.state(0) && column < l.input(0)) keep_within(*call.law().states[column - l.state(0)]);
  if (column >= l.input(0) && column < l.time()) keep_within(*call.law().inputs[column - l.input(0)]);
  if (column >= l.start_input(0) && column < l.columns(true))
    keep_within(*call.law().inputs[column - l.start_input(0)]);
  if (column < l.invariants && !call.several() && call.law().invariant != SPRINGNET_RELATIVE_SPEED) {
    // Within the declared stretches.
    const double reference = point[l.reference()];
    step = std::min({step, 0.9 * (point[column] - call.law().smallest_stretch * reference),
                     0.9 * (call.law().largest_stretch * reference - point[column])});
  }
  return step;
}

bool is_number(const LawCall& call, std::size_t column) {
  const sdk::JacobianLayout& l = call.layout();
  if (column < l.parameter(0) || column >= l.state(0)) return true;
  return call.component().description->parameters[column - l.parameter(0)]->type == SPRINGNET_NUMBER;
}

struct Count {
  std::size_t compared = 0, undecided = 0;
};

// A derivative that the law gives: in `derivatives`, or by its name.
struct Claim {
  std::size_t row, cell;
  bool in_matrix;
};

std::vector<Claim> claims_by(const LawCall& call, const Answer& answer, std::size_t column, bool of_update) {
  std::vector<Claim> claims;
  for (std::size_t row = 0; row < call.layout().rows(); ++row) {
    const std::size_t cell = call.cell(row, column, of_update);
    if (!answer.named.empty() && !answer.named[cell].empty()) claims.push_back({row, cell, false});
    if (!answer.matrix.empty() && !answer.matrix[cell].empty()) claims.push_back({row, cell, true});
  }
  return claims;
}

std::string wrong_derivative(ReadyLaw& ready, const Point& point, const How& how, Count& count) {
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  const bool of_update = how.time_step > 0.0;
  How with = how;
  with.derivatives = true;
  const Answer answer = call({point}, with);
  if (answer.status == SPRINGNET_RECOVERABLE) return {};
  if (answer.status != SPRINGNET_OK) return "it fails: " + answer.message;
  for (std::size_t column = 0; column < l.columns(of_update); ++column) {
    const std::vector<Claim> claims = claims_by(call, answer, column, of_update);
    const auto values_of = [](const Answer& from, const Claim& claim) -> const std::vector<double>& {
      return claim.in_matrix ? from.matrix[claim.cell] : from.named[claim.cell];
    };
    if (!call.reads(column, of_update)) {
      for (const Claim& claim : claims)
        if (const double claimed = values_of(answer, claim)[0];
            claimed != 0.0 && !(of_update && column >= l.start_value()))
          return fmt::format("the derivative of the {} by {} is {:.9g}, which the law does not read: write 0",
                             call.row_name(claim.row), call.column_name(column), claimed);
      continue;
    }
    const double step = 0.5 * reach(ready, ready.points(), point, column);
    if (claims.empty() || !is_number(call, column) || !(step > 0.0)) continue;
    const Pairs pairs = [&](const std::vector<double>& xs) {
      const Answer all = answers_along(call, point, column, xs, with);
      std::vector<Pair> result(claims.size());
      if (all.status == SPRINGNET_OK)
        for (std::size_t k = 0; k < claims.size(); ++k)
          result[k] = {all.rows[claims[k].row], values_of(all, claims[k])};
      return result;
    };
    const double from = point[column] - step, to = point[column] + step;
    const std::vector<Comparison> found = compare_over(pairs, from, to);
    for (std::size_t k = 0; k < claims.size(); ++k) {
      ++(found[k].verdict == Verdict::undecided ? count.undecided : count.compared);
      if (found[k].verdict != Verdict::differs) continue;
      return fmt::format(
          "the derivative of the {0} by {1}{2}{3} is {4:.9g} on average from {5:.6g} to {6:.6g}, where the {0} changes "
          "by {7:.9g} in {8:.6g}: {9:.3g} is missing (within {10:.1e}) {11}",
          call.row_name(claims[k].row), call.column_name(column), claims[k].in_matrix ? " in `derivatives`" : "",
          of_update ? " over a step" : "", found[k].integral / (to - from), from, to, found[k].change, to - from,
          (found[k].change - found[k].integral) / (to - from), found[k].error / (to - from), place(call, point));
    }
  }
  return {};
}

// "the energy depends on the rate …" if it is not that of the element at rest in time.
std::string energy_by_rate(const LawCall& call, const Point& point) {
  const sdk::JacobianLayout& l = call.layout();
  constexpr double tolerance = 1e-9;  // of what is added up: the energy, and the work over a tenth of the element
  std::vector<Point> points(3, point);
  for (std::size_t i = 0; i < l.invariants; ++i) {
    points[0][l.rate(i)] = 0.0;
    points[2][l.rate(i)] *= -1.0;
  }
  const Answer answer = call(points);
  if (answer.status != SPRINGNET_OK) return {};
  const std::vector<double>& energy = answer.rows[l.energy()];
  double scale = std::abs(energy[0]);
  for (std::size_t i = 0; i < l.invariants; ++i)
    if (call.reads_value(i)) scale += std::abs(answer.rows[i][0] * 0.1 * point[l.value(i)]);
  for (const std::size_t moving : {1u, 2u})
    if (std::abs(energy[moving] - energy[0]) > tolerance * scale)
      return fmt::format(
          "the energy depends on the rate: it is {:.9g} J without one, and {:.9g} J {}: what a rate adds "
          "is no potential, leave it out",
          energy[0], energy[moving], place(call, points[moving]));
  return {};
}

}  // namespace

Outcome check_energy(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  if (!call.has(SPRINGNET_HAS_ENERGY)) return {Result::passed, "has no energy"};
  Count count;
  for (Point point : ready.points().several(60)) {
    if (const std::string wrong = call.reads_rate() ? energy_by_rate(call, point) : ""; !wrong.empty())
      return {Result::failed, wrong};
    // At rest in time: what the rate adds has no potential.
    for (std::size_t i = 0; i < l.invariants; ++i) point[l.rate(i)] = 0.0;
    for (std::size_t i = 0; i < l.invariants; ++i) {
      if (!call.reads_value(i)) continue;
      const double step = 0.5 * reach(ready, ready.points(), point, l.value(i));
      const Pairs pairs = [&](const std::vector<double>& xs) {
        const Answer all = answers_along(call, point, l.value(i), xs, {});
        if (all.status != SPRINGNET_OK) return std::vector<Pair>(1);
        return std::vector<Pair>{{all.rows[l.energy()], all.rows[i]}};
      };
      const double from = point[l.value(i)] - step, to = point[l.value(i)] + step;
      const Comparison found = compare_over(pairs, from, to).front();
      ++(found.verdict == Verdict::undecided ? count.undecided : count.compared);
      if (found.verdict == Verdict::differs)
        return {
            Result::failed,
            fmt::format("the work of the {} from {} = {:.6g} to {:.6g} is {:.9g}, but the energy changes by {:.9g}: "
                        "{:.3g} is missing (within {:.1e}) {}: correct one of the two",
                        call.row_name(i), call.column_name(l.value(i)), from, to, found.integral, found.change,
                        found.change - found.integral, found.error, place(call, point))};
    }
  }
  if (count.compared == 0) return {Result::warned, "the energy is nowhere smooth enough to compare with"};
  return {Result::passed, fmt::format("{} comparisons", count.compared)};
}

Outcome check_derivatives(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  if (!call.has(SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_PARAMETER_DERIVATIVES | SPRINGNET_HAS_ALL_DERIVATIVES))
    return {Result::passed, "declares none; implicit integrators need them"};
  Count count;
  const std::size_t samples = call.several() ? 12 : 40;
  for (const Point& point : ready.points().several(samples)) {
    std::string wrong = wrong_derivative(ready, point, {}, count);
    for (std::uint32_t order = 1; wrong.empty() && call.layout().states > 0 && order <= call.law().update_order;
         ++order)
      wrong = wrong_derivative(ready, point, {.time_step = 0.01, .order = order}, count);
    if (!wrong.empty()) return {Result::failed, wrong};
  }
  if (count.compared == 0) return {Result::warned, "the law is nowhere smooth enough to compare with"};
  return {Result::passed,
          fmt::format("{} comparisons, {} undecided (kinks, rounding)", count.compared, count.undecided)};
}

// dE/dz of an energy: as declared, which `derivatives` tests, or by differences. error: what it may be off by.
double energy_by_state(ReadyLaw& ready, const Point& point, std::size_t i, double& error) {
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  const Answer answer = call({point}, {.derivatives = true});
  for (const Claim& claim :
       answer.status == SPRINGNET_OK ? claims_by(call, answer, l.state(i), false) : std::vector<Claim>{})
    if (claim.row == l.energy()) return (claim.in_matrix ? answer.matrix : answer.named)[claim.cell][0];
  const Slope slope = slopes(along(call, point, l.state(i)), point[l.state(i)],
                             reach(ready, ready.points(), point, l.state(i)))[l.energy()];
  error = slope.error;
  return slope.value;
}

// (Q - dE/dq) q' - dE/dz z' must not be negative. dE/dq is the force without a rate, which `energy` tests; without an
// energy what the rate adds, (Q(q') - Q(0)) q', must not be.
Outcome check_dissipation(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  if (call.has(SPRINGNET_ADDS_POWER)) return {Result::passed, "declares that it may add power"};
  const bool has_energy = call.has(SPRINGNET_HAS_ENERGY);
  const bool is_speed = !call.several() && call.law().invariant == SPRINGNET_RELATIVE_SPEED;
  if (l.states > 0 && !has_energy) return {Result::passed, "has states without an energy: not known"};
  if (l.states == 0 && !call.reads_rate() && !is_speed) return {Result::passed, "reads no rate"};
  const std::string declare = declaring(call.component(), "SPRINGNET_ADDS_POWER", "adds power");
  for (Point& point : ready.points().several(200)) {
    const std::vector<double> rows = call.rows_at(point);
    if (is_speed) {
      if (rows[0] < 0.0)
        return {Result::failed, fmt::format("the force {:.6g} speeds the ends up {}: turn its sign, or {}", rows[0],
                                            place(call, point), declare)};
      continue;
    }
    Point still = point;
    for (std::size_t i = 0; i < l.invariants; ++i) still[l.rate(i)] = 0.0;
    const std::vector<double> held = call.rows_at(still);
    double power = 0.0, uncertain = 0.0;
    constexpr double rounding = 1e-12;  // of terms that cancel
    for (std::size_t i = 0; i < l.invariants; ++i) {
      if (!call.reads_value(i)) continue;
      const double rate = point[l.rate(i)];
      const double stored = has_energy || !call.is_viscosity() ? held[i] : 0.0;
      power += (rows[i] - stored) * rate;
      uncertain += rounding * (std::abs(rows[i]) + std::abs(stored)) * std::abs(rate);
    }
    for (std::size_t i = 0; i < l.states; ++i) {
      double error = 0.0;
      const double by_state = energy_by_state(ready, point, i, error), rate = rows[l.state_row(i)];
      power -= by_state * rate;
      uncertain += (rounding * std::abs(by_state) + 30.0 * error) * std::abs(rate);
    }
    if (power < -uncertain)
      return {Result::failed,
              fmt::format("it adds the power {:.6g} {}: correct a sign, or {}", -power, place(call, point), declare)};
  }
  return {};
}

}  // namespace springnet::check
