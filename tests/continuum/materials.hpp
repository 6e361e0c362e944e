// Energies and stresses by the deformation gradient F, written without the laws' formulas.
#pragma once

#include <cmath>

#include <Eigen/Dense>

#include "meshes.hpp"

namespace springnet::testing {

inline Matrix3 cofactors(const Matrix3& f) {
  Matrix3 result;
  for (Eigen::Index c = 0; c < 3; ++c) result.col(c) = f.col((c + 1) % 3).cross(f.col((c + 2) % 3));
  return result;
}

// `solid`: E in Pa.
struct NeoHookean {
  double modulus, nu;

  [[nodiscard]] double mu() const { return modulus / (2.0 * (1.0 + nu)); }
  [[nodiscard]] double kappa() const { return mu() / (1.0 - 2.0 * nu); }
  // Per volume at rest, J/m^3.
  [[nodiscard]] double energy(const Matrix3& f) const {
    const double j = f.determinant();
    return 0.5 * mu() * (f.squaredNorm() - 3.0) - mu() * (j - 1.0) + 0.5 * kappa() * (j - 1.0) * (j - 1.0);
  }
  // First Piola-Kirchhoff stress, Pa.
  [[nodiscard]] Matrix3 stress(const Matrix3& f) const {
    return mu() * f + (kappa() * (f.determinant() - 1.0) - mu()) * cofactors(f);
  }
};

// What `fibre_solid` adds, along a unit vector.
struct Fibres {
  double modulus, stiffening;
  bool push;
  Vector3 along;

  [[nodiscard]] double strain(const Matrix3& f) const {
    const double x = (f * along).squaredNorm() - 1.0;
    return push ? x : std::max(x, 0.0);
  }
  [[nodiscard]] double energy(const Matrix3& f) const {
    const double x = strain(f);
    if (stiffening == 0.0) return modulus * x * x / 8.0;
    return modulus / (8.0 * stiffening) * std::expm1(stiffening * x * x);
  }
  [[nodiscard]] Matrix3 stress(const Matrix3& f) const {
    const double x = strain(f);
    return 0.5 * modulus * x * std::exp(stiffening * x * x) * (f * along) * along.transpose();
  }
};

// Of a membrane in the plane z = 0 at rest: F has its columns, and the third is not read.
struct PlaneStress {
  double modulus, nu, thickness;
  bool neo_hookean;

  // With the third column for which no stress acts across, found by bisection.
  [[nodiscard]] Matrix3 relaxed(const Matrix3& f) const {
    const NeoHookean material{modulus, nu};
    const Vector3 normal = f.col(0).cross(f.col(1)).normalized();
    const auto with = [&](double z) {
      Matrix3 full = f;
      full.col(2) = z * normal;
      return full;
    };
    double low = 0.0, high = 1e4;
    for (int i = 0; i < 200; ++i) {
      const double z = 0.5 * (low + high);
      (material.stress(with(z)).col(2).dot(normal) < 0.0 ? low : high) = z;
    }
    return with(low);
  }
  [[nodiscard]] Eigen::Matrix2d green(const Matrix3& f) const {
    const Eigen::Matrix<double, 3, 2> in_plane = f.leftCols<2>();
    return 0.5 * (in_plane.transpose() * in_plane - Eigen::Matrix2d::Identity());
  }
  // Per area at rest, J/m^2.
  [[nodiscard]] double energy(const Matrix3& f) const {
    if (neo_hookean) return thickness * NeoHookean{modulus, nu}.energy(relaxed(f));
    const Eigen::Matrix2d e = green(f);
    return thickness * modulus / (2.0 * (1.0 - nu * nu)) * (nu * e.trace() * e.trace() + (1.0 - nu) * (e * e).trace());
  }
  // N/m; the third column is 0.
  [[nodiscard]] Matrix3 stress(const Matrix3& f) const {
    Matrix3 result = Matrix3::Zero();
    if (neo_hookean) {
      result.leftCols<2>() = thickness * NeoHookean{modulus, nu}.stress(relaxed(f)).leftCols<2>();
      return result;
    }
    const Eigen::Matrix2d e = green(f);
    const Eigen::Matrix2d s =
        modulus / (1.0 - nu * nu) * ((1.0 - nu) * e + nu * e.trace() * Eigen::Matrix2d::Identity());
    result.leftCols<2>() = thickness * f.leftCols<2>() * s;
    return result;
  }
};

}  // namespace springnet::testing
