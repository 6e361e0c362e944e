// Central differences of functions that have different branches.
#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include <Eigen/Core>

namespace springnet::learning {

// The derivative of at(h) by h at 0, where it is `base`. Steps, `step` at first, are divided: part of a step that is
// too long lies in another branch, where `at` answers none, or has another slope on one side; and friction of small
// slips is curved. Differences are extrapolated as errors of second or first order (Richardson), until two of them
// agree best, as shorter steps have more rounding. typical: size of such derivatives; those that are much smaller are
// rounding. None: they do not agree, or the slope differs on both sides however short the steps are.
template <class At>
[[nodiscard]] std::optional<Eigen::VectorXd> settled_difference(const At& at, const Eigen::VectorXd& base, double step,
                                                                double typical) {
  constexpr double finer = 4.0, same = 1e-6, exact = 1e-8, one_slope = 1e-3;
  constexpr int most_finer = 8;
  using Difference = std::optional<Eigen::VectorXd>;
  bool is_kinked = false;
  const auto over = [&](double h) -> Difference {
    const Difference after = at(h);
    if (!after) return std::nullopt;
    const Difference before = at(-h);
    if (!before) return std::nullopt;
    Eigen::VectorXd result = (*after - *before) / (2.0 * h);
    is_kinked = (*after - 2.0 * base + *before).norm() > one_slope * h * std::max(typical, result.norm());
    return result;
  };
  Difference last = over(step), last_smooth, last_kinked, best;
  double least = same;
  for (int i = 0; i < most_finer; ++i) {
    Difference next = over(step /= finer), smooth, kinked;
    if (last && next) {
      const Eigen::VectorXd change = *next - *last;
      smooth = Eigen::VectorXd(*next + change / (finer * finer - 1.0));
      kinked = Eigen::VectorXd(*next + change / (finer - 1.0));
    }
    const double before = least;
    const auto compare = [&](const Difference& one, const Difference& other, const Difference& limit) {
      if (!one || !other) return;
      const double size = std::max(typical, one->norm());
      const double apart = size > 0.0 ? (*one - *other).norm() / size : 0.0;
      if (!(apart <= least) || is_kinked) return;
      least = apart;
      best = limit;
    };
    compare(next, last, smooth);
    compare(smooth, last_smooth, smooth);
    compare(kinked, last_kinked, kinked);
    if (best && (least <= exact || least == before)) return best;
    last = std::move(next);
    last_smooth = std::move(smooth);
    last_kinked = std::move(kinked);
  }
  return best;
}

}  // namespace springnet::learning
