// Zeros with signs, infinities, nan, subnormal numbers and pow's table of cases, as the C standard (Annex F) has them.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include <doctest/doctest.h>

#include <springnet/sdk/math.hpp>

namespace sdk = springnet::sdk;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity(),
                 not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double least = std::numeric_limits<double>::denorm_min(), largest = std::numeric_limits<double>::max();
constexpr double pi = 0x1.921fb54442d18p+1;

bool same(double a, double b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
  return a == b && std::signbit(a) == std::signbit(b);
}

struct Case {
  double x, result;
};
using One = double (*)(double);
void check(const char* name, One function, std::initializer_list<Case> cases) {
  CAPTURE(name);
  CHECK(std::isnan(function(not_a_number)));
  for (const Case& each : cases) {
    CAPTURE(each.x);
    CHECK_MESSAGE(same(function(each.x), each.result), function(each.x));
  }
}

}  // namespace

TEST_CASE("specials of functions of one argument") {
#define SPRINGNET_CHECK(name, ...) check(#name, [](double x) { return sdk::name(x); }, {__VA_ARGS__})
  SPRINGNET_CHECK(exp, {0.0, 1.0}, {-0.0, 1.0}, {infinity, infinity}, {-infinity, 0.0}, {largest, infinity},
                  {-largest, 0.0}, {least, 1.0}, {-745.2, 0.0}, {-745.1, least});
  SPRINGNET_CHECK(expm1, {0.0, 0.0}, {-0.0, -0.0}, {infinity, infinity}, {-infinity, -1.0}, {least, least},
                  {-least, -least}, {710.0, infinity}, {-700.5, -1.0}, {-745.5, -1.0}, {-largest, -1.0});
  check("the slope beside expm1", [](double x) { return sdk::detail::expm1_and_exp(x).value; },
        {{0.0, 1.0},
         {-0.0, 1.0},
         {infinity, infinity},
         {-infinity, 0.0},
         {largest, infinity},
         {-largest, 0.0},
         {least, 1.0},
         {-745.2, 0.0},
         {-745.1, least}});
  SPRINGNET_CHECK(log, {0.0, -infinity}, {-0.0, -infinity}, {1.0, 0.0}, {infinity, infinity}, {-infinity, not_a_number},
                  {-least, not_a_number}, {least, -0x1.74385446d71c3p+9});
  SPRINGNET_CHECK(log1p, {0.0, 0.0}, {-0.0, -0.0}, {-1.0, -infinity}, {infinity, infinity}, {-infinity, not_a_number},
                  {-1.5, not_a_number}, {least, least}, {-least, -least});
  SPRINGNET_CHECK(log10, {0.0, -infinity}, {-0.0, -infinity}, {1.0, 0.0}, {infinity, infinity}, {-1.0, not_a_number},
                  {1000.0, 3.0}, {1e-5, -5.0}, {1e22, 22.0});
  SPRINGNET_CHECK(sqrt, {0.0, 0.0}, {-0.0, -0.0}, {infinity, infinity}, {-1.0, not_a_number}, {0x1p-1074, 0x1p-537});
  SPRINGNET_CHECK(cbrt, {0.0, 0.0}, {-0.0, -0.0}, {infinity, infinity}, {-infinity, -infinity}, {-27.0, -3.0},
                  {1e-3, 0.1}, {least, 0x1p-358}, {-0x1p-1065, -0x1p-355});
  SPRINGNET_CHECK(sin, {0.0, 0.0}, {-0.0, -0.0}, {infinity, not_a_number}, {-infinity, not_a_number}, {least, least},
                  {-least, -least});
  SPRINGNET_CHECK(cos, {0.0, 1.0}, {-0.0, 1.0}, {infinity, not_a_number}, {-infinity, not_a_number}, {least, 1.0});
  SPRINGNET_CHECK(tan, {0.0, 0.0}, {-0.0, -0.0}, {infinity, not_a_number}, {-infinity, not_a_number}, {-least, -least});
  SPRINGNET_CHECK(asin, {0.0, 0.0}, {-0.0, -0.0}, {1.0, pi / 2}, {-1.0, -pi / 2}, {1.0 + 0x1p-52, not_a_number},
                  {-infinity, not_a_number}, {-least, -least});
  SPRINGNET_CHECK(acos, {0.0, pi / 2}, {1.0, 0.0}, {-1.0, pi}, {1.0 + 0x1p-52, not_a_number}, {infinity, not_a_number});
  SPRINGNET_CHECK(atan, {0.0, 0.0}, {-0.0, -0.0}, {infinity, pi / 2}, {-infinity, -pi / 2}, {1.0, pi / 4},
                  {-least, -least}, {largest, pi / 2});
  SPRINGNET_CHECK(sinh, {0.0, 0.0}, {-0.0, -0.0}, {infinity, infinity}, {-infinity, -infinity}, {-least, -least},
                  {711.0, infinity});
  SPRINGNET_CHECK(cosh, {0.0, 1.0}, {-0.0, 1.0}, {infinity, infinity}, {-infinity, infinity}, {-711.0, infinity});
  SPRINGNET_CHECK(tanh, {0.0, 0.0}, {-0.0, -0.0}, {infinity, 1.0}, {-infinity, -1.0}, {-least, -least}, {30.0, 1.0});
  SPRINGNET_CHECK(erf, {0.0, 0.0}, {-0.0, -0.0}, {infinity, 1.0}, {-infinity, -1.0}, {7.0, 1.0}, {least, least});
#undef SPRINGNET_CHECK
}

TEST_CASE("pow has all special cases of the C standard") {
  const auto is = [](double x, double y, double result) {
    CAPTURE(x);
    CAPTURE(y);
    CHECK_MESSAGE(same(sdk::pow(x, y), result), sdk::pow(x, y));
  };
  for (const double y : {1.0, 3.0, 9007199254740991.0}) {  // odd
    is(0.0, -y, infinity);
    is(-0.0, -y, -infinity);
    is(0.0, y, 0.0);
    is(-0.0, y, -0.0);
    is(-infinity, -y, -0.0);
    is(-infinity, y, -infinity);
    is(-1.0, y, -1.0);
  }
  for (const double y : {2.0, 0.5, 2.5, 4503599627370495.5, 9007199254740992.0, 1e300, least}) {  // not odd
    is(0.0, -y, infinity);
    is(-0.0, -y, infinity);
    is(0.0, y, 0.0);
    is(-0.0, y, 0.0);
    is(-infinity, -y, 0.0);
    is(-infinity, y, infinity);
  }
  for (const double y : {infinity, -infinity}) is(-1.0, y, 1.0);
  for (const double y : {0.0, -0.0, 3.0, -0.5, infinity, -infinity, not_a_number}) is(1.0, y, 1.0);
  for (const double x : {0.0, -0.0, 2.0, -3.0, infinity, -infinity, least, not_a_number}) {
    is(x, 0.0, 1.0);
    is(x, -0.0, 1.0);
  }
  for (const double y : {0.5, -1.5, least, -1e-300}) {  // not integer
    is(-1.0, y, not_a_number);
    is(-2.0, y, not_a_number);
    is(-largest, y, not_a_number);
  }
  for (const double x : {0.5, -0.5, 0.0, -0.0, least, 1.0 - 0x1p-53}) {
    is(x, -infinity, infinity);
    is(x, infinity, 0.0);
  }
  for (const double x : {1.5, -1.5, largest, infinity, -infinity, 1.0 + 0x1p-52}) {
    is(x, -infinity, 0.0);
    is(x, infinity, infinity);
  }
  for (const double y : {1.0, 2.0, 0.1, least}) {
    is(infinity, -y, 0.0);
    is(infinity, y, infinity);
  }
  for (const double x : {2.0, -1.0, 0.0, -0.0, infinity, -infinity}) is(x, not_a_number, not_a_number);
  for (const double y : {2.0, -1.0, infinity, -infinity}) is(not_a_number, y, not_a_number);
  is(-2.0, 3.0, -8.0);
  is(-2.0, -1074.0, least);
  is(-2.0, -1073.0, -0x1p-1073);
  is(-2.0, 1025.0, -infinity);
}

TEST_CASE("atan2 and hypot have all special cases of the C standard") {
  const auto is = [](double y, double x, double result) {
    CAPTURE(y);
    CAPTURE(x);
    CHECK_MESSAGE(same(sdk::atan2(y, x), result), sdk::atan2(y, x));
    CHECK_MESSAGE(same(sdk::atan2(-y, x), -result), sdk::atan2(-y, x));
  };
  is(0.0, -0.0, pi);
  is(0.0, 0.0, 0.0);
  for (const double x : {1.0, least, largest, infinity}) {
    is(0.0, x, 0.0);
    is(0.0, -x, pi);
  }
  for (const double y : {1.0, least, largest, infinity}) {
    is(y, 0.0, pi / 2);
    is(y, -0.0, pi / 2);
  }
  for (const double y : {0.0, 1.0, least, largest}) {
    is(y, -infinity, pi);
    is(y, infinity, 0.0);
  }
  for (const double x : {0.0, 1.0, -1.0, largest, -least}) is(infinity, x, pi / 2);
  is(infinity, infinity, pi / 4);
  is(infinity, -infinity, 3 * pi / 4);
  is(largest, largest, pi / 4);
  is(least, least, pi / 4);
  is(not_a_number, 1.0, not_a_number);
  is(1.0, not_a_number, not_a_number);
  is(not_a_number, infinity, not_a_number);

  CHECK(sdk::hypot(infinity, not_a_number) == infinity);
  CHECK(sdk::hypot(not_a_number, -infinity) == infinity);
  CHECK(std::isnan(sdk::hypot(not_a_number, 1.0)));
  CHECK(std::isnan(sdk::hypot(0.0, not_a_number)));
  CHECK(sdk::hypot(-3.0, 4.0) == 5.0);
  CHECK(sdk::hypot(0.0, -0.0) == 0.0);
  CHECK(sdk::hypot(3e-320, 4e-320) == doctest::Approx(5e-320));
  CHECK(sdk::hypot(3e307, 4e307) == doctest::Approx(5e307));
  CHECK(sdk::hypot(largest, largest) == infinity);
  CHECK(sdk::hypot(least, 0.0) == least);
}
