// Complex numbers as the number type of laws' formulas: Im f(x + i h) / h is f'(x) without a difference, to rounding,
// for any tiny h. (W. Squire, G. Trapp, SIAM Rev. 40 (1998) 110-112.) Comparisons are those of the real parts.
//
// Before the headers of laws: their formulas call elementary functions by names that these have to be known under.
#pragma once

#include <compare>
#include <complex>

#include <springnet/sdk/dual.hpp>

namespace springnet::sdk {

struct Complex {
  std::complex<double> z{};

  Complex() = default;
  Complex(double x) : z(x) {}  // NOLINT(google-explicit-constructor)
  explicit Complex(const std::complex<double>& value) : z(value) {}

  Complex& operator+=(const Complex& b) { return *this = *this + b; }
  Complex& operator-=(const Complex& b) { return *this = *this - b; }
  Complex& operator*=(const Complex& b) { return *this = *this * b; }
  Complex& operator/=(const Complex& b) { return *this = *this / b; }
  friend Complex operator+(const Complex& a) { return a; }
  friend Complex operator-(const Complex& a) { return Complex(-a.z); }
  friend Complex operator+(const Complex& a, const Complex& b) { return Complex(a.z + b.z); }
  friend Complex operator-(const Complex& a, const Complex& b) { return Complex(a.z - b.z); }
  friend Complex operator*(const Complex& a, const Complex& b) { return Complex(a.z * b.z); }
  friend Complex operator/(const Complex& a, const Complex& b) { return Complex(a.z / b.z); }
  friend bool operator==(const Complex& a, const Complex& b) { return a.z.real() == b.z.real(); }
  friend auto operator<=>(const Complex& a, const Complex& b) { return a.z.real() <=> b.z.real(); }
};

inline Complex abs(const Complex& x) { return x < 0.0 ? -x : x; }
inline Complex min(const Complex& a, const Complex& b) { return b < a ? b : a; }
inline Complex max(const Complex& a, const Complex& b) { return a < b ? b : a; }
inline Complex sqrt(const Complex& x) { return Complex(std::sqrt(x.z)); }
inline Complex exp(const Complex& x) { return Complex(std::exp(x.z)); }
// e^x - 1 = 2 e^(x/2) sinh(x/2)
inline Complex expm1(const Complex& x) { return Complex(2.0 * std::exp(0.5 * x.z) * std::sinh(0.5 * x.z)); }
inline Complex quick_pow(const Complex& x, const Complex& y) { return Complex(std::exp(y.z * std::log(x.z))); }

}  // namespace springnet::sdk
