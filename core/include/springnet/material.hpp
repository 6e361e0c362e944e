// A material to springs and masses: from the cells of a mesh, Young's modulus and density to a stiffness for each edge
// and a mass for each point. core/docs/material.md has the formulas and what they are worth.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <springnet/mesh.hpp>
#include <springnet/network.hpp>

namespace springnet {

// What turns surface cells and line cells into volume. Needed where a mesh has such cells.
struct Section {
  std::optional<double> thickness{};      // m
  std::optional<double> cross_section{};  // m^2
};

// The Poisson ratio of an isotropic net of springs whose nodes move evenly. Forces along the lines between nodes leave
// one elastic constant (Cauchy's relation), and with it 1/4 in a solid and 1/3 in a sheet (plane stress). Nets of
// irregular cells, whose nodes do not, have another one (core/docs/material.md). Of dimension 2 and 3.
[[nodiscard]] double poisson_ratio_of_net(int dimension) noexcept;

// The cells that have substance: all but vertices and those that are a face or an edge of another cell (as the named
// boundary of a solid is).
[[nodiscard]] std::vector<std::size_t> bearing_cells(const Mesh& mesh);

// Mass of each point, kg: that of each bearing cell in equal parts to its corners. `density` kg/m^3. Throws
// Error(input) for a density that is not above 0, a thickness or cross section that is missing or not above 0, a point
// that gets no mass.
[[nodiscard]] std::vector<double> masses_of(const Mesh& mesh, double density, const Section& section);

struct NetStiffness {
  std::vector<double> stiffness;  // [edge], N/m, at least 0
  int dimension = 0;              // the greatest of the bearing cells
  // How far the elasticity tensors of single cells are from the isotropic one: the root mean square by volume of the
  // relative difference (Frobenius norm). In the mean over neighbours much of it cancels. Of solid and surface cells.
  double misfit = 0.0;
  // The same over quadrilaterals, hexahedra, wedges and pyramids alone: their neighbours in a mesh are much as they
  // are, so that little cancels, and the net is that far from what is wanted. (Triangles and tetrahedra, which are far
  // from isotropic one by one, are not in good meshes.) 0 without such cells.
  double fitted_misfit = 0.0;
  bool lacks_shear = false;  // a quadrilateral or hexahedron has no diagonal among the edges
};

// Stiffness of springs along `edges` (those of edges_of) so that the net is as near as it can be to the isotropic
// solid of Young's modulus `youngs_modulus`, Pa. Throws Error(input) as masses_of, for a cell without volume or with
// two corners at one place, and for an edge of a cell that is not among `edges`.
[[nodiscard]] NetStiffness stiffness_of(const Mesh& mesh, std::span<const Edge> edges, double youngs_modulus,
                                        const Section& section);

// Points and cells of a lattice, numbered as its nodes: hexahedra; quadrilaterals where it is one node thick; lines
// where it is a row; a vertex. Throws Error(input) for more nodes than there are numbers, or than memory has room for.
[[nodiscard]] Mesh mesh_of(const Lattice& lattice);

}  // namespace springnet
