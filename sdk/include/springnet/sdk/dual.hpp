// Forward-mode dual numbers: a value together with its derivatives with respect to N variables. Laws are templates over
// their number type; with Dual in place of double the same formula gives exact derivatives.
//
// Comparisons use the value only. The value of every operation is computed exactly as for double. Conventions where a
// derivative does not exist: abs takes 0, min and max that of the argument chosen; a function with an infinite slope
// (sqrt at 0, …) keeps a derivative of 0, so that constants stay constants.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstddef>

#if defined(__FAST_MATH__)
#error "springnet laws must give the same bits for every instruction set and tile size: compile without -ffast-math"
#endif

#if defined(__GNUC__) || defined(__clang__)
#define SPRINGNET_INLINE __attribute__((always_inline)) inline
#else
#define SPRINGNET_INLINE inline
#endif

namespace springnet::sdk {

template <std::size_t N>
struct Dual {
  double value = 0.0;
  std::array<double, N> derivatives{};

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

// For laws evaluated with double; the overloads below are for duals.
using std::abs, std::min, std::max, std::sqrt, std::cbrt, std::hypot, std::exp, std::expm1, std::log, std::log1p,
    std::pow, std::sin, std::cos, std::tan, std::asin, std::acos, std::atan, std::atan2, std::sinh, std::cosh,
    std::tanh;

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
[[nodiscard]] SPRINGNET_INLINE Dual<N> sqrt(const Dual<N>& x) {
  const double root = std::sqrt(x.value);
  return detail::chain_steep(x, root, 0.5 / root);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> cbrt(const Dual<N>& x) {
  const double root = std::cbrt(x.value);
  return detail::chain_steep(x, root, 1.0 / (3.0 * root * root));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> hypot(const Dual<N>& x, const Dual<N>& y) {
  Dual<N> result(std::hypot(x.value, y.value));
  if (result.value != 0.0) {
    for (std::size_t i = 0; i < N; ++i) {
      result.derivatives[i] = (x.value / result.value) * x.derivatives[i] + (y.value / result.value) * y.derivatives[i];
    }
  }
  return result;
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> exp(const Dual<N>& x) {
  const double value = std::exp(x.value);
  return detail::chain(x, value, value);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> expm1(const Dual<N>& x) {
  return detail::chain(x, std::expm1(x.value), std::exp(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> log(const Dual<N>& x) {
  return detail::chain_steep(x, std::log(x.value), 1.0 / x.value);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> log1p(const Dual<N>& x) {
  return detail::chain_steep(x, std::log1p(x.value), 1.0 / (1.0 + x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> pow(const Dual<N>& x, double exponent) {
  const double slope = exponent == 0.0 ? 0.0 : exponent * std::pow(x.value, exponent - 1.0);
  return detail::chain_steep(x, std::pow(x.value, exponent), slope);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> pow(const Dual<N>& x, const Dual<N>& exponent) {
  Dual<N> result = pow(x, exponent.value);
  for (std::size_t i = 0; i < N; ++i) {
    // d/dy x^y = x^y log x, which tends to 0 with x^y.
    if (exponent.derivatives[i] != 0.0 && result.value != 0.0) {
      result.derivatives[i] += result.value * std::log(x.value) * exponent.derivatives[i];
    }
  }
  return result;
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> pow(double x, const Dual<N>& exponent) {
  return pow(Dual<N>(x), exponent);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> sin(const Dual<N>& x) {
  return detail::chain(x, std::sin(x.value), std::cos(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> cos(const Dual<N>& x) {
  return detail::chain(x, std::cos(x.value), -std::sin(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> tan(const Dual<N>& x) {
  const double value = std::tan(x.value);
  return detail::chain(x, value, 1.0 + value * value);
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> asin(const Dual<N>& x) {
  return detail::chain_steep(x, std::asin(x.value), 1.0 / std::sqrt((1.0 - x.value) * (1.0 + x.value)));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> acos(const Dual<N>& x) {
  return detail::chain_steep(x, std::acos(x.value), -1.0 / std::sqrt((1.0 - x.value) * (1.0 + x.value)));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> atan(const Dual<N>& x) {
  return detail::chain(x, std::atan(x.value), 1.0 / (1.0 + x.value * x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  Dual<N> result(std::atan2(y.value, x.value));
  const double square = x.value * x.value + y.value * y.value;
  if (square != 0.0) {
    for (std::size_t i = 0; i < N; ++i) {
      result.derivatives[i] = (x.value * y.derivatives[i] - y.value * x.derivatives[i]) / square;
    }
  }
  return result;
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> sinh(const Dual<N>& x) {
  return detail::chain(x, std::sinh(x.value), std::cosh(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> cosh(const Dual<N>& x) {
  return detail::chain(x, std::cosh(x.value), std::sinh(x.value));
}
template <std::size_t N>
[[nodiscard]] SPRINGNET_INLINE Dual<N> tanh(const Dual<N>& x) {
  const double value = std::tanh(x.value);
  return detail::chain(x, value, (1.0 - value) * (1.0 + value));
}

}  // namespace springnet::sdk
