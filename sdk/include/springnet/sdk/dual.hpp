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
#include <type_traits>
#include <utility>

#include <springnet/sdk/math.hpp>

namespace springnet::sdk {

namespace detail {
// Calls what(std::integral_constant<std::size_t, i>) for i from 0 to before count. Loops would be unrolled late, after
// the compiler has decided to keep arrays of numbers in memory, and a loop over elements with loops inside is not
// vectorised.
template <std::size_t count, class What>
SPRINGNET_INLINE constexpr void unrolled(const What& what) {
  [&]<std::size_t... i>(std::index_sequence<i...>) { (what(std::integral_constant<std::size_t, i>{}), ...); }
  (std::make_index_sequence<count>{});
}

// Derivatives that the compiler knows to be 0, of constants, take no arithmetic. It may not leave that out by itself: 0
// times infinity is not 0, and -0 + 0 is not -0.
template <class T>
SPRINGNET_INLINE constexpr bool is_known_zero(const T& x) {
  if constexpr (std::is_same_v<T, double>)
    return __builtin_constant_p(x) && x == 0.0;
  else
    return false;
}
template <class T, class Factor>
SPRINGNET_INLINE constexpr T scaled(const T& derivative, const Factor& factor) {
  return is_known_zero(derivative) ? T(0.0) : factor * derivative;
}
template <class T, class Divisor>
SPRINGNET_INLINE constexpr T quotient(const T& derivative, const Divisor& divisor) {
  return is_known_zero(derivative) ? T(0.0) : derivative / divisor;
}
template <class T>
SPRINGNET_INLINE constexpr T sum(const T& a, const T& b) {
  return is_known_zero(a) ? b : (is_known_zero(b) ? a : a + b);
}
template <class T>
SPRINGNET_INLINE constexpr T difference(const T& a, const T& b) {
  return is_known_zero(a) ? -b : (is_known_zero(b) ? a : a - b);
}

// An empty `mutable` member. Without it GCC (12) takes `const auto x = …;` for read-only memory, keeps it there instead
// of in registers, and does not vectorise the loop around the formula.
template <std::size_t N, class T>
struct NotReadOnly {};

// The derivatives of Dual<0>: std::array<T, 0> would take room.
template <class T>
struct NoDerivatives {
  [[nodiscard]] static constexpr std::size_t size() { return 0; }
  [[nodiscard]] constexpr T* begin() { return nullptr; }
  [[nodiscard]] constexpr T* end() { return nullptr; }
  [[nodiscard]] constexpr const T* begin() const { return nullptr; }
  [[nodiscard]] constexpr const T* end() const { return nullptr; }
  // There is none.
  [[nodiscard]] constexpr T& operator[](std::size_t) { return *begin(); }
  [[nodiscard]] constexpr const T& operator[](std::size_t) const { return *begin(); }
};
template <std::size_t N, class T>
struct DerivativesOf {
  using Type = std::array<T, N>;
};
template <class T>
struct DerivativesOf<0, T> {
  using Type = NoDerivatives<T>;
};
}  // namespace detail

// Dual<0> is a value without derivatives, of the size of a double: laws and neurons get it for what they compute
// itself. It is not double, so that an unqualified exp(x) in a formula is the one here and never that of the C library.
// T: type of the value and the derivatives; with Dual in place of double, derivatives have derivatives in turn.
template <std::size_t N, class T = double>
struct Dual {
  T value = 0.0;
  [[no_unique_address]] typename detail::DerivativesOf<N, T>::Type derivatives{};
  [[no_unique_address]] mutable detail::NotReadOnly<N, T> not_read_only{};

  constexpr Dual() = default;
  // A constant; implicit, so that laws may mix numbers and duals.
  SPRINGNET_INLINE constexpr Dual(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor)
  SPRINGNET_INLINE constexpr Dual(const T& constant)                     // NOLINT(google-explicit-constructor)
      requires(!std::is_same_v<T, double>)
      : value(constant) {}
  // The variable with number `index`.
  [[nodiscard]] static constexpr Dual variable(T value, std::size_t index) {
    Dual result(value);
    result.derivatives[index] = 1.0;
    return result;
  }

  SPRINGNET_INLINE constexpr Dual& operator+=(const Dual& b) { return *this = plus(*this, b, Indices()); }
  SPRINGNET_INLINE constexpr Dual& operator-=(const Dual& b) { return *this = minus(*this, b, Indices()); }
  SPRINGNET_INLINE constexpr Dual& operator*=(const Dual& b) { return *this = times(*this, b, Indices()); }
  SPRINGNET_INLINE constexpr Dual& operator/=(const Dual& b) { return *this = over(*this, b, Indices()); }
  SPRINGNET_INLINE constexpr Dual& operator+=(double b) {
    value += b;
    return *this;
  }
  SPRINGNET_INLINE constexpr Dual& operator-=(double b) {
    value -= b;
    return *this;
  }
  SPRINGNET_INLINE constexpr Dual& operator*=(double b) { return *this = times(*this, b, Indices()); }
  SPRINGNET_INLINE constexpr Dual& operator/=(double b) { return *this = over(*this, b, Indices()); }

  friend SPRINGNET_INLINE constexpr Dual operator+(const Dual& a) { return a; }
  friend SPRINGNET_INLINE constexpr Dual operator-(const Dual& a) { return negative(a, Indices()); }
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

 private:
  using Indices = std::make_index_sequence<N>;
  struct All {};
  template <class... Derivatives>
  SPRINGNET_INLINE constexpr Dual(All, const T& own, const Derivatives&... own_derivatives)
      : value(own), derivatives{own_derivatives...} {}
  // Results with all derivatives at once: loops would be unrolled late, after the compiler has decided to keep arrays
  // in memory.
  template <std::size_t... i>
  SPRINGNET_INLINE static constexpr Dual plus(const Dual& a, const Dual& b, std::index_sequence<i...>) {
    return Dual(All(), a.value + b.value, detail::sum(a.derivatives[i], b.derivatives[i])...);
  }
  template <std::size_t... i>
  SPRINGNET_INLINE static constexpr Dual minus(const Dual& a, const Dual& b, std::index_sequence<i...>) {
    return Dual(All(), a.value - b.value, detail::difference(a.derivatives[i], b.derivatives[i])...);
  }
  template <std::size_t... i>
  SPRINGNET_INLINE static constexpr Dual times(const Dual& a, const Dual& b, std::index_sequence<i...>) {
    return Dual(All(), a.value * b.value,
                detail::sum(detail::scaled(a.derivatives[i], b.value), detail::scaled(b.derivatives[i], a.value))...);
  }
  template <std::size_t... i>
  SPRINGNET_INLINE static constexpr Dual over(const Dual& a, const Dual& b, std::index_sequence<i...>) {
    const T ratio = a.value / b.value;
    return Dual(
        All(), ratio,
        detail::quotient(detail::difference(a.derivatives[i], detail::scaled(b.derivatives[i], ratio)), b.value)...);
  }
  template <std::size_t... i>
  SPRINGNET_INLINE static constexpr Dual times(const Dual& a, double b, std::index_sequence<i...>) {
    return Dual(All(), a.value * b, detail::scaled(a.derivatives[i], b)...);
  }
  template <std::size_t... i>
  SPRINGNET_INLINE static constexpr Dual over(const Dual& a, double b, std::index_sequence<i...>) {
    return Dual(All(), a.value / b, detail::quotient(a.derivatives[i], b)...);
  }
  template <std::size_t... i>
  SPRINGNET_INLINE static constexpr Dual negative(const Dual& a, std::index_sequence<i...>) {
    return Dual(All(), -a.value, (-a.derivatives[i])...);
  }
};

// The value without derivatives; also for double.
[[nodiscard]] SPRINGNET_INLINE constexpr double value_of(double x) { return x; }
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr double value_of(const Dual<N, T>& x) {
  return value_of(x.value);
}

namespace detail {
// f(x) with f'(x) = slope.
template <std::size_t N, class T>
SPRINGNET_INLINE Dual<N, T> chain(const Dual<N, T>& x, const T& value, const T& slope) {
  Dual<N, T> result(value);
  detail::unrolled<N>([&](auto i) { result.derivatives[i] = scaled(x.derivatives[i], slope); });
  return result;
}
// Whether a number is 0 with all of its own derivatives.
[[nodiscard]] SPRINGNET_INLINE constexpr bool is_nothing(double x) { return x == 0.0; }
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr bool is_nothing(const Dual<N, T>& x) {
  bool result = is_nothing(x.value);
  for (const T& d : x.derivatives) result = result && is_nothing(d);
  return result;
}
// The same if the slope may be infinite: constants stay constants.
template <std::size_t N, class T>
SPRINGNET_INLINE Dual<N, T> chain_steep(const Dual<N, T>& x, const T& value, const T& slope) {
  Dual<N, T> result(value);
  detail::unrolled<N>(
      [&](auto i) { result.derivatives[i] = is_nothing(x.derivatives[i]) ? T(0.0) : slope * x.derivatives[i]; });
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

template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> abs(const Dual<N, T>& x) {
  const T slope = x.value > 0.0 ? T(1.0) : (x.value < 0.0 ? T(-1.0) : T(0.0));
  return detail::chain(x, abs(x.value), slope);
}
// As std::min and std::max: the first argument if both are equal or either is NaN.
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> min(const Dual<N, T>& a, const Dual<N, T>& b) {
  return b.value < a.value ? b : a;
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> min(const Dual<N, T>& a, double b) {
  return min(a, Dual<N, T>(b));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> min(double a, const Dual<N, T>& b) {
  return min(Dual<N, T>(a), b);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> max(const Dual<N, T>& a, const Dual<N, T>& b) {
  return a.value < b.value ? b : a;
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> max(const Dual<N, T>& a, double b) {
  return max(a, Dual<N, T>(b));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> max(double a, const Dual<N, T>& b) {
  return max(Dual<N, T>(a), b);
}

template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> clamp(const Dual<N, T>& x, const Dual<N, T>& low,
                                                          const Dual<N, T>& high) {
  return x.value < low.value ? low : (high.value < x.value ? high : x);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> clamp(const Dual<N, T>& x, double low, double high) {
  return clamp(x, Dual<N, T>(low), Dual<N, T>(high));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> clamp(const Dual<N, T>& x, const Dual<N, T>& low, double high) {
  return clamp(x, low, Dual<N, T>(high));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE constexpr Dual<N, T> clamp(const Dual<N, T>& x, double low, const Dual<N, T>& high) {
  return clamp(x, Dual<N, T>(low), high);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> floor(const Dual<N, T>& x) {
  return Dual<N, T>(floor(value_of(x)));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> ceil(const Dual<N, T>& x) {
  return Dual<N, T>(ceil(value_of(x)));
}

template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> sqrt(const Dual<N, T>& x) {
  const T root = sqrt(x.value);
  return detail::chain_steep(x, root, 0.5 / root);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> cbrt(const Dual<N, T>& x) {
  const T root = cbrt(x.value);
  return detail::chain_steep(x, root, 1.0 / (3.0 * root * root));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> hypot(const Dual<N, T>& x, const Dual<N, T>& y) {
  Dual<N, T> result(hypot(x.value, y.value));
  if (result.value != 0.0) {
    detail::unrolled<N>([&](auto i) {
      result.derivatives[i] = (x.value / result.value) * x.derivatives[i] + (y.value / result.value) * y.derivatives[i];
    });
  }
  return result;
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> hypot(const Dual<N, T>& x, double y) {
  return hypot(x, Dual<N, T>(y));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> hypot(double x, const Dual<N, T>& y) {
  return hypot(Dual<N, T>(x), y);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> exp(const Dual<N, T>& x) {
  const T value = exp(x.value);
  return detail::chain(x, value, value);
}
namespace detail {
template <class Real>
struct ExponentialsOf {
  Real less_1, value;  // e^x - 1 and e^x, its slope
};
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE ExponentialsOf<Dual<N, T>> expm1_and_exp(const Dual<N, T>& x) {
  const auto of_value = expm1_and_exp(x.value);
  return {chain(x, of_value.less_1, of_value.value), chain(x, of_value.value, of_value.value)};
}
}  // namespace detail
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> expm1(const Dual<N, T>& x) {
  return detail::expm1_and_exp(x).less_1;
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> log(const Dual<N, T>& x) {
  return detail::chain_steep(x, log(x.value), 1.0 / x.value);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> log1p(const Dual<N, T>& x) {
  return detail::chain_steep(x, log1p(x.value), 1.0 / (1.0 + x.value));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> log10(const Dual<N, T>& x) {
  return detail::chain_steep(x, log10(x.value), 0x1.bcb7b1526e50ep-2 / x.value);  // log10 e
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> pow(const Dual<N, T>& x, double exponent) {
  const T slope = exponent == 0.0 ? T(0.0) : exponent * pow(x.value, exponent - 1.0);
  return detail::chain_steep(x, pow(x.value, exponent), slope);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> pow(const Dual<N, T>& x, const Dual<N, T>& exponent) {
  const T by_x = detail::is_nothing(exponent.value) ? T(0.0) : exponent.value * pow(x.value, exponent.value - 1.0);
  Dual<N, T> result = detail::chain_steep(x, pow(x.value, exponent.value), by_x);
  detail::unrolled<N>([&](auto i) {
    // d/dy x^y = x^y log x, which tends to 0 with x^y.
    if (!detail::is_nothing(exponent.derivatives[i]) && result.value != 0.0) {
      result.derivatives[i] += result.value * log(x.value) * exponent.derivatives[i];
    }
  });
  return result;
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> pow(double x, const Dual<N, T>& exponent) {
  return pow(Dual<N, T>(x), exponent);
}
// As pow, for normal x > 0; see sdk/math/power.hpp.
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> quick_pow(const Dual<N, T>& x, const Dual<N, T>& exponent) {
  Dual<N, T> result(quick_pow(x.value, exponent.value));
  detail::unrolled<N>([&](auto i) {
    result.derivatives[i] =
        result.value * (exponent.value * (x.derivatives[i] / x.value) + log(x.value) * exponent.derivatives[i]);
  });
  return result;
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> quick_pow(const Dual<N, T>& x, double exponent) {
  return quick_pow(x, Dual<N, T>(exponent));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> quick_pow(double x, const Dual<N, T>& exponent) {
  return quick_pow(Dual<N, T>(x), exponent);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> sin(const Dual<N, T>& x) {
  return detail::chain(x, sin(x.value), cos(x.value));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> cos(const Dual<N, T>& x) {
  return detail::chain(x, cos(x.value), -sin(x.value));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> tan(const Dual<N, T>& x) {
  const T value = tan(x.value);
  return detail::chain(x, value, 1.0 + value * value);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> asin(const Dual<N, T>& x) {
  return detail::chain_steep(x, asin(x.value), 1.0 / sqrt((1.0 - x.value) * (1.0 + x.value)));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> acos(const Dual<N, T>& x) {
  return detail::chain_steep(x, acos(x.value), -1.0 / sqrt((1.0 - x.value) * (1.0 + x.value)));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> atan(const Dual<N, T>& x) {
  return detail::chain(x, atan(x.value), 1.0 / (1.0 + x.value * x.value));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> atan2(const Dual<N, T>& y, const Dual<N, T>& x) {
  Dual<N, T> result(atan2(y.value, x.value));
  const T square = x.value * x.value + y.value * y.value;
  if (square != 0.0) {
    detail::unrolled<N>(
        [&](auto i) { result.derivatives[i] = (x.value * y.derivatives[i] - y.value * x.derivatives[i]) / square; });
  }
  return result;
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> atan2(const Dual<N, T>& y, double x) {
  return atan2(y, Dual<N, T>(x));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> atan2(double y, const Dual<N, T>& x) {
  return atan2(Dual<N, T>(y), x);
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> sinh(const Dual<N, T>& x) {
  return detail::chain(x, sinh(x.value), cosh(x.value));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> cosh(const Dual<N, T>& x) {
  return detail::chain(x, cosh(x.value), sinh(x.value));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> tanh(const Dual<N, T>& x) {
  const T value = tanh(x.value);
  return detail::chain(x, value, (1.0 - value) * (1.0 + value));
}
template <std::size_t N, class T>
[[nodiscard]] SPRINGNET_INLINE Dual<N, T> erf(const Dual<N, T>& x) {
  constexpr double two_over_root_pi = 0x1.20dd750429b6dp+0;
  return detail::chain(x, erf(x.value), two_over_root_pi * exp(-x.value * x.value));
}

static_assert(sizeof(Dual<0>) == sizeof(double) && sizeof(Dual<3>) == 4 * sizeof(double));

}  // namespace springnet::sdk
