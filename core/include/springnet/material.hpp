// Springs and masses from a material: a stiffness for each edge and a mass for each point, from the cells of a mesh,
// Young's modulus and density. Formulas and their accuracy: core/docs/material.md.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/mesh.hpp>
#include <springnet/network.hpp>

namespace springnet {

// Dimensions that give surface and line cells a volume. Needed if a mesh has such cells.
struct Section {
  std::optional<double> thickness{};      // m
  std::optional<double> cross_section{};  // m^2
};

// Poisson ratio of an isotropic net of springs under affine deformation, for dimension 2 and 3. Central forces leave
// one elastic constant (Cauchy's relation), so the ratio is 1/4 in a solid and 1/3 in a sheet (plane stress). Nets of
// irregular cells do not deform affinely and have another ratio (core/docs/material.md).
[[nodiscard]] SPRINGNET_API double poisson_ratio_of_net(int dimension) noexcept;

// The cells that have mass and stiffness: all except vertices and cells that are a face or an edge of another cell,
// such as the named boundary of a solid.
[[nodiscard]] SPRINGNET_API std::vector<std::size_t> bearing_cells(const Mesh& mesh);

// Mass of each point, kg: the mass of each bearing cell is divided equally among its corners. `density`: kg/m^3. Throws
// Error(input) for a density that is not above 0, a thickness or cross section that is missing or not above 0, or a
// point without mass.
[[nodiscard]] SPRINGNET_API std::vector<double> masses_of(const Mesh& mesh, double density, const Section& section);

struct NetStiffness {
  std::vector<double> stiffness;  // [edge], N/m, at least 0
  int dimension = 0;              // the highest of the bearing cells
  // Deviation of the cells' elasticity tensors from the isotropic one: relative difference (Frobenius norm), root mean
  // square weighted by volume, over solid and surface cells. Much of it cancels in the mean over neighbours.
  double misfit = 0.0;
  // The same over quadrilaterals, hexahedra, wedges and pyramids only: their neighbours have similar deviations, so
  // that little cancels and the net has about this deviation. (Single triangles and tetrahedra are far from isotropic,
  // good meshes of them are not.) 0 without such cells.
  double fitted_misfit = 0.0;
  bool lacks_shear = false;  // a quadrilateral or hexahedron has no diagonal among the edges
};

// Stiffness of springs along `edges` (those of edges_of) such that the net approximates the isotropic solid of Young's
// modulus `youngs_modulus`, Pa, as closely as possible. Throws Error(input) as masses_of, for a cell without volume or
// with coincident corners, and for an edge of a cell that is missing in `edges`.
[[nodiscard]] SPRINGNET_API NetStiffness stiffness_of(const Mesh& mesh, std::span<const Edge> edges,
                                                      double youngs_modulus, const Section& section);

// Points and cells of a lattice, numbered as its nodes: hexahedra; quadrilaterals if it is one node thick, lines if it
// is a row, a vertex if it is one node. Throws Error(input) for more nodes than there are numbers or than fit into
// memory.
[[nodiscard]] SPRINGNET_API Mesh mesh_of(const Lattice& lattice);

}  // namespace springnet
