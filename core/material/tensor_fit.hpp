// Distribution of an isotropic cell's stiffness among springs of given directions.
#pragma once

#include <span>

#include <Eigen/Core>
#include <springnet/network.hpp>

namespace springnet::material {

inline constexpr int max_springs = 32;  // of a cell: a hexahedron has 12 edges, 12 face diagonals, 4 space diagonals

using Shares = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_springs, 1>;

// If the corners of a cell of volume V move with a homogeneous strain s, its springs e of stiffness k_e, length l_e and
// direction n_e have the energy s : (sum_e w_e n_e n_e n_e n_e) : s / 2, with w_e = k_e l_e^2. A solid whose elasticity
// has Cauchy's symmetry has V s : C : s / 2, C_ijkl = lambda (d_ij d_kl + d_ik d_jl + d_il d_jk). Of all w_e >= 0 with
// the full trace of V C (the mean stiffness over all directions), this returns those whose tensor is nearest to V C in
// the Frobenius norm, divided by their sum.
//
// n n n n : m m m m = (n m)^4 and n n n n : C = 3 lambda for every n, so that the linear term is the same for all
// springs: the shares are those of min u G u / 2 - sum u, u >= 0, with G_ef = (n_e n_f)^4. Solved by block principal
// pivoting (Judice, Pires, Comput. Oper. Res. 21 (1994) 587-596).
[[nodiscard]] Shares shares_of(std::span<const Vector3> directions);

// |trace sum_e shares_e n_e n_e n_e n_e - C|^2 / |C|^2 for a cell of 2 or 3 dimensions.
[[nodiscard]] double squared_misfit(std::span<const Vector3> directions, const Shares& shares, int dimension);

}  // namespace springnet::material
