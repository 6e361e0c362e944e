// Central differences of functions that have different branches.
#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include <Eigen/Core>

namespace springnet::learning {

// The derivative of at(h) by h at 0; where that has a kink, the mean of both sides. Steps, `step` at first, are divided
// until two differences agree, or two of those that are extrapolated as errors of second or first order (Richardson):
// part of a step that is too long lies in another branch, where `at` answers none; and friction of small slips is
// curved. typical: size of such derivatives; those that are much smaller are rounding. None: they do not agree.
template <class At>
[[nodiscard]] std::optional<Eigen::VectorXd> settled_difference(const At& at, double step, double typical) {
  constexpr double finer = 4.0, same = 1e-6;
  constexpr int most_finer = 8;
  using Difference = std::optional<Eigen::VectorXd>;
  const auto over = [&](double h) -> Difference {
    const Difference after = at(h);
    if (!after) return std::nullopt;
    const Difference before = at(-h);
    if (!before) return std::nullopt;
    return Eigen::VectorXd((*after - *before) / (2.0 * h));
  };
  const auto agree = [&](const Difference& one, const Difference& other) {
    return one && other && (*one - *other).norm() <= same * std::max(typical, one->norm());
  };
  Difference last = over(step), last_smooth, last_kinked;
  for (int i = 0; i < most_finer; ++i) {
    Difference next = over(step /= finer), smooth, kinked;
    if (last && next) {
      const Eigen::VectorXd change = *next - *last;
      smooth = Eigen::VectorXd(*next + change / (finer * finer - 1.0));
      kinked = Eigen::VectorXd(*next + change / (finer - 1.0));
    }
    if (agree(next, last) || agree(smooth, last_smooth)) return smooth;
    if (agree(kinked, last_kinked)) return kinked;
    last = std::move(next);
    last_smooth = std::move(smooth);
    last_kinked = std::move(kinked);
  }
  return std::nullopt;
}

}  // namespace springnet::learning
