// Numbers and vectors with their derivatives by some variables, carried along through a formula.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace springnet::learning {

template <int Count>
struct VariedNumber {
  double value = 0.0;
  Eigen::Matrix<double, 1, Count> change = Eigen::Matrix<double, 1, Count>::Zero();

  static VariedNumber constant(double value) { return {value, Eigen::Matrix<double, 1, Count>::Zero()}; }
};

template <int Count>
struct VariedVector {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, Count> change = Eigen::Matrix<double, 3, Count>::Zero();

  // A variable: of those from `first` on.
  static VariedVector variable(const Eigen::Vector3d& value, Eigen::Index first) {
    VariedVector result;
    result.value = value;
    result.change.template middleCols<3>(first).setIdentity();
    return result;
  }
};

template <int N>
[[nodiscard]] VariedNumber<N> operator-(const VariedNumber<N>& a) {
  return {-a.value, -a.change};
}
template <int N>
[[nodiscard]] VariedNumber<N> operator+(const VariedNumber<N>& a, const VariedNumber<N>& b) {
  return {a.value + b.value, a.change + b.change};
}
template <int N>
[[nodiscard]] VariedNumber<N> operator-(const VariedNumber<N>& a, const VariedNumber<N>& b) {
  return {a.value - b.value, a.change - b.change};
}
template <int N>
[[nodiscard]] VariedNumber<N> operator*(double factor, const VariedNumber<N>& a) {
  return {factor * a.value, factor * a.change};
}
template <int N>
[[nodiscard]] VariedNumber<N> operator*(const VariedNumber<N>& a, const VariedNumber<N>& b) {
  return {a.value * b.value, a.value * b.change + b.value * a.change};
}
template <int N>
[[nodiscard]] VariedNumber<N> operator/(const VariedNumber<N>& a, const VariedNumber<N>& b) {
  const double quotient = a.value / b.value;
  return {quotient, (a.change - quotient * b.change) / b.value};
}
template <int N>
[[nodiscard]] VariedNumber<N> sqrt(const VariedNumber<N>& a) {
  const double root = std::sqrt(a.value);
  return {root, a.change / (2.0 * root)};
}

template <int N>
[[nodiscard]] VariedVector<N> operator+(const VariedVector<N>& a, const VariedVector<N>& b) {
  return {a.value + b.value, a.change + b.change};
}
template <int N>
[[nodiscard]] VariedVector<N> operator-(const VariedVector<N>& a, const VariedVector<N>& b) {
  return {a.value - b.value, a.change - b.change};
}
template <int N>
[[nodiscard]] VariedVector<N> operator*(double factor, const VariedVector<N>& a) {
  return {factor * a.value, factor * a.change};
}
template <int N>
[[nodiscard]] VariedVector<N> operator*(const VariedNumber<N>& factor, const VariedVector<N>& a) {
  return {factor.value * a.value, factor.value * a.change + a.value * factor.change};
}
template <int N>
[[nodiscard]] VariedVector<N> operator*(const Eigen::Matrix3d& matrix, const VariedVector<N>& a) {
  return {matrix * a.value, matrix * a.change};
}
template <int N>
[[nodiscard]] VariedNumber<N> dot(const VariedVector<N>& a, const VariedVector<N>& b) {
  return {a.value.dot(b.value), a.value.transpose() * b.change + b.value.transpose() * a.change};
}
template <int N>
[[nodiscard]] VariedVector<N> cross(const VariedVector<N>& a, const VariedVector<N>& b) {
  VariedVector<N> result;
  result.value = a.value.cross(b.value);
  for (Eigen::Index k = 0; k < a.change.cols(); ++k) {
    const Eigen::Vector3d of_a = a.change.col(k), of_b = b.change.col(k);
    result.change.col(k) = of_a.cross(b.value) + a.value.cross(of_b);
  }
  return result;
}
template <int N>
[[nodiscard]] VariedNumber<N> length(const VariedVector<N>& a) {
  return sqrt(dot(a, a));
}

}  // namespace springnet::learning
