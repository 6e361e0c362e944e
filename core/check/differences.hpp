// Derivatives by differences, with an estimate of their error.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace springnet::check {

// The derivative of one of several functions of a number.
struct Slope {
  double value = 0.0;
  double error = 0.0;  // estimate of what the value is off by; not finite: no estimate
};

// Values of all functions, [function][point], at the given points.
using Functions = std::function<std::vector<std::vector<double>>(const std::vector<double>&)>;

// Slopes of all functions at x, by Ridders' extrapolation of central differences with steps from `step` downwards.
// Functions that are not finite nearby have no finite error.
[[nodiscard]] std::vector<Slope> slopes(const Functions& functions, double x, double step);

}  // namespace springnet::check
