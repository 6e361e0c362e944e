#include <limits>
#include <new>

#include "material/bearing.hpp"

namespace springnet {

Mesh mesh_of(const Lattice& lattice) {
  const auto [nx, ny, nz] = lattice.nodes;
  const double count = static_cast<double>(nx) * ny * nz;
  const auto too_many = [&] {
    material::fail(
        fmt::format("the cells of a lattice of {:.4g} nodes do not fit into memory: use fewer nodes", count));
  };
  Mesh mesh;
  try {
    if (count > std::numeric_limits<std::uint32_t>::max()) too_many();
    mesh.points.reserve(static_cast<std::size_t>(count));
    mesh.corners.reserve(8 * static_cast<std::size_t>(count));
  } catch (const std::bad_alloc&) {
    too_many();
  }
  for (std::uint32_t k = 0; k < nz; ++k) {
    for (std::uint32_t j = 0; j < ny; ++j) {
      for (std::uint32_t i = 0; i < nx; ++i) {
        mesh.points.emplace_back(lattice.origin + lattice.spacing.cwiseProduct(Vector3(i, j, k)));
      }
    }
  }
  // Strides of the directions in which the lattice extends; a cell has the places 0 and 1 along each.
  const std::array<std::uint32_t, 3> strides{1, nx, nx * ny};
  std::vector<std::uint32_t> along;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (lattice.nodes[axis] > 1) along.push_back(strides[axis]);
  }
  constexpr std::array types{CellType::vertex, CellType::line, CellType::quadrilateral, CellType::hexahedron};
  // Corners in VTK's order: around the lower quadrilateral, then around the upper one.
  constexpr std::array<std::array<std::uint32_t, 3>, 8> corners{
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
  const CellType type = types[along.size()];
  const auto cells = [](std::uint32_t nodes) { return nodes > 1 ? nodes - 1 : 1; };
  std::vector<std::uint32_t> cell(corner_count(type));
  for (std::uint32_t k = 0; k < cells(nz); ++k) {
    for (std::uint32_t j = 0; j < cells(ny); ++j) {
      for (std::uint32_t i = 0; i < cells(nx); ++i) {
        const std::uint32_t first = i + nx * (j + ny * k);
        for (std::size_t c = 0; c < cell.size(); ++c) {
          cell[c] = first;
          for (std::size_t d = 0; d < along.size(); ++d) cell[c] += corners[c][d] * along[d];
        }
        mesh.add_cell(type, cell);
      }
    }
  }
  return mesh;
}

}  // namespace springnet
