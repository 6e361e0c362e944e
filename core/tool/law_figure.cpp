#include "law_figure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <springnet/error.hpp>

#include "law_course.hpp"

namespace springnet::tool {

namespace {

constexpr std::size_t intervals = 400;

Numbers evenly(double from, double to) {
  Numbers result;
  for (std::size_t k = 0; k <= intervals; ++k)
    result.push_back(from + (to - from) * static_cast<double>(k) / static_cast<double>(intervals));
  return result;
}

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit == "1" ? name : name + ", " + unit;
}

struct Span {
  double from, to;
};

Span range_of(const LawCaller& caller, const LawCourse& course, const LawFigureOptions& options) {
  const double unit = course.is_stretch() ? course.x_of_stretch() : 1.0;
  if (options.range) return {options.range->first * unit, options.range->second * unit};
  Span range{course.default_from(), course.default_to()};
  if (!course.is_stretch()) return range;
  const double smallest = caller.law().smallest_stretch * unit, largest = caller.law().largest_stretch * unit;
  const double from = std::max(range.from, smallest), to = std::min(range.to, largest);
  if (from < to) return {from, to};
  return {smallest, std::min(largest, smallest + unit)};  // a law for long springs alone, or for short ones
}

// Intervals of x in which a curve is not finite.
void mark_gaps(FigurePanel& panel) {
  std::vector<FigureMark> gaps;
  for (const FigureCurve& curve : panel.curves) {
    for (std::size_t k = 0; k < curve.x.size(); ++k) {
      if (std::isfinite(curve.y[k])) continue;
      std::size_t end = k;
      while (end + 1 < curve.x.size() && !std::isfinite(curve.y[end + 1])) ++end;
      const FigureMark gap{
          k > 0 ? curve.x[k - 1] : curve.x[k], end + 1 < curve.x.size() ? curve.x[end + 1] : curve.x[end],
          curve.label.empty() || panel.curves.size() < 2 ? "not finite" : "not finite: " + curve.label};
      gaps.push_back(gap);
      k = end;
    }
  }
  constexpr std::size_t most = 4;  // words have a row each
  for (std::size_t k = most; k < gaps.size(); ++k) gaps[k].text.clear();
  panel.marks.insert(panel.marks.end(), gaps.begin(), gaps.end());
}

// Where the margin changes its sign.
std::vector<FigureMark> breaks_of(const Numbers& x, const Numbers& margin) {
  std::vector<FigureMark> marks;
  for (std::size_t k = 1; k < margin.size(); ++k) {
    if (!(margin[k - 1] <= 0.0 || margin[k] <= 0.0) || (margin[k - 1] <= 0.0 && margin[k] <= 0.0)) continue;
    const double share = margin[k - 1] / (margin[k - 1] - margin[k]);
    const double at = std::isfinite(share) ? x[k - 1] + share * (x[k] - x[k - 1]) : x[k];
    marks.push_back({at, at, fmt::format("breaks at {:.4g}", at)});
  }
  if (marks.empty() && !margin.empty() && margin.front() <= 0.0)
    marks.push_back({x.front(), x.back(), "broken everywhere here"});
  return marks;
}

class LawFigure {
 public:
  LawFigure(LawCaller& caller, const LawCourse& course, const LawFigureOptions& options)
      : caller_(caller), course_(course), options_(options), range_(range_of(caller, course, options)) {
    if (!(range_.to > range_.from))
      throw Error(ErrorKind::input,
                  fmt::format("--range: the curves go from {:g} to {:g}; give a smaller number, ':' and a larger one",
                              range_.from, range_.to));
  }

  void draw(Figure& figure) {
    const bool is_viscosity = caller_.component().kind() == ComponentKind::viscosity_function;
    const bool reads_rate = caller_.can(SPRINGNET_READS_RATE);
    if (!is_viscosity || !reads_rate) over_value(figure);
    if (reads_rate) over_rate(figure);
    if (caller_.law().state_count > 0 && caller_.law().update != nullptr) over_cycle(figure);
    if (!caller_.failure().empty())
      figure.notes.push_back("The law failed for some values, which are left out: " + caller_.failure());
  }

 private:
  // Forces of the same unit share a panel.
  void forces(Figure& figure, const std::string& x_label, const Numbers& x, const LawCurves& curves,
              const std::vector<FigureMark>& marks, const std::string& over = "") {
    std::vector<std::string> drawn;
    for (std::size_t i = 0; i < curves.forces.size(); ++i) {
      const LawCourse::Units units = course_.units(i);
      if (std::find(drawn.begin(), drawn.end(), units.force) != drawn.end()) continue;
      drawn.push_back(units.force);
      FigurePanel panel{
          x_label,
          with_unit((curves.forces.size() == 1 ? "force" : "forces on " + units.name + "s") + over, units.force),
          {},
          marks};
      for (std::size_t j = i; j < curves.forces.size(); ++j)
        if (course_.units(j).force == units.force && is_read(j)) add(panel, curves, j, x);
      if (panel.curves.empty()) continue;
      mark_gaps(panel);
      figure.panels.push_back(std::move(panel));
    }
  }
  // Equal curves, as those of the edges of a regular element, are one.
  void add(FigurePanel& panel, const LawCurves& curves, std::size_t i, const Numbers& x) const {
    const std::string own = corners_of_invariant(i);
    for (FigureCurve& other : panel.curves) {
      const bool same = std::equal(other.y.begin(), other.y.end(), curves.forces[i].begin(), [](double a, double b) {
        return std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b)) || (std::isnan(a) && std::isnan(b));
      });
      if (!same) continue;
      other.label += " " + own;
      return;
    }
    panel.curves.push_back({own, x, curves.forces[i]});
  }
  [[nodiscard]] bool is_read(std::size_t i) const {
    return course_.element().empty() || (caller_.law().invariants[i]->flags & SPRINGNET_REFERENCE_ONLY) == 0;
  }
  [[nodiscard]] std::string corners_of_invariant(std::size_t i) const {
    if (course_.element().empty()) return {};
    const springnet_invariant& one = *caller_.law().invariants[i];
    const std::size_t count = one.kind == SPRINGNET_LENGTH                                ? 2
                              : one.kind == SPRINGNET_ANGLE || one.kind == SPRINGNET_AREA ? 3
                                                                                          : 4;
    std::string text;
    for (std::size_t c = 0; c < count; ++c) text += static_cast<char>('0' + one.corners[c]);
    return text;
  }

  void over_value(Figure& figure) {
    const Numbers x = evenly(range_.from, range_.to);
    const LawCurves curves = caller_.evaluate(course_.values(x), course_.rates(Numbers(x.size(), 0.0)));
    std::vector<FigureMark> marks = outside(), of_breaks = breaks_of(x, curves.margin);
    marks.insert(marks.end(), of_breaks.begin(), of_breaks.end());
    const std::string label = with_unit(course_.name(), course_.unit());
    if (caller_.law().state_count > 0)
      figure.notes.push_back("Over the value, internal states are those with which the law starts.");
    forces(figure, label, x, curves, marks);
    const auto add_panel = [&](const std::string& y_label, const Numbers& y) {
      if (y.empty()) return;
      FigurePanel panel{label, y_label, {{"", x, y}}, marks};
      mark_gaps(panel);
      figure.panels.push_back(std::move(panel));
    };
    const LawCourse::Units units = course_.units(0);
    const bool is_speed = caller_.law().invariant == SPRINGNET_RELATIVE_SPEED;
    add_panel(with_unit(is_speed ? "damping dQ/dq" : "stiffness dQ/dq", units.by_value), curves.by_value);
    add_panel("energy, J", curves.energy);
  }

  void over_rate(Figure& figure) {
    const double widest = course_.is_stretch() ? course_.x_of_stretch() : 1.0;
    const Numbers speeds = evenly(-widest, widest);
    const LawCurves curves =
        caller_.evaluate(course_.values(Numbers(speeds.size(), course_.x_at_rest())), course_.rates(speeds));
    const std::string unit = course_.unit() == "1" ? "1/s" : course_.unit() + "/s";
    const std::string label = fmt::format("rate of the {} at its rest value, {}", course_.name(), unit);
    forces(figure, label, speeds, curves, {}, " over the rate");
    if (curves.by_rate.empty()) return;
    FigurePanel panel{label, with_unit("damping dQ/dq'", course_.units(0).by_rate), {{"", speeds, curves.by_rate}}, {}};
    mark_gaps(panel);
    figure.panels.push_back(std::move(panel));
  }

  // Small steps of the law's own `update`, three times round: the first cycle, and the last.
  void over_cycle(Figure& figure) {
    constexpr std::size_t cycles = 3;
    const double rest = course_.x_at_rest();
    const double amplitude = std::min(std::abs(range_.to - rest), std::abs(rest - range_.from));
    const double frequency = 2.0 * std::numbers::pi / options_.period;
    const double time_step = options_.period / static_cast<double>(intervals);
    const auto at = [&](double time) {
      return LawCaller::End{rest + amplitude * std::sin(frequency * time),
                            amplitude * frequency * std::cos(frequency * time)};
    };
    if (!(amplitude > 0.0)) {
      figure.notes.push_back(
          "No cycle is drawn: it would go to both sides of the rest value, which the range does not.");
      return;
    }
    FigureCurve first{"first cycle", {}, {}, true}, last{"third cycle", {}, {}};
    FigurePanel panel{with_unit(course_.name(), course_.unit()),
                      with_unit("force over a cycle", course_.units(0).force),
                      {},
                      {},
                      true};
    Numbers states = caller_.start(at(0.0).value, at(0.0).rate);
    for (std::size_t k = 1; k <= cycles * intervals; ++k) {
      const double before = time_step * static_cast<double>(k - 1), now = time_step * static_cast<double>(k);
      double force = 0.0, margin = 1.0;
      if (!caller_.step(now, time_step, at(before), at(now), states, force, margin)) break;
      if (k <= intervals) {
        first.x.push_back(at(now).value);
        first.y.push_back(force);
      } else if (k >= (cycles - 1) * intervals) {
        last.x.push_back(at(now).value);
        last.y.push_back(force);
      }
      if (margin > 0.0) continue;
      panel.marks.push_back({at(now).value, at(now).value, fmt::format("breaks after {:.3g} s", now)});
      break;
    }
    panel.curves.push_back(first);
    if (!last.x.empty()) panel.curves.push_back(last);
    figure.notes.push_back(fmt::format("Cycles: {:g} {} up and down, a sine with a period of {:g} s.", amplitude,
                                       course_.unit(), options_.period));
    figure.panels.push_back(std::move(panel));
  }

  // What of the range the law does not declare.
  [[nodiscard]] std::vector<FigureMark> outside() const {
    std::vector<FigureMark> marks;
    if (!course_.is_stretch()) return marks;
    const double unit = course_.x_of_stretch();
    const double smallest = caller_.law().smallest_stretch * unit, largest = caller_.law().largest_stretch * unit;
    const auto mark = [&](double from, double to) {
      if (from < to) marks.push_back({from, to, "outside of the law's range"});
    };
    mark(range_.from, std::min(smallest, range_.to));
    mark(std::max(largest, range_.from), range_.to);
    return marks;
  }

  LawCaller& caller_;
  const LawCourse& course_;
  const LawFigureOptions& options_;
  Span range_;
};

}  // namespace

Figure figure_of(const std::string& title, std::vector<std::string> notes, LawSetting setting,
                 const LawFigureOptions& options) {
  const LawCourse course(setting.component->law(), options.reference);
  setting.references = course.references();
  LawCaller caller(std::move(setting));
  Figure figure{title, std::move(notes), {}};
  if (!course.element().empty()) figure.notes.push_back(course.element() + ".");
  LawFigure(caller, course, options).draw(figure);
  return figure;
}

}  // namespace springnet::tool
