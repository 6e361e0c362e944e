// energy, derivatives, dissipation, promises: what a law says of its force against differences of it.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "check/differences.hpp"
#include "check/law_checks.hpp"

namespace springnet::check {
namespace {

// A law's rows as functions of one column.
Functions along(const LawCall& call, const Point& point, std::size_t column, const How& how) {
  return [&call, point, column, how](const std::vector<double>& xs) {
    std::vector<Point> points(xs.size(), point);
    for (std::size_t k = 0; k < xs.size(); ++k) points[k][column] = xs[k];
    // A column that all elements share: the time.
    if (column == call.layout().time()) {
      std::vector<std::vector<double>> rows(call.layout().rows());
      for (const Point& each : points) {
        const Answer answer = call({each}, how);
        for (std::size_t row = 0; row < rows.size() && row < answer.rows.size(); ++row)
          if (!answer.rows[row].empty()) rows[row].push_back(answer.rows[row][0]);
      }
      return rows;
    }
    Answer answer = call(points, how);
    if (answer.status != SPRINGNET_OK) answer.rows.assign(call.layout().rows(), {});
    return answer.rows;
  };
}

// The first step of differences: a tenth of the value's size, no further than half of the way to the bounds.
double first_step(const ReadyLaw& ready, const Points& points, const Point& point, std::size_t column) {
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
    std::vector<Slope> found;
    for (std::size_t row = 0; row < l.rows(); ++row) {
      const std::size_t cell = call.cell(row, column, of_update);
      for (const auto* claims : {&answer.named, &answer.matrix}) {
        if (claims->empty() || (*claims)[cell].empty()) continue;
        const double claimed = (*claims)[cell][0];
        if (!call.reads(column, of_update)) {
          if (claimed != 0.0 && !(of_update && column >= l.start_value()))
            return fmt::format("the derivative of the {} by {} is {:.9g}, which the law does not read: write 0",
                               call.row_name(row), call.column_name(column), claimed);
          continue;
        }
        if (!is_number(call, column)) continue;
        if (found.empty()) {
          const double step = first_step(ready, ready.points(), point, column);
          if (!(step > 0.0)) break;
          found = slopes(along(call, point, column, how), point[column], step);
        }
        const Verdict verdict = compare(claimed, found[row]);
        ++(verdict == Verdict::undecided ? count.undecided : count.compared);
        if (verdict != Verdict::differs) continue;
        const double step = first_step(ready, ready.points(), point, column);
        if (!differs_for_all_steps(claimed, along(call, point, column, how), row, point[column], step)) continue;
        const char* const source = claims == &answer.matrix ? " in `derivatives`" : "";
        return fmt::format("the derivative of the {} by {}{}{} is {:.9g}, differences give {:.9g} (within {:.1e}) {}",
                           call.row_name(row), call.column_name(column), source, of_update ? " over a step" : "",
                           claimed, found[row].value, found[row].error, place(call, point));
      }
    }
  }
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
    // At rest in time: what the rate adds has no potential.
    for (std::size_t i = 0; i < l.invariants; ++i) point[l.rate(i)] = 0.0;
    const std::vector<double> rows = call.rows_at(point);
    for (std::size_t i = 0; i < l.invariants; ++i) {
      if (!call.reads_value(i)) continue;
      const double step = first_step(ready, ready.points(), point, l.value(i));
      const Slope slope = slopes(along(call, point, l.value(i), {}), point[l.value(i)], step)[l.energy()];
      const Verdict verdict = compare(rows[i], slope);
      ++(verdict == Verdict::undecided ? count.undecided : count.compared);
      if (verdict == Verdict::differs &&
          differs_for_all_steps(rows[i], along(call, point, l.value(i), {}), l.energy(), point[l.value(i)], step))
        return {Result::failed,
                fmt::format("the {} is {:.9g}, the energy's derivative {:.9g} (within {:.1e}) {}: correct "
                            "one of the two",
                            call.row_name(i), rows[i], slope.value, slope.error, place(call, point))};
    }
  }
  if (count.compared == 0) return {Result::warned, "differences of the energy are too inaccurate to compare with"};
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
  if (count.compared == 0) return {Result::warned, "differences of the law are too inaccurate to compare with"};
  return {Result::passed,
          fmt::format("{} comparisons, {} undecided (kinks, rounding)", count.compared, count.undecided)};
}

// (Q - dE/dq) q' - dE/dz z' must not be negative; without an energy what the rate adds, (Q(q') - Q(0)) q'.
Outcome check_dissipation(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  if (call.has(SPRINGNET_ADDS_POWER)) return {Result::passed, "declares that it may add power"};
  const bool has_energy = call.has(SPRINGNET_HAS_ENERGY);
  const bool is_speed = !call.several() && call.law().invariant == SPRINGNET_RELATIVE_SPEED;
  if (l.states > 0 && !has_energy) return {Result::passed, "has states without an energy: not known"};
  if (l.states == 0 && !call.reads_rate() && !is_speed) return {Result::passed, "reads no rate"};
  const Result wrong = can_declare(call.component()) ? Result::failed : Result::warned;
  for (Point& point : ready.points().several(200)) {
    const std::vector<double> rows = call.rows_at(point);
    if (is_speed) {
      if (rows[0] < 0.0)
        return {wrong, fmt::format("the force {:.6g} speeds the ends up {}: turn its sign, or declare "
                                   "SPRINGNET_ADDS_POWER",
                                   rows[0], place(call, point))};
      continue;
    }
    Point still = point;
    for (std::size_t i = 0; i < l.invariants; ++i) still[l.rate(i)] = 0.0;
    const std::vector<double> held = call.rows_at(still);
    double power = 0.0, scale = 0.0;
    const auto add = [&](double term, double parts) {
      power += term;
      scale += std::abs(parts);
    };
    const auto energy_by = [&](std::size_t column) {
      return slopes(along(call, point, column, {}), point[column],
                    first_step(ready, ready.points(), point, column))[l.energy()];
    };
    for (std::size_t i = 0; i < l.invariants; ++i) {
      if (!call.reads_value(i)) continue;
      const double rate = point[l.rate(i)];
      if (has_energy) {
        const Slope slope = energy_by(l.value(i));
        add((rows[i] - slope.value) * rate, (std::abs(rows[i]) + std::abs(slope.value)) * rate);
        scale += 1e6 * slope.error * std::abs(rate);
      } else if (call.is_viscosity()) {
        add(rows[i] * rate, rows[i] * rate);
      } else {
        add((rows[i] - held[i]) * rate, (std::abs(rows[i]) + std::abs(held[i])) * rate);
      }
    }
    for (std::size_t i = 0; i < l.states; ++i) {
      const Slope slope = energy_by(l.state(i));
      const double rate = rows[l.state_row(i)];
      add(-slope.value * rate, slope.value * rate);
      scale += 1e6 * slope.error * std::abs(rate);
    }
    constexpr double rounding = 1e-6;  // of terms that cancel, and of the differences
    if (power < -rounding * scale)
      return {wrong, fmt::format("it adds the power {:.6g} {}: correct a sign, or declare SPRINGNET_ADDS_POWER", -power,
                                 place(call, point))};
  }
  return {};
}

}  // namespace springnet::check
