// Blocks of matrices over nodes: 3 x 3, row-major.
#pragma once

#include <springnet/network.hpp>

namespace springnet::layers {

using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// Mass times da/dF of a point mass is the identity, up to this.
inline constexpr double point_mass_rounding = 1e-12;

// The matrix [a]x of x -> a x x.
[[nodiscard]] inline Block cross_matrix(const Vector3& a) {
  Block block;
  block << 0.0, -a[2], a[1], a[2], 0.0, -a[0], -a[1], a[0], 0.0;
  return block;
}

}  // namespace springnet::layers
