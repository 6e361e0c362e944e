#include <algorithm>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <springnet/error.hpp>
#include <springnet/mesh_summary.hpp>

#include "mesh/cells.hpp"

namespace springnet {
namespace {

// A group as a mesh of its own. Its cost depends on the group alone, because a mesh may have as many groups as cells.
Mesh part_of(const Mesh& mesh, const MeshGroup& group) {
  Mesh part;
  for (const std::uint32_t point : group.points) part.points.push_back(mesh.points[point]);
  std::vector<std::uint32_t> corners;
  for (const std::uint32_t cell : group.cells) {
    corners.clear();
    for (const std::uint32_t point : mesh.cell(cell)) {
      const auto place = std::lower_bound(group.points.begin(), group.points.end(), point);
      corners.push_back(static_cast<std::uint32_t>(place - group.points.begin()));
    }
    part.add_cell(mesh.types[cell], corners);
  }
  return part;
}

std::optional<double> enclosed_by(const std::vector<Face>& faces, const Mesh& mesh) {
  try {
    double volume = 0.0;
    for (const auto& [a, b, c] : oriented(faces, mesh.points))
      volume += meshes::tetrahedron_volume(mesh.points[faces[0][0]], mesh.points[a], mesh.points[b], mesh.points[c]);
    return volume;
  } catch (const Error&) {
    return std::nullopt;  // it has only one side
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

MeshExtent extent_of(const std::string& name, const Mesh& mesh) {
  MeshExtent extent;
  extent.name = name;
  extent.points = mesh.points.size();
  extent.cells = mesh.cell_count();
  for (const CellType type : mesh.types) {
    extent.dimension = std::max(extent.dimension, dimension_of(type));
    ++extent.cells_of[static_cast<std::size_t>(type)];
  }
  for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
    if (dimension_of(mesh.types[cell]) == extent.dimension) extent.measure += measure_of(mesh, cell);
  }
  if (!mesh.points.empty()) extent.lower = extent.upper = mesh.points.front();
  for (const Vector3& point : mesh.points) {
    extent.lower = extent.lower.cwiseMin(point);
    extent.upper = extent.upper.cwiseMax(point);
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
  // Sizes from `min_size` to `doubtful` are plausible in metres; up to `too_large` they may be metres or millimetres.
  constexpr double min_size = 1e-3, doubtful = 3.0, too_large = 10.0, micrometres = 2e4;
  const auto as = [&](const char* unit) { return fmt::format("{:.3g} {}", size, unit); };
  if (!(size > 0.0)) return {"metres", 1.0, false, "It has no extent, so its unit is unknown."};
  if (size < min_size) {
    return {"metres", 1.0, false,
            fmt::format("It is {:.3g} long: less than a millimetre in metres, and even less in smaller units.", size)};
  }
  if (size <= doubtful) {
    return {
        "metres", 1.0, true,
        fmt::format("It is {} long; in millimetres it would be {} µm.", as("m"), fmt::format("{:.3g}", 1e3 * size))};
  }
  if (size <= too_large) {
    return {"metres", 1.0, false, fmt::format("It is {} or {} long; the file does not say which.", as("m"), as("mm"))};
  }
  if (size <= micrometres) {
    return {"millimetres", 1e-3, true,
            fmt::format("It is {} long; in metres it would be as large as a house.", as("mm"))};
  }
  return {"micrometres", 1e-6, false,
          fmt::format("It is {:.3g} mm long in micrometres, {:.3g} m in millimetres.", 1e-3 * size, 1e-3 * size)};
}

MeshSummary summarise(const Mesh& mesh) {
  MeshSummary summary;
  summary.whole = extent_of("", mesh);
  for (const MeshGroup& group : mesh.groups) summary.groups.push_back(extent_of(group.name, part_of(mesh, group)));
  summary.unit = guess_unit(summary.whole.size());
  summary.notes = mesh.notes;
  return summary;
}

}  // namespace springnet
