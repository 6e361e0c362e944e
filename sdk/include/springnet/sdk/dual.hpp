// Forward-mode dual numbers: a value together with its derivatives with respect to N variables. Laws are templates over
// their number type; with Dual in place of double the same formula gives exact derivatives.
//
// Comparisons use the value only. The value of every operation is computed exactly as for double. Conventions where a
// derivative does not exist: abs, floor and ceil take 0, min, max and clamp that of the argument chosen; a function
// with an infinite slope (sqrt at 0, …) keeps a derivative of 0, so that constants stay constants.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstddef>

#include <springnet/sdk/math.hpp>

namespace springnet::sdk {

// Dual<0> is a value without derivatives, of the size of a double: laws and neurons get it for what they compute
// itself. It is not double, so that an unqualified exp(x) in a formula is the one here and never that of the C library.
template <std::size_t N>
struct Dual {
  double value = 0.0;
  [[no_unique_address]] std::array<double, N> derivatives{};

  constexpr Dual() = default;
  // A constant; implicit, so that laws may mix numbers and duals.
  SPRINGNET_INLINE constexpr Dual(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor)
  // The variable with number `index`.
  [[nodiscard]] static constexpr Dual variable(double value, std::size_t index) {
    Dual result(value);
    result.derivatives[index] = 1.0;
    return result;
  }

  SPRINGNET_INLINE constexpr Dual& operator+=(const Dual& b) {
    value += b.value;
    for (std::size_t i = 0; i < N; ++i) derivatives[i] += b.derivatives[i];
    return *this;
  }
  SPRINGNET_INLINE constexpr Dual& operator-=(const Dual& b) {
    value -= b.value;
    for (std::size_t i = 0; i < N; ++i) derivatives[i] -= b.derivatives[i];
    return *this;
  }
  SPRINGNET_INLINE constexpr Dual& operator*=(const Dual& b) {
    for (std::size_t i = 0; i < N; ++i) derivatives[i] = derivatives[i] * b.value + value * b.derivatives[i];
    value *= b.value;
    return *this;
  }
  SPRINGNET_INLINE constexpr Dual& operator/=(const Dual& b) {
    value /= b.value;
    for (std::size_t i = 0; i < N; ++i) derivatives[i] = (derivatives[i] - value * b.derivatives[i]) / b.value;
    return *this;
  }
  SPRINGNET_INLINE constexpr Dual& operator+=(double b) {
    value += b;
    return *this;
  }
  SPRINGNET_INLINE constexpr Dual& operator-=(double b) {
    value -= b;
    return *this;
  }
  SPRINGNET_INLINE constexpr Dual& operator*=(double b) {
    value *= b;
    for (double& d : derivatives) d *= b;
    return *this;
  }
  SPRINGNET_INLINE constexpr Dual& operator/=(double b) {
    value /= b;
    for (double& d : derivatives) d /= b;
    return *this;
  }

  friend SPRINGNET_INLINE constexpr Dual operator+(const Dual& a) { return a; }
  friend SPRINGNET_INLINE constexpr Dual operator-(const Dual& a) {
    Dual result(-a.value);
    for (std::size_t i = 0; i < N; ++i) result.derivatives[i] = -a.derivatives[i];
    return result;
  }
  friend SPRINGNET_INLINE constexpr Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend SPRINGNET_INLINE constexpr Dual operator+(Dual a, double b) { return a += b; }
  friend SPRINGNET_INLINE constexpr Dual operator+(double a, Dual b) { return b += a; }
  friend SPRINGNET_INLINE constexpr Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend SPRINGNET_INLINE constexpr Dual operator-(Dual a, double b) { return a -= b; }
  friend SPRINGNET_INLINE constexpr Dual operator-(double a, const Dual& b) { return Dual(a) -= b; }
  friend SPRINGNET_INLINE constexpr Dual operator*(Dual a, const Dual& b) { return a *= b; }
  friend SPRINGNET_INLINE constexpr Dual operator*(Dual a, double b) { return a *= b; }
  friend SPRINGNET_INLINE constexpr Dual operator*(double a, Dual b) { return b *= a; }
  friend SPRINGNET_INLINE constexpr Dual operator/(Dual a, const Dual& b) { return a /= b; }
  friend SPRINGNET_INLINE constexpr Dual operator/(Dual a, double b) { return a /= b; }
  friend SPRINGNET_INLINE constexpr Dual operator/(double a, const Dual& b) { return Dual(a) /= b; }

  friend SPRINGNET_INLINE constexpr bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend SPRINGNET_INLINE constexpr bool operator==(const Dual& a, double b) { return a.value == b; }
  friend SPRINGNET_INLINE constexpr auto operator<=>(const Dual& a, const Dual& b) { return a.value <=> b.value; }
  friend SPRINGNET_INLINE constexpr auto operator<=>(const Dual& a, double b) { return a.value <=> b; }
};

// The value without derivatives; also for double.
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr double value_of(const Dual<N>& x) {
  return x.value;
}
[[nodiscard]] SPRINGNET_INLINE constexpr double value_of(double x) { return x; }

namespace detail {
// f(x) with f'(x) = slope.
template <std::size_t N>
SPRINGNET_INLINE Dual<N> chain(const Dual<N>& x, double value, double slope) {
  Dual<N> result(value);
  for (std::size_t i = 0; i < N; ++i) result.derivatives[i] = slope * x.derivatives[i];
  return result;
}
// The same if the slope may be infinite: constants stay constants.
template <std::size_t N>
SPRINGNET_INLINE Dual<N> chain_steep(const Dual<N>& x, double value, double slope) {
  Dual<N> result(value);
  for (std::size_t i = 0; i < N; ++i) {
    result.derivatives[i] = x.derivatives[i] == 0.0 ? 0.0 : slope * x.derivatives[i];
  }
  return result;
}
}  // namespace detail

// For formulas with numbers that are double in any case; abs, floor and ceil are exact, so that any library's do. min
// and max of two numbers of different types.
using std::abs, std::floor, std::ceil, std::min, std::max, std::clamp;
[[nodiscard]] SPRINGNET_INLINE constexpr double min(double a, double b) { return b < a ? b : a; }
[[nodiscard]] SPRINGNET_INLINE constexpr double max(double a, double b) { return a < b ? b : a; }
// As std::clamp: x where it is nan.
[[nodiscard]] SPRINGNET_INLINE constexpr double clamp(double x, double low, double high) {
  return x < low ? low : (high < x ? high : x);
}

template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> abs(const Dual<N>& x) {
  const double slope = x.value > 0.0 ? 1.0 : (x.value < 0.0 ? -1.0 : 0.0);
  return detail::chain(x, std::abs(x.value), slope);
}
// As std::min and std::max: the first argument if both are equal or either is NaN.
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> min(const Dual<N>& a, const Dual<N>& b) {
  return b.value < a.value ? b : a;
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> min(const Dual<N>& a, double b) {
  return min(a, Dual<N>(b));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> min(double a, const Dual<N>& b) {
  return min(Dual<N>(a), b);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> max(const Dual<N>& a, const Dual<N>& b) {
  return a.value < b.value ? b : a;
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> max(const Dual<N>& a, double b) {
  return max(a, Dual<N>(b));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> max(double a, const Dual<N>& b) {
  return max(Dual<N>(a), b);
}

template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> clamp(const Dual<N>& x, const Dual<N>& low, const Dual<N>& high) {
  return x.value < low.value ? low : (high.value < x.value ? high : x);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> clamp(const Dual<N>& x, double low, double high) {
  return clamp(x, Dual<N>(low), Dual<N>(high));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> clamp(const Dual<N>& x, const Dual<N>& low, double high) {
  return clamp(x, low, Dual<N>(high));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N> clamp(const Dual<N>& x, double low, const Dual<N>& high) {
  return clamp(x, Dual<N>(low), high);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> floor(const Dual<N>& x) {
  return Dual<N>(std::floor(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> ceil(const Dual<N>& x) {
  return Dual<N>(std::ceil(x.value));
}

template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> sqrt(const Dual<N>& x) {
  const double root = sdk::sqrt(x.value);
  return detail::chain_steep(x, root, 0.5 / root);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> cbrt(const Dual<N>& x) {
  const double root = sdk::cbrt(x.value);
  return detail::chain_steep(x, root, 1.0 / (3.0 * root * root));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> hypot(const Dual<N>& x, const Dual<N>& y) {
  Dual<N> result(sdk::hypot(x.value, y.value));
  if (result.value != 0.0) {
    for (std::size_t i = 0; i < N; ++i) {
      result.derivatives[i] = (x.value / result.value) * x.derivatives[i] + (y.value / result.value) * y.derivatives[i];
    }
  }
  return result;
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> hypot(const Dual<N>& x, double y) {
  return hypot(x, Dual<N>(y));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> hypot(double x, const Dual<N>& y) {
  return hypot(Dual<N>(x), y);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> exp(const Dual<N>& x) {
  const double value = sdk::exp(x.value);
  return detail::chain(x, value, value);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> expm1(const Dual<N>& x) {
  return detail::chain(x, sdk::expm1(x.value), sdk::exp(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> log(const Dual<N>& x) {
  return detail::chain_steep(x, sdk::log(x.value), 1.0 / x.value);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> log1p(const Dual<N>& x) {
  return detail::chain_steep(x, sdk::log1p(x.value), 1.0 / (1.0 + x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> log10(const Dual<N>& x) {
  return detail::chain_steep(x, sdk::log10(x.value), 0x1.bcb7b1526e50ep-2 / x.value);  // log10 e
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> pow(const Dual<N>& x, double exponent) {
  const double slope = exponent == 0.0 ? 0.0 : exponent * sdk::pow(x.value, exponent - 1.0);
  return detail::chain_steep(x, sdk::pow(x.value, exponent), slope);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> pow(const Dual<N>& x, const Dual<N>& exponent) {
  Dual<N> result = pow(x, exponent.value);
  for (std::size_t i = 0; i < N; ++i) {
    // d/dy x^y = x^y log x, which tends to 0 with x^y.
    if (exponent.derivatives[i] != 0.0 && result.value != 0.0) {
      result.derivatives[i] += result.value * sdk::log(x.value) * exponent.derivatives[i];
    }
  }
  return result;
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> pow(double x, const Dual<N>& exponent) {
  return pow(Dual<N>(x), exponent);
}
// As pow, for normal x > 0; see sdk/math/power.hpp.
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> quick_pow(const Dual<N>& x, const Dual<N>& exponent) {
  Dual<N> result(sdk::quick_pow(x.value, exponent.value));
  for (std::size_t i = 0; i < N; ++i) {
    result.derivatives[i] =
        result.value * (exponent.value * (x.derivatives[i] / x.value) + sdk::log(x.value) * exponent.derivatives[i]);
  }
  return result;
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> quick_pow(const Dual<N>& x, double exponent) {
  return quick_pow(x, Dual<N>(exponent));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> quick_pow(double x, const Dual<N>& exponent) {
  return quick_pow(Dual<N>(x), exponent);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> sin(const Dual<N>& x) {
  return detail::chain(x, sdk::sin(x.value), sdk::cos(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> cos(const Dual<N>& x) {
  return detail::chain(x, sdk::cos(x.value), -sdk::sin(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> tan(const Dual<N>& x) {
  const double value = sdk::tan(x.value);
  return detail::chain(x, value, 1.0 + value * value);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> asin(const Dual<N>& x) {
  return detail::chain_steep(x, sdk::asin(x.value), 1.0 / sdk::sqrt((1.0 - x.value) * (1.0 + x.value)));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> acos(const Dual<N>& x) {
  return detail::chain_steep(x, sdk::acos(x.value), -1.0 / sdk::sqrt((1.0 - x.value) * (1.0 + x.value)));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> atan(const Dual<N>& x) {
  return detail::chain(x, sdk::atan(x.value), 1.0 / (1.0 + x.value * x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  Dual<N> result(sdk::atan2(y.value, x.value));
  const double square = x.value * x.value + y.value * y.value;
  if (square != 0.0) {
    for (std::size_t i = 0; i < N; ++i) {
      result.derivatives[i] = (x.value * y.derivatives[i] - y.value * x.derivatives[i]) / square;
    }
  }
  return result;
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> atan2(const Dual<N>& y, double x) {
  return atan2(y, Dual<N>(x));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> atan2(double y, const Dual<N>& x) {
  return atan2(Dual<N>(y), x);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> sinh(const Dual<N>& x) {
  return detail::chain(x, sdk::sinh(x.value), sdk::cosh(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> cosh(const Dual<N>& x) {
  return detail::chain(x, sdk::cosh(x.value), sdk::sinh(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> tanh(const Dual<N>& x) {
  const double value = sdk::tanh(x.value);
  return detail::chain(x, value, (1.0 - value) * (1.0 + value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> erf(const Dual<N>& x) {
  constexpr double two_over_root_pi = 0x1.20dd750429b6dp+0;
  return detail::chain(x, sdk::erf(x.value), two_over_root_pi * sdk::exp(-x.value * x.value));
}

}  // namespace springnet::sdk
