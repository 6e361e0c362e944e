#include <cstdint>
#include <unordered_set>

#include "material/bearing.hpp"
#include "mesh/cells.hpp"

namespace springnet {
namespace {

using meshes::FaceKey;

struct KeyHash {
  std::size_t operator()(const FaceKey& key) const noexcept {
    std::uint64_t hash = 0;
    for (const std::uint32_t corner : key) hash = (hash ^ corner) * 0x9e3779b97f4a7c15u;
    return static_cast<std::size_t>(hash ^ (hash >> 29));
  }
};

}  // namespace

std::vector<std::size_t> bearing_cells(const Mesh& mesh) {
  // Faces and edges of cells of higher dimension, collected only if the mesh has lower cells that may lie on them.
  bool has_surface = false, has_line = false;
  for (const CellType type : mesh.types) {
    has_surface = has_surface || dimension_of(type) == 2;
    has_line = has_line || dimension_of(type) == 1;
  }
  std::unordered_set<FaceKey, KeyHash> sides;
  for (std::size_t c = 0; c < mesh.cell_count(); ++c) {
    const auto cell = mesh.cell(c);
    if (has_line && dimension_of(mesh.types[c]) > 1) {
      for (const auto& [a, b] : edge_places(mesh.types[c]))
        sides.insert(meshes::face_key(std::array{cell[a], cell[b]}));
    }
    if (!has_surface) continue;
    for (const auto& face : meshes::face_places(mesh.types[c])) sides.insert(meshes::face_key(cell, face));
  }
  std::vector<std::size_t> bearing;
  for (std::size_t c = 0; c < mesh.cell_count(); ++c) {
    const int dimension = dimension_of(mesh.types[c]);
    if (dimension == 3 || (dimension > 0 && !sides.contains(meshes::face_key(mesh.cell(c))))) bearing.push_back(c);
  }
  return bearing;
}

namespace material {

double volume_of(const Mesh& mesh, std::size_t cell, const Section& section) {
  const double measure = measure_of(mesh, cell);
  const int dimension = dimension_of(mesh.types[cell]);
  if (dimension == 3) return measure;
  const std::optional<double>& factor = dimension == 2 ? section.thickness : section.cross_section;
  const std::string_view what = dimension == 2 ? "a thickness, in m" : "a cross section, in m^2";
  if (!factor) {
    fail(
        fmt::format("{} {} has no volume without {}: give it; or, for a solid, a mesh with solid cells (Gmsh writes "
                    "them where a physical volume has them)",
                    name_of(mesh.types[cell]), cell, what));
  }
  if (!(std::isfinite(*factor) && *factor > 0)) fail(fmt::format("{} must be above 0, is {}", what, *factor));
  return measure * *factor;
}

}  // namespace material
}  // namespace springnet
