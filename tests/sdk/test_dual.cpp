// Dual numbers against complex steps (exact to rounding, f'(x) = Im f(x + i h) / h) where the standard library has the
// function for complex numbers, else against differences of eighth order.
#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <limits>

#include <springnet/sdk/dual.hpp>
#include <springnet/sdk/polynomial.hpp>

#include "law_call.hpp"

namespace {

using springnet::sdk::Dual;
using springnet::test::derivative;
using Complex = std::complex<double>;

constexpr double infinity = std::numeric_limits<double>::infinity();

Dual<1> variable(double x) { return Dual<1>::variable(x, 0); }

// Relative difference, absolute below 1.
double distance(double a, double b) { return std::abs(a - b) / std::max(1.0, std::abs(b)); }

template <class Function>
void check_with_complex_step(const Function& f, std::initializer_list<double> points) {
  for (const double x : points) {
    CAPTURE(x);
    const double step = 1e-30;
    const Dual<1> dual = f(variable(x));
    const double exact = f(Complex(x, step)).imag() / step;
    CHECK(dual.value == f(Dual<0>(x)).value);             // the same operations on the same numbers
    CHECK(distance(dual.derivatives[0], exact) < 1e-13);  // a few roundings in each
  }
}

template <class Function>
void check_with_differences(const Function& f, std::initializer_list<double> points) {
  for (const double x : points) {
    CAPTURE(x);
    const Dual<1> dual = f(variable(x));
    const auto value = [&f](double at) { return f(Dual<0>(at)).value; };
    CHECK(dual.value == value(x));
    // Step 1e-2: h^8 f^(9) / 630 and rounding 2e-16 / h are both below 1e-12 for functions of size one.
    CHECK(distance(dual.derivatives[0], derivative(value, x, 1e-2)) < 1e-11);
  }
}

}  // namespace

TEST_CASE("arithmetic of dual numbers") {
  check_with_complex_step([](auto x) { return x * x - 3.0 * x + 2.0; }, {-1.5, 0.0, 2.0});
  check_with_complex_step([](auto x) { return (x + 1.0) / (x * x + 2.0) - 1.0 / (4.0 - x); }, {-1.5, 0.0, 2.0});
  check_with_complex_step([](auto x) { return 2.0 / x - x / 3.0 + (1.0 - x) * 0.5; }, {-1.5, 0.3, 2.0});
  check_with_complex_step(
      [](auto x) {
        auto y = x;
        y += x;
        y *= x;
        y -= x;
        y /= x + 3.0;
        y += 1.0;
        y *= 2.0;
        y -= 0.5;
        y /= 4.0;
        return -y + (+x);
      },
      {-1.5, 0.0, 2.0});
}

TEST_CASE("polynomials of dual numbers") {
  using springnet::sdk::polynomial;
  for (const double x : {-1.5, 0.0, 0.3, 2.0}) {
    CAPTURE(x);
    // All derivatives of a polynomial whose coefficients vary as well, against those of the steps of Horner's rule.
    using D = Dual<4>;
    const D at = D::variable(x, 0), a = D::variable(0.7, 1), b = D::variable(-1.3, 2), c = D::variable(0.2, 3);
    const D ours = polynomial(at, a, b, 2.5, c), stepwise = a + at * (b + at * (2.5 + at * c));
    CHECK(ours.value == stepwise.value);
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(distance(ours.derivatives[i], stepwise.derivatives[i]) < 1e-15);  // the same sum in another order
    // Second derivatives, of which this has 2 b + 6 c x.
    using D2 = Dual<1, Dual<1>>;
    const D2 twice = polynomial(D2::variable(Dual<1>::variable(x, 0), 0), 0.7, -1.3, 0.4, 0.9);
    CHECK(distance(twice.value.derivatives[0], -1.3 + x * (0.8 + x * 2.7)) < 1e-15);
    CHECK(distance(twice.derivatives[0].value, -1.3 + x * (0.8 + x * 2.7)) < 1e-15);
    CHECK(distance(twice.derivatives[0].derivatives[0], 0.8 + 5.4 * x) < 1e-15);
  }
  CHECK(polynomial(2.0, 1.0, 3.0, 5.0) == 27.0);
  CHECK(polynomial(variable(2.0), 3.0).value == 3.0);
  CHECK(polynomial(variable(2.0), 3.0).derivatives[0] == 0.0);
}

TEST_CASE("functions of dual numbers that have a complex twin") {
  check_with_complex_step(
      [](auto x) {
        using std::sqrt;
        return sqrt(x);
      },
      {1e-3, 0.5, 7.0});
  check_with_complex_step(
      [](auto x) {
        using std::exp;
        return exp(x);
      },
      {-3.0, 0.0, 2.0});
  check_with_complex_step(
      [](auto x) {
        using std::log;
        return log(x);
      },
      {1e-3, 1.0, 7.0});
  check_with_complex_step(
      [](auto x) {
        using std::sin;
        return sin(x);
      },
      {-2.0, 0.0, 0.7});
  check_with_complex_step(
      [](auto x) {
        using std::cos;
        return cos(x);
      },
      {-2.0, 0.0, 0.7});
  check_with_complex_step(
      [](auto x) {
        using std::sinh;
        return sinh(x);
      },
      {-2.0, 0.0, 0.7});
  check_with_complex_step(
      [](auto x) {
        using std::cosh;
        return cosh(x);
      },
      {-2.0, 0.0, 0.7});
}

TEST_CASE("functions of dual numbers without a complex twin") {
  using namespace springnet::sdk;
  check_with_differences([](auto x) { return tan(x); }, {-0.3, 0.0, 0.4});
  check_with_differences([](auto x) { return tanh(x); }, {-0.9, 0.0, 0.4});
  check_with_differences([](auto x) { return asin(x); }, {-0.4, 0.0, 0.4});
  check_with_differences([](auto x) { return acos(x); }, {-0.4, 0.0, 0.4});
  check_with_differences([](auto x) { return atan(x); }, {-1.0, 0.0, 2.0});
  check_with_differences([](auto x) { return expm1(x); }, {-1.0, 0.0, 1.0});
  check_with_differences([](auto x) { return log1p(x); }, {-0.3, 0.0, 1.0});
  check_with_differences([](auto x) { return cbrt(x); }, {-2.0, 1.0});
  check_with_differences([](auto x) { return log10(x); }, {0.5, 3.0});
  check_with_differences([](auto x) { return erf(x); }, {-1.0, 0.0, 0.5});
  check_with_differences([](auto x) { return x * floor(x) + ceil(x); }, {-1.5, 0.5, 2.3});
  check_with_differences([](auto x) { return x * clamp(x, -1, 2); }, {-1.5, 0.5, 2.3});
  check_with_differences([](auto x) { return x * clamp(x, 0.5 * x, 2); }, {-1.5, 0.5, 2.3});
  check_with_differences([](auto x) { return x * max(x, 0) + min(1, x); }, {-1.5, 0.5, 2.3});
  check_with_differences([](auto x) { return abs(x) * x; }, {-2.0, 1.0});
  check_with_differences([](auto x) { return pow(x, 2.5); }, {1.0, 2.0});
  check_with_differences([](auto x) { return quick_pow(x, 2.5) + quick_pow(1.7, x) + quick_pow(x, x); }, {1.0, 2.0});
  check_with_differences([](auto x) { return pow(1.7, x); }, {-1.0, 0.0, 2.0});
  check_with_differences([](auto x) { return pow(x, x); }, {1.0, 1.5});
  check_with_differences([](auto x) { return hypot(x, 1.0 - x); }, {-1.0, 0.0, 2.0});
  check_with_differences([](auto x) { return atan2(x, 1.0 + x * x); }, {-1.0, 0.0, 2.0});
}

TEST_CASE("functions of duals have the values of those of numbers") {
  namespace sdk = springnet::sdk;
  for (double x = -3.0; x < 3.0; x += 0.01) {
    const Dual<2> dual = Dual<2>::variable(x, 1);
    CAPTURE(x);
    CHECK(exp(dual).value == sdk::exp(x));
    CHECK(sin(dual).value == sdk::sin(x));
    CHECK(tanh(dual).value == sdk::tanh(x));
    CHECK(erf(dual).value == sdk::erf(x));
    CHECK(pow(abs(dual), 1.7).value == sdk::pow(std::abs(x), 1.7));
    CHECK(atan2(dual, 0.3).value == sdk::atan2(x, 0.3));
    CHECK(hypot(0.3, dual).value == sdk::hypot(0.3, x));
  }
  // Numbers among themselves: of any types that are exact.
  CHECK(sdk::max(0.5, 0) == 0.5);
  CHECK(sdk::min(1, 0.5) == 0.5);
  CHECK(sdk::clamp(1.5, 0, 1) == 1.0);
}

TEST_CASE("several variables at once") {
  const auto x = Dual<3>::variable(2.0, 0);
  const auto y = Dual<3>::variable(3.0, 1);
  const Dual<3> z = x * x * y + y;
  CHECK(z.value == 15.0);
  CHECK(z.derivatives[0] == 12.0);
  CHECK(z.derivatives[1] == 5.0);
  CHECK(z.derivatives[2] == 0.0);
}

TEST_CASE("comparisons use the value; min and max take the derivative of the argument chosen") {
  const Dual<1> x = variable(2.0);
  CHECK(x == 2.0);
  CHECK(x > 1.0);
  CHECK(1.0 < x);
  CHECK(x <= Dual<1>(2.0));
  CHECK(x != variable(3.0));
  CHECK_FALSE(variable(std::nan("")) < 1.0);
  CHECK(min(x, 3.0).derivatives[0] == 1.0);
  CHECK(min(1.0, x).derivatives[0] == 0.0);
  CHECK(max(x, 3.0).derivatives[0] == 0.0);
  CHECK(max(x, Dual<1>(1.0)).derivatives[0] == 1.0);
  CHECK(springnet::sdk::value_of(x) == springnet::sdk::value_of(2.0));
  CHECK(std::isnan(max(variable(std::nan("")), 0.0).value));  // as std::max
}

TEST_CASE("where no derivative exists, the documented one is returned") {
  CHECK(abs(variable(0.0)).derivatives[0] == 0.0);
  CHECK(hypot(variable(0.0), variable(0.0)).derivatives[0] == 0.0);
  CHECK(sqrt(variable(0.0)).derivatives[0] == infinity);
  CHECK(sqrt(Dual<1>(0.0)).derivatives[0] == 0.0);  // a constant stays one
  CHECK(log(Dual<1>(0.0)).derivatives[0] == 0.0);
  CHECK(pow(variable(0.0), 2.0).derivatives[0] == 0.0);
  CHECK(pow(variable(0.0), 1.0).derivatives[0] == 1.0);
  CHECK(pow(variable(0.0), 0.0).derivatives[0] == 0.0);
  CHECK(pow(Dual<1>(0.0), variable(2.0)).derivatives[0] == 0.0);  // 0^y is constant for y > 0
}

TEST_CASE("second derivatives by nested duals, also of x^n by x and n where n is 0") {
  using Nested = Dual<1, Dual<1>>;
  const Nested x = Nested::variable(Dual<1>(2.0), 0);  // by x outside
  for (const double n : {0.0, 1.0, 2.5}) {
    const Nested by_both = pow(x, Nested(Dual<1>::variable(n, 0)));  // by n inside
    CHECK(by_both.derivatives[0].value == doctest::Approx(n * std::pow(2.0, n - 1.0)).epsilon(1e-15));
    CHECK(by_both.derivatives[0].derivatives[0] ==
          doctest::Approx(std::pow(2.0, n - 1.0) * (1.0 + n * std::log(2.0))).epsilon(1e-14));
  }
}
