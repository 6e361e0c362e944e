#include "learning/guess_weight.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace springnet::learning {

namespace {

constexpr double close_enough = 1.1;    // ratio of weights
constexpr double nearly_there = 0.998;  // of the noise

// Tries weights, and keeps the curve.
class Curve {
 public:
  explicit Curve(const GuessSearch& search) : search_(search) {}
  GuessTrial run(double weight, const Eigen::VectorXd* from) {
    GuessTrial found = search_(weight, from);
    points_.push_back(found.point);
    return found;
  }
  [[nodiscard]] GuessChoice choose(GuessTrial found, std::string note) {
    std::stable_sort(points_.begin(), points_.end(),
                     [](const GuessPoint& a, const GuessPoint& b) { return a.weight > b.weight; });
    return {std::move(found), std::move(points_), std::move(note)};
  }

 private:
  const GuessSearch& search_;
  std::vector<GuessPoint> points_;
};

// Of the curve at a point, from its neighbours; positive where it turns from falling differences to growing distance.
double bend(const GuessPoint& greater, const GuessPoint& own, const GuessPoint& smaller) {
  const auto x = [](const GuessPoint& of) { return std::log(of.rms); };
  const auto y = [](const GuessPoint& of) { return std::log(of.distance); };
  const double x1 = 0.5 * (x(smaller) - x(greater)), y1 = 0.5 * (y(smaller) - y(greater));
  const double x2 = x(smaller) - 2.0 * x(own) + x(greater), y2 = y(smaller) - 2.0 * y(own) + y(greater);
  const double length = std::hypot(x1, y1);
  constexpr double shortest =
      0.02;  // of the logarithms: where the curve hardly goes on, its bends are those of searches
  if (!(length > shortest)) return 0.0;
  const double result = (x2 * y1 - x1 * y2) / (length * length * length);
  return std::isfinite(result) ? result : 0.0;
}

}  // namespace

GuessChoice weight_by_discrepancy(double greatest, double rms_of_guess, std::size_t observed,
                                  const GuessSearch& search) {
  constexpr int decades = 14;
  Curve curve(search);
  GuessTrial above = curve.run(greatest, nullptr), within = above;
  if (above.stopped) return curve.choose(std::move(above), {});
  if (rms_of_guess <= 1.0)
    return curve.choose(
        std::move(above),
        "The guess agrees with the observations within their standard deviations: they give no reason to "
        "leave it.");
  for (int decade = 1; above.point.rms <= 1.0 && decade <= decades; ++decade) {
    within = std::move(above);
    above = curve.run(greatest * std::pow(10.0, decade), nullptr);
    if (above.stopped) return curve.choose(std::move(above), {});
  }
  for (int decade = 1; within.point.rms > 1.0; ++decade) {
    above = std::move(within);
    if (decade > decades) {
      const double by_chance = 1.0 + 3.0 / std::sqrt(2.0 * static_cast<double>(observed));
      const char* const meaning = above.point.rms <= by_chance ? "which chance may do; the least weight was taken"
                                                               : "with the least weight: the model does not describe "
                                                                 "what was observed as well as the standard deviations "
                                                                 "say, or they are too small";
      std::string note =
          fmt::format("No weight of the guess brings the rms of the weighted differences to 1; it is {:.4g}, {}.",
                      above.point.rms, meaning);
      return curve.choose(std::move(above), std::move(note));
    }
    within = curve.run(greatest * std::pow(10.0, -decade), &above.x);
    if (within.stopped) return curve.choose(std::move(within), {});
  }
  for (int step = 0; above.point.weight > close_enough * within.point.weight && within.point.rms < nearly_there;
       ++step) {
    // Interpolated between logarithms; every other time halved, as interpolation comes from one side alone.
    const double low = std::log(within.point.rms), high = std::log(above.point.rms);
    const double share = step % 2 == 0 ? std::clamp(-low / (high - low), 0.1, 0.9) : 0.5;
    const double weight = within.point.weight * std::pow(above.point.weight / within.point.weight, share);
    GuessTrial next = curve.run(weight, &within.x);
    if (next.stopped) return curve.choose(std::move(next), {});
    (next.point.rms <= 1.0 ? within : above) = std::move(next);
  }
  return curve.choose(std::move(within), {});
}

GuessChoice weight_by_l_curve(double greatest, const GuessSearch& search) {
  constexpr int steps = 24;  // of half a decade
  constexpr double flat = 1e-3;
  Curve curve(search);
  std::vector<GuessTrial> trials;
  for (int step = 0; step <= steps; ++step) {
    trials.push_back(curve.run(greatest * std::pow(10.0, -0.5 * step), trials.empty() ? nullptr : &trials.back().x));
    if (trials.back().stopped) return curve.choose(std::move(trials.back()), {});
    // Past the corner nothing follows but values that run away, or stay where the data determine all of them.
    if (step < 4) continue;
    const GuessPoint &first = trials.front().point, &before = trials[trials.size() - 3].point,
                     &own = trials.back().point;
    const bool stays = own.rms > (1.0 - flat) * before.rms && own.rms < 0.9 * first.rms;
    if (stays && (own.distance > 2.0 * before.distance || own.distance < 1.01 * before.distance)) break;
  }
  std::size_t corner = 0;
  double greatest_bend = 0.1;  // less is no corner: radius 10 of the logarithms
  for (std::size_t k = 1; k + 1 < trials.size(); ++k) {
    const double own = bend(trials[k - 1].point, trials[k].point, trials[k + 1].point);
    if (own <= greatest_bend) continue;
    greatest_bend = own;
    corner = k;
  }
  if (corner > 0) return curve.choose(std::move(trials[corner]), {});
  return curve.choose(std::move(trials.back()), "The L-curve has no corner: the least weight of the guess was taken.");
}

}  // namespace springnet::learning
