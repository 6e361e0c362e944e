#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <springnet/mesh.hpp>

#include "mesh/cells.hpp"

namespace springnet {

double measure_of(const Mesh& mesh, std::size_t cell) {
  const auto corners = mesh.cell(cell);
  const auto p = [&](std::size_t k) -> const Vector3& { return mesh.points[corners[k]]; };
  switch (mesh.types[cell]) {
    case CellType::vertex:
      return 0.0;
    case CellType::line:
      return (p(1) - p(0)).norm();
    case CellType::triangle:
      return 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
    case CellType::quadrilateral:  // half the cross product of the diagonals; exact if it is plane, convex or not
      return 0.5 * (p(2) - p(0)).cross(p(3) - p(1)).norm();
    case CellType::tetrahedron:
    case CellType::hexahedron:
    case CellType::wedge:
    case CellType::pyramid:
      break;
  }
  return std::abs(meshes::solid_volume(mesh, cell));
}

std::vector<std::array<std::uint32_t, 4>> tetrahedra_of(const Mesh& mesh, std::size_t cell) {
  std::vector<std::array<std::uint32_t, 4>> result;
  const auto corners = mesh.cell(cell);
  for (const auto& places : meshes::tetrahedron_places(mesh.types[cell])) {
    std::array nodes{corners[places[0]], corners[places[1]], corners[places[2]], corners[places[3]]};
    const double volume = meshes::tetrahedron_volume(mesh.points[nodes[0]], mesh.points[nodes[1]],
                                                     mesh.points[nodes[2]], mesh.points[nodes[3]]);
    if (volume == 0.0) continue;
    if (volume < 0.0) std::swap(nodes[2], nodes[3]);
    result.push_back(nodes);
  }
  return result;
}

std::vector<std::array<std::uint32_t, 4>> conforming_tetrahedra_of(const Mesh& mesh, std::size_t cell) {
  const auto corners = mesh.cell(cell);
  if (mesh.types[cell] == CellType::tetrahedron) return tetrahedra_of(mesh, cell);
  std::vector<std::array<std::uint32_t, 4>> result;
  const auto faces = meshes::face_places(mesh.types[cell]);
  if (faces.empty()) return result;
  const bool inside_out = meshes::solid_volume(mesh, cell) < 0.0;
  // The lowest point of the cell is the tip of all of them; their bases are the triangles of the faces without it.
  const std::uint32_t tip = *std::min_element(corners.begin(), corners.end());
  for (const auto& places : faces) {
    std::array<std::uint32_t, 4> face{};
    const std::size_t size = places[3] == meshes::no_corner ? 3 : 4;
    for (std::size_t k = 0; k < size; ++k) face[k] = corners[places[k]];
    if (std::find(face.begin(), face.begin() + size, tip) != face.begin() + size) continue;
    // A quadrilateral is divided from its lowest point.
    std::rotate(face.begin(), std::min_element(face.begin(), face.begin() + size), face.begin() + size);
    for (std::size_t k = 1; k + 1 < size; ++k) {
      // Faces are counterclockwise from outside: seen from the tip, clockwise.
      std::array<std::uint32_t, 4> nodes{tip, face[0], face[k], face[k + 1]};
      if (inside_out) std::swap(nodes[2], nodes[3]);
      result.push_back(nodes);
    }
  }
  return result;
}

std::vector<std::array<std::uint32_t, 4>> tetrahedra_of(const Mesh& mesh) {
  std::vector<std::array<std::uint32_t, 4>> result;
  for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
    const auto of_cell = tetrahedra_of(mesh, cell);
    result.insert(result.end(), of_cell.begin(), of_cell.end());
  }
  return result;
}

}  // namespace springnet
