// Polynomials of dual numbers, with fewer operations than step by step: the slope comes with the value, and each
// derivative of x is multiplied by it once.
#pragma once

#include <cstddef>
#include <type_traits>

#include <springnet/sdk/dual.hpp>

namespace springnet::sdk {
namespace detail {

// c0 + x (c1 + x (…)). Coefficients are a list of arguments and no array, in which the compiler would not see which
// derivatives are 0 (is_known_zero).
template <class T>
[[nodiscard]] SPRINGNET_INLINE T horner(const T&, const T& last) {
  return last;
}
template <class T, class... More>
[[nodiscard]] SPRINGNET_INLINE T horner(const T& x, const T& first, const T& second, const More&... more) {
  return sum(scaled(horner(x, second, more...), x), first);
}
// Its derivative by x: the sum's of c0 + x f(x) is f(x) + x f'(x).
template <class T>
[[nodiscard]] SPRINGNET_INLINE T slope_of_horner(const T&, const T&) {
  return T(0.0);
}
template <class T>
[[nodiscard]] SPRINGNET_INLINE T slope_of_horner(const T&, const T&, const T& last) {
  return last;
}
template <class T, class... More>
[[nodiscard]] SPRINGNET_INLINE T slope_of_horner(const T& x, const T&, const T& second, const T& third,
                                                 const More&... more) {
  return slope_of_horner(x, second, third, more...) * x + horner(x, second, third, more...);
}

template <class Number, class... Coefficients>
[[nodiscard]] SPRINGNET_INLINE Number polynomial_of(const Number& x, const Coefficients&... c) {
  if constexpr (!requires { x.derivatives; }) {
    return horner(x, c...);
  } else {
    Number result(horner(x.value, c.value...));
    const auto slope = slope_of_horner(x.value, c.value...);
    unrolled<Number().derivatives.size()>([&](auto i) {
      result.derivatives[i] = sum(scaled(x.derivatives[i], slope), horner(x.value, c.derivatives[i]...));
    });
    return result;
  }
}

}  // namespace detail

// c0 + c1 x + c2 x^2 + … of numbers and dual numbers; the value has the bits of c0 + x (c1 + x (c2 + …)).
template <class X, class... Coefficients>
[[nodiscard]] SPRINGNET_INLINE auto polynomial(const X& x, const Coefficients&... coefficients) {
  static_assert(sizeof...(Coefficients) > 0, "a polynomial has at least one coefficient");
  using Number = std::common_type_t<X, Coefficients...>;
  return detail::polynomial_of<Number>(Number(x), Number(coefficients)...);
}

}  // namespace springnet::sdk
