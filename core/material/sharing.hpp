// Distribution of a cell's stiffness among its springs.
#pragma once

#include <springnet/material.hpp>

namespace springnet::material {

enum class Sharing {
  // k l^2 is the same for all springs of a cell, k = E V / l^2 in a tetrahedron and E t A / l^2 in a triangle: A. Van
  // Gelder, Approximate simulation of elastic membranes by triangulated spring meshes, J. Graphics Tools 3 (1998)
  // 21-41. Isotropic if the cell is regular.
  equal,
  fitted,  // shares_of: isotropic if the directions of a cell's springs allow it
  // `equal` for lines, triangles and tetrahedra, `fitted` for others. An irregular triangle or tetrahedron cannot be
  // isotropic on its own; a net of them is stiffer, and closer to the wanted modulus, the more uniform its springs are
  // (measured: core/docs/material.md).
  best
};

[[nodiscard]] NetStiffness stiffness_of(const Mesh& mesh, std::span<const Edge> edges, double youngs_modulus,
                                        const Section& section, Sharing sharing);

}  // namespace springnet::material
