#include <algorithm>
#include <numeric>
#include <span>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <springnet/error.hpp>
#include <springnet/mesh_summary.hpp>

#include "mesh/cells.hpp"

namespace springnet {
namespace {

// The cells of a group as a mesh of their own, with all points.
Mesh part_of(const Mesh& mesh, std::span<const std::uint32_t> cells) {
  Mesh part;
  part.points = mesh.points;
  for (const std::uint32_t cell : cells) part.add_cell(mesh.types[cell], mesh.cell(cell));
  return part;
}

std::optional<double> enclosed_by(const std::vector<Face>& faces, const Mesh& mesh) {
  try {
    double volume = 0.0;
    for (const auto& [a, b, c] : oriented(faces, mesh.points))
      volume += meshes::tetrahedron_volume(mesh.points[faces[0][0]], mesh.points[a], mesh.points[b], mesh.points[c]);
    return volume;
  } catch (const Error&) {
    return std::nullopt;  // one side only
  }
}

void measure_edges(const Mesh& mesh, MeshExtent& extent) {
  std::vector<double> lengths;
  for (const auto& [a, b] : edges_of(mesh)) lengths.push_back((mesh.points[b] - mesh.points[a]).norm());
  extent.edges = lengths.size();
  if (lengths.empty()) return;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>((lengths.size() - 1) / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  extent.median = *middle;
  const auto [shortest, longest] = std::minmax_element(lengths.begin(), lengths.end());
  extent.shortest = *shortest;
  extent.longest = *longest;
}

// mesh: with the cells of the group alone.
MeshExtent extent_of(const std::string& name, const Mesh& mesh, std::span<const std::uint32_t> points) {
  MeshExtent extent;
  extent.name = name;
  extent.points = points.size();
  extent.cells = mesh.cell_count();
  for (const CellType type : mesh.types) {
    extent.dimension = std::max(extent.dimension, dimension_of(type));
    ++extent.cells_of[static_cast<std::size_t>(type)];
  }
  for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
    if (dimension_of(mesh.types[cell]) == extent.dimension) extent.measure += measure_of(mesh, cell);
  }
  if (!points.empty()) extent.lower = extent.upper = mesh.points[points.front()];
  for (const std::uint32_t point : points) {
    extent.lower = extent.lower.cwiseMin(mesh.points[point]);
    extent.upper = extent.upper.cwiseMax(mesh.points[point]);
  }
  measure_edges(mesh, extent);
  if (extent.dimension < 2) return extent;
  const std::vector<Face> faces = surface_of(mesh);
  extent.closed = is_closed(faces);
  if (*extent.closed && extent.dimension == 2) extent.enclosed = enclosed_by(faces, mesh);
  return extent;
}

}  // namespace

UnitGuess guess_unit(double size) {
  // Between these, coordinates in metres are ordinary. Up to `doubtful` they may be metres or millimetres.
  constexpr double least = 1e-3, doubtful = 3.0, too_large = 10.0, micrometres = 2e4;
  const auto as = [&](const char* unit) { return fmt::format("{:.3g} {}", size, unit); };
  if (!(size > 0.0)) return {"metres", 1.0, false, "It has no size to tell the unit by."};
  if (size < least) {
    return {"metres", 1.0, false,
            fmt::format("It is {:.3g} long: in metres less than a millimetre, and in no usual unit more.", size)};
  }
  if (size <= doubtful) {
    return {
        "metres", 1.0, true,
        fmt::format("It is {} long; as millimetres that would be {} µm.", as("m"), fmt::format("{:.3g}", 1e3 * size))};
  }
  if (size <= too_large) {
    return {"metres", 1.0, false, fmt::format("It is {} or {} long; nothing says which.", as("m"), as("mm"))};
  }
  if (size <= micrometres) {
    return {"millimetres", 1e-3, true,
            fmt::format("It is {} long; as metres it would be larger than a house.", as("mm"))};
  }
  return {"micrometres", 1e-6, false,
          fmt::format("It is {:.3g} mm long in micrometres, {:.3g} m in millimetres.", 1e-3 * size, 1e-3 * size)};
}

MeshSummary summarise(const Mesh& mesh) {
  MeshSummary summary;
  std::vector<std::uint32_t> all(mesh.points.size());
  std::iota(all.begin(), all.end(), 0U);
  summary.whole = extent_of("", mesh, all);
  for (const MeshGroup& group : mesh.groups) {
    summary.groups.push_back(extent_of(group.name, part_of(mesh, group.cells), group.points));
  }
  summary.unit = guess_unit(summary.whole.size());
  summary.notes = mesh.notes;
  return summary;
}

}  // namespace springnet
