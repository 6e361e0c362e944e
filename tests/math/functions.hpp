// The functions of sdk/math.hpp beside those of MPFR, with arguments to compare them on.
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace springnet::test {

// Arguments of one kind: evenly spread in [low, high], or spread evenly in the exponent, with both signs if
// `both_signs`.
struct Range {
  double low, high;
  bool by_exponent = false, both_signs = false;
};

struct Function {
  std::string name;
  double bound;  // ulp
  double (*ours)(double x, double y);
  // An MPFR function of one or two arguments.
  int (*exact)(struct MpfrNumbers&);
  std::vector<Range> ranges;    // of x
  std::vector<Range> ranges_2;  // of y; empty for functions of one argument
};

[[nodiscard]] std::span<const Function> functions();

// The largest error on `count` random arguments, spread over the ranges, in units of the last place of the exact
// result; infinite if one is nan or infinite and the other is not.
struct Worst {
  double error = 0.0, x = 0.0, y = 0.0;
};
[[nodiscard]] Worst worst_error(const Function& function, std::uint64_t count, std::uint64_t seed);

// At one pair of arguments.
[[nodiscard]] double error_at(const Function& function, double x, double y);

}  // namespace springnet::test
