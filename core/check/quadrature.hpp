// Derivatives against the functions that they are of: the integral of a derivative is the function's change. Gauss's
// quadrature gives it to rounding where the function is smooth, so that mistakes show that differences would not.
#pragma once

#include <functional>
#include <vector>

namespace springnet::check {

// A function and its claimed derivative at some points. Empty: not known there, or not finite.
struct Pair {
  std::vector<double> values, derivatives;
};
// Of several functions, [pair], at the given points.
using Pairs = std::function<std::vector<Pair>(const std::vector<double>&)>;

// undecided: the integral is not accurate enough, as across a kink.
enum class Verdict { agrees, differs, undecided };

struct Comparison {
  Verdict verdict = Verdict::undecided;
  double change = 0.0;    // of the function from one end to the other
  double integral = 0.0;  // of its claimed derivative
  double error = 0.0;     // estimate of what the two may differ by
};

// Compares all pairs over an interval. The error is estimated from two orders of quadrature and from how the difference
// scatters between intervals that are nearly the same, which is rounding, whatever a formula makes of it. What differs
// must do so in most parts of the interval, too: a kink lies in one of them.
[[nodiscard]] std::vector<Comparison> compare_over(const Pairs& pairs, double from, double to);

}  // namespace springnet::check
