// Derivatives by differences, with an estimate of their error.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace springnet::check {

// The derivative of one of several functions of a number.
struct Slope {
  double value = 0.0;
  double error = 0.0;              // estimate of what the value is off by; not finite: no estimate
  double left = 0.0, right = 0.0;  // from each side
  double side_error = 0.0;         // estimate for these
  // Whether the sides agree within their errors, and these are small against `size` or the slopes themselves: else
  // there is a kink, or a jump, nearby.
  [[nodiscard]] bool smooth(double size = 0.0) const noexcept;
};

// How a value compares with a slope. undecided: the slope is not accurate enough, or there is a kink.
enum class Verdict { agrees, differs, undecided };
[[nodiscard]] Verdict compare(double claimed, const Slope& slope);

// Values of all functions, [function][point], at the given points.
using Functions = std::function<std::vector<std::vector<double>>(const std::vector<double>&)>;

// Slopes of all functions at x, by Ridders' extrapolation of central differences with steps from `step` downwards, and
// one-sided ones. Functions that are not finite nearby have no finite error.
[[nodiscard]] std::vector<Slope> slopes(const Functions& functions, double x, double step);

// Whether a value differs from a function's slope for finer steps, too. Extrapolation across a kink nearby may converge
// to a wrong slope; it does so for steps that reach the kink, and not for ones that do not.
[[nodiscard]] bool differs_for_all_steps(double claimed, const Functions& functions, std::size_t function, double x,
                                         double step);

}  // namespace springnet::check
