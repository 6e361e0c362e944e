#include "functions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <mpfr.h>

#include <springnet/sdk/math.hpp>

namespace springnet::test {

// Two arguments of 53 bits and a result of many more.
struct MpfrNumbers {
  mpfr_t x, y, result, difference;
  MpfrNumbers() {
    mpfr_init2(x, 53);
    mpfr_init2(y, 53);
    mpfr_init2(result, 160);
    mpfr_init2(difference, 200);
  }
  ~MpfrNumbers() { mpfr_clears(x, y, result, difference, static_cast<mpfr_ptr>(nullptr)); }
  MpfrNumbers(const MpfrNumbers&) = delete;
  MpfrNumbers& operator=(const MpfrNumbers&) = delete;
};

namespace {

constexpr double huge = 1.7e308, tiny = 1e-323;

std::vector<Function> make_functions() {
  std::vector<Function> all;
  const auto one = [&all](const char* name, double bound, double (*ours)(double, double), int (*exact)(MpfrNumbers&),
                          std::vector<Range> ranges) {
    all.push_back({name, bound, ours, exact, ranges, {}});
  };
#define SPRINGNET_FUNCTION(name, bound, ...)                       \
  one(                                                             \
      #name, bound, [](double x, double) { return sdk::name(x); }, \
      [](MpfrNumbers& n) { return mpfr_##name(n.result, n.x, MPFR_RNDN); }, {__VA_ARGS__})
  SPRINGNET_FUNCTION(exp, 1, {-746, 710}, {-1, 1}, {tiny, 700, true, true});
  SPRINGNET_FUNCTION(expm1, 1, {-40, 710}, {-2, 2}, {tiny, 700, true, true});
  SPRINGNET_FUNCTION(log, 1, {0.5, 2}, {0, 10}, {tiny, huge, true});
  SPRINGNET_FUNCTION(log1p, 2, {-1, 2}, {-0.5, 0.5}, {1e-3, 1e5, true}, {tiny, huge, true}, {-1e-3, 1e-3});
  SPRINGNET_FUNCTION(log10, 2, {0.5, 2}, {0, 1000}, {tiny, huge, true});
  SPRINGNET_FUNCTION(sqrt, 0.5, {0, 4}, {tiny, huge, true});
  SPRINGNET_FUNCTION(cbrt, 2, {1, 8}, {tiny, huge, true, true});
  SPRINGNET_FUNCTION(sin, 2, {-4, 4}, {-33000, 33000}, {tiny, huge, true, true});
  SPRINGNET_FUNCTION(cos, 2, {-4, 4}, {-33000, 33000}, {tiny, huge, true, true});
  SPRINGNET_FUNCTION(tan, 2, {-4, 4}, {-33000, 33000}, {tiny, huge, true, true});
  SPRINGNET_FUNCTION(asin, 2, {-1, 1}, {tiny, 1, true, true});
  SPRINGNET_FUNCTION(acos, 2, {-1, 1}, {tiny, 1, true, true});
  SPRINGNET_FUNCTION(atan, 2, {-4, 4}, {tiny, huge, true, true});
  SPRINGNET_FUNCTION(sinh, 2, {-3, 3}, {-711, 711}, {tiny, 700, true, true});
  SPRINGNET_FUNCTION(cosh, 2, {-3, 3}, {-711, 711}, {tiny, 700, true, true});
  SPRINGNET_FUNCTION(tanh, 2, {-2, 2}, {-25, 25}, {tiny, 30, true, true});
  SPRINGNET_FUNCTION(erf, 2, {-3, 3}, {-6.5, 6.5}, {tiny, 7, true, true});
#undef SPRINGNET_FUNCTION
  one(
      "the slope beside expm1", 1, [](double x, double) { return sdk::detail::expm1_and_exp(x).value; },
      [](MpfrNumbers& n) { return mpfr_exp(n.result, n.x, MPFR_RNDN); },
      {{-746, 710}, {-1, 1}, {tiny, 700, true, true}});
  all.push_back({"pow",
                 2,
                 [](double x, double y) { return sdk::pow(x, y); },
                 [](MpfrNumbers& n) { return mpfr_pow(n.result, n.x, n.y, MPFR_RNDN); },
                 {{0.5, 2}, {0.9, 1.1}, {tiny, huge, true}, {0, 10}},
                 {{-900, 900}, {-7000, 7000}, {-2, 2}, {-10, 10}}});
  all.push_back({"atan2",
                 2,
                 [](double x, double y) { return sdk::atan2(x, y); },
                 [](MpfrNumbers& n) { return mpfr_atan2(n.result, n.x, n.y, MPFR_RNDN); },
                 {{-1, 1}, {tiny, huge, true, true}, {1e-3, 1e3, true, true}},
                 {{-1, 1}, {tiny, huge, true, true}, {-1, 1}}});
  all.push_back({"hypot",
                 2,
                 [](double x, double y) { return sdk::hypot(x, y); },
                 [](MpfrNumbers& n) { return mpfr_hypot(n.result, n.x, n.y, MPFR_RNDN); },
                 {{-1, 1}, {tiny, 1e308, true, true}, {1e-3, 1e3, true, true}},
                 {{-1, 1}, {tiny, 1e308, true, true}, {-1, 1}}});
  return all;
}

double draw(const Range& range, std::mt19937_64& random) {
  if (!range.by_exponent) return std::uniform_real_distribution<double>(range.low, range.high)(random);
  const double exponent = std::uniform_real_distribution<double>(std::log2(range.low), std::log2(range.high))(random);
  const double size = std::exp2(exponent) * (1.0 + 0x1p-53 * static_cast<double>(random() >> 40));
  const double bounded = std::min(size, range.high);
  return range.both_signs && (random() & 1) != 0 ? -bounded : bounded;
}

double error_of(MpfrNumbers& n, const Function& function, double x, double y) {
  mpfr_set_d(n.x, x, MPFR_RNDN);
  mpfr_set_d(n.y, y, MPFR_RNDN);
  function.exact(n);
  const double exact = mpfr_get_d(n.result, MPFR_RNDN), ours = function.ours(x, y);
  if (std::isnan(exact) && std::isnan(ours)) return 0.0;
  if (!std::isfinite(exact) || !std::isfinite(ours))
    return exact == ours ? 0.0 : std::numeric_limits<double>::infinity();
  int exponent = 0;
  std::frexp(exact, &exponent);
  mpfr_sub_d(n.difference, n.result, ours, MPFR_RNDN);
  mpfr_mul_2si(n.difference, n.difference, -std::max(exponent - 53, -1074), MPFR_RNDN);
  return std::abs(mpfr_get_d(n.difference, MPFR_RNDN));
}

}  // namespace

std::span<const Function> functions() {
  static const std::vector<Function> all = make_functions();
  return all;
}

double error_at(const Function& function, double x, double y) {
  MpfrNumbers numbers;
  return error_of(numbers, function, x, y);
}

Worst worst_error(const Function& function, std::uint64_t count, std::uint64_t seed) {
  MpfrNumbers numbers;
  std::mt19937_64 random(seed);
  Worst worst;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::size_t kind = i % function.ranges.size();
    const double x = draw(function.ranges[kind], random);
    const double y = function.ranges_2.empty() ? 0.0 : draw(function.ranges_2[kind], random);
    const double error = error_of(numbers, function, x, y);
    if (error > worst.error) worst = {error, x, y};
  }
  return worst;
}

}  // namespace springnet::test
