// How the stiffness of a cell is shared out among its springs.
#pragma once

#include <springnet/material.hpp>

namespace springnet::material {

enum class Sharing {
  // k l^2 is the same for all springs of a cell, k = E V / l^2 in a tetrahedron and E t A / l^2 in a triangle: A. Van
  // Gelder, Approximate simulation of elastic membranes by triangulated spring meshes, J. Graphics Tools 3 (1998)
  // 21-41. Isotropic where the cell is regular.
  equal,
  fitted,  // shares_of: isotropic wherever the directions of a cell's springs allow it
  // Lines, triangles and tetrahedra: equal, others fitted. An irregular triangle or tetrahedron cannot be isotropic by
  // itself, and a net of them is the stiffer, and nearer to what is wanted, the more even its springs are (measured:
  // core/docs/material.md).
  best
};

[[nodiscard]] NetStiffness stiffness_of(const Mesh& mesh, std::span<const Edge> edges, double youngs_modulus,
                                        const Section& section, Sharing sharing);

}  // namespace springnet::material
