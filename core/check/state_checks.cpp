// states: steps of the internal state against the law's own rates.
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "check/law_checks.hpp"

namespace springnet::check {
namespace {

// An element that moves from one point to another in a straight line over a duration.
struct Path {
  Point from, to;
  double duration;  // s
  [[nodiscard]] Point at(const sdk::JacobianLayout& l, double share, const std::vector<double>& states) const {
    Point point = from;
    for (std::size_t c = 0; c < l.time(); ++c)
      if (c < l.reference() || (c >= l.input(0))) point[c] = from[c] + share * (to[c] - from[c]);
    for (std::size_t i = 0; i < l.invariants; ++i) point[l.rate(i)] = (to[l.value(i)] - from[l.value(i)]) / duration;
    std::copy(states.begin(), states.end(), point.begin() + static_cast<std::ptrdiff_t>(l.state(0)));
    point[l.time()] = from[l.time()] + share * duration;
    return point;
  }
};

std::vector<double> rates_at(const LawCall& call, const Point& point) {
  const std::vector<double> rows = call.rows_at(point);
  return {rows.begin() + static_cast<std::ptrdiff_t>(call.layout().state_row(0)), rows.end()};
}

// The law's rates, integrated by the classical Runge-Kutta method.
std::vector<double> integrated(const LawCall& call, const Path& path, std::vector<double> z, int parts) {
  const sdk::JacobianLayout& l = call.layout();
  const double h = path.duration / parts;
  const auto moved = [](const std::vector<double>& a, double by, const std::vector<double>& b) {
    std::vector<double> sum = a;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += by * b[i];
    return sum;
  };
  for (int k = 0; k < parts; ++k) {
    const double s = static_cast<double>(k) / parts, middle = (k + 0.5) / parts, end = (k + 1.0) / parts;
    const std::vector<double> a = rates_at(call, path.at(l, s, z)),
                              b = rates_at(call, path.at(l, middle, moved(z, 0.5 * h, a))),
                              c = rates_at(call, path.at(l, middle, moved(z, 0.5 * h, b))),
                              d = rates_at(call, path.at(l, end, moved(z, h, c)));
    for (std::size_t i = 0; i < z.size(); ++i) z[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
  }
  return z;
}

// Steps of the law's `update`. first, last: of the steps that are made.
std::vector<double> stepped(const LawCall& call, const Path& path, std::vector<double> z, int parts,
                            std::uint32_t order, int first, int last) {
  const sdk::JacobianLayout& l = call.layout();
  const double h = path.duration / parts;
  for (int k = first; k < last; ++k) {
    const Point before = path.at(l, static_cast<double>(k) / parts, z);
    Point after = path.at(l, (k + 1.0) / parts, z);
    for (std::size_t i = 0; i < l.invariants; ++i) {
      after[l.start_value(i)] = before[l.value(i)];
      after[l.start_rate(i)] = before[l.rate(i)];
    }
    for (std::size_t i = 0; i < l.inputs; ++i) after[l.start_input(i)] = before[l.input(i)];
    const std::vector<double> rows = call.rows_at(after, {.time_step = h, .order = order});
    z.assign(rows.begin() + static_cast<std::ptrdiff_t>(l.state_row(0)), rows.end());
  }
  return z;
}

// The largest difference in units of the states' scales.
double distance(const springnet_law& law, const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]) / law.states[i]->scale);
  return largest;
}

std::string outside(const springnet_law& law, const std::vector<double>& z) {
  for (std::size_t i = 0; i < z.size(); ++i)
    if (const std::string wrong = check_value(*law.states[i], z[i]); !wrong.empty())
      return fmt::format("state '{}' {}", law.states[i]->name, wrong);
  return {};
}

}  // namespace

Outcome check_states(const LawSubject& subject) {
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  const sdk::JacobianLayout& l = call.layout();
  const springnet_law& law = call.law();
  if (l.states == 0) return {Result::passed, "has no states"};
  constexpr int elements = 8, most_elements = 32, coarse = 16, fine = 2048;
  std::string report;
  for (std::uint32_t order = 1; order <= law.update_order; ++order) {
    std::vector<double> orders;
    int smooth = 0;
    for (int k = 0; k < most_elements && smooth < elements; ++k) {
      const Point from = ready.points().any();
      const std::vector<double> start = call.start_states(from, Memory::Layout::roomy);
      if (const std::string wrong = outside(law, start); !wrong.empty())
        return {Result::failed, fmt::format("at the start {} {}", wrong, place(call, from))};
      Path path{from, from, 0.3};
      for (std::size_t i = 0; i < l.invariants; ++i)
        path.to[l.value(i)] = from[l.value(i)] * ready.points().uniform(1.0, 1.2);
      const std::vector<double> exact = integrated(call, path, start, fine);
      // Where a path crosses a kink of the rates, every method is of first order. The reference itself shows it: else
      // half of its steps give the same.
      constexpr double same = 1e-11;
      const bool is_smooth = distance(law, exact, integrated(call, path, start, fine / 2)) < same;
      if (is_smooth) ++smooth;
      std::array<double, 3> errors{};
      for (std::size_t level = 0; level < errors.size(); ++level) {
        const int parts = coarse << level;
        const std::vector<double> end = stepped(call, path, start, parts, order, 0, parts);
        if (const std::string wrong = outside(law, end); !wrong.empty())
          return {Result::failed, fmt::format("after {} steps {} {}", parts, wrong, place(call, from))};
        errors[level] = distance(law, end, exact);
        if (level > 0) continue;
        // States are all that a step remembers: one that goes on from those saved gives the same bits.
        const std::vector<double> saved = stepped(call, path, start, parts, order, 0, parts / 2);
        static_cast<void>(stepped(call, path, start, parts, order, 0, 3));
        const std::vector<double> resumed = stepped(call, path, saved, parts, order, parts / 2, parts);
        for (std::size_t i = 0; i < end.size(); ++i)
          if (!same_bits(end[i], resumed[i]))
            return {Result::failed,
                    fmt::format("state '{}' is {} after steps without a pause, and {} if they go on from "
                                "saved states: keep no memory outside of the states",
                                law.states[i]->name, end[i], resumed[i])};
      }
      // Errors that rounding and the reference's own error make up tell nothing.
      constexpr double noise = 1e-7;
      if (errors[2] < noise) continue;
      if (is_smooth) orders.push_back(std::log2(errors[1] / errors[2]));
      // Across a kink errors fall irregularly, within a bound that falls with the step.
      constexpr int parts = 32 * coarse;
      const double finest =
          is_smooth ? errors[2] : distance(law, stepped(call, path, start, parts, order, 0, parts), exact);
      if (!(finest < 0.7 * (is_smooth ? errors[0] : *std::max_element(errors.begin(), errors.end()))))
        return {
            Result::failed,
            fmt::format("steps of order {} do not approach what the rates give: with {}, {}, {} steps they are off by "
                        "{:.3g}, {:.3g}, {:.3g} scales {}",
                        order, coarse, 2 * coarse, 4 * coarse, errors[0], errors[1], errors[2], place(call, from))};
    }
    if (orders.empty()) {
      report += fmt::format("{}order {}: {}", report.empty() ? "" : ", ", order,
                            smooth > 0 ? "exact" : "not seen, all rates have kinks");
      continue;
    }
    std::sort(orders.begin(), orders.end());
    const double seen = orders[orders.size() * 3 / 4];
    if (seen < order - 0.35)
      return {Result::failed,
              fmt::format("steps of order {} have the order {:.2f}: correct update_order or the update", order, seen)};
    report += fmt::format("{}order {}: {:.2f} seen", report.empty() ? "" : ", ", order, seen);
  }
  return {Result::passed, report};
}

}  // namespace springnet::check
