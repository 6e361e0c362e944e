#include "inspect_mesh.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <springnet/mesh_summary.hpp>
#include <springnet/printable.hpp>

#include "mesh_scene.hpp"
#include "text/counted.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

// Cell types with an irregular plural need it spelled out.
std::string cells_text(const MeshExtent& extent) {
  std::string text;
  for (std::size_t k = 0; k < cell_type_count; ++k) {
    if (extent.cells_of[k] == 0) continue;
    const auto type = static_cast<CellType>(k);
    const char* several = type == CellType::vertex        ? "vertices"
                          : type == CellType::hexahedron  ? "hexahedra"
                          : type == CellType::tetrahedron ? "tetrahedra"
                                                          : "";
    text += fmt::format("{}{}", text.empty() ? "" : ", ", counted(extent.cells_of[k], name_of(type), several));
  }
  return text.empty() ? "none" : text;
}

// Lengths, areas and volumes in the unit of the file, and in metres if that differs.
class Lengths {
 public:
  explicit Lengths(double scale) : scale_(scale) {}
  [[nodiscard]] std::string text(double value, int dimension = 1) const {
    const std::string power = dimension > 1 ? fmt::format("^{}", dimension) : "";
    if (scale_ == 1.0) return fmt::format("{:.4g} m{}", value, power);
    return fmt::format("{:.4g} ({:.4g} m{})", value, value * std::pow(scale_, dimension), power);
  }
  [[nodiscard]] std::string sides(const Vector3& sides) const {
    const std::string in_file = fmt::format("{:.4g} x {:.4g} x {:.4g}", sides.x(), sides.y(), sides.z());
    if (scale_ == 1.0) return in_file + " m";
    return fmt::format("{} ({:.4g} x {:.4g} x {:.4g} m)", in_file, scale_ * sides.x(), scale_ * sides.y(),
                       scale_ * sides.z());
  }

 private:
  double scale_;
};

std::string measure_name(int dimension) { return dimension == 1 ? "length" : dimension == 2 ? "area" : "volume"; }

std::string surface_text(const MeshExtent& extent, const Lengths& lengths) {
  if (!extent.closed) return "none";
  if (!*extent.closed) return "open";
  return extent.enclosed ? "closed, around " + lengths.text(*extent.enclosed, 3) : std::string("closed");
}

std::vector<std::vector<std::string>> facts(const MeshSummary& summary, const Lengths& lengths) {
  const MeshExtent& whole = summary.whole;
  std::vector<std::vector<std::string>> rows{
      {"points", fmt::format("{}", whole.points)},
      {"cells", cells_text(whole)},
      {"size", lengths.sides(whole.upper - whole.lower)},
      {"from", fmt::format("({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g})", whole.lower.x(), whole.lower.y(),
                           whole.lower.z(), whole.upper.x(), whole.upper.y(), whole.upper.z())}};
  if (whole.edges > 0) {
    rows.push_back(
        {"edges", fmt::format("{}; shortest {}, median {}, longest {}", whole.edges, lengths.text(whole.shortest),
                              lengths.text(whole.median), lengths.text(whole.longest))});
  }
  if (whole.dimension > 0)
    rows.push_back({measure_name(whole.dimension), lengths.text(whole.measure, whole.dimension)});
  rows.push_back({"surface", surface_text(whole, lengths)});
  rows.push_back({"unit", fmt::format("{}{}: mesh.scale = {:g}. {}", summary.unit.unit,
                                      summary.unit.sure ? ", very likely" : ", possibly", summary.unit.scale,
                                      summary.unit.reason)});
  return rows;
}

std::vector<std::vector<std::string>> group_rows(const MeshSummary& summary, const Lengths& lengths) {
  std::vector<std::vector<std::string>> rows{
      {"group", "points", "cells", "length, area or volume", "size", "median edge", "surface"}};
  for (const MeshExtent& group : summary.groups) {
    rows.push_back({printable(group.name), fmt::format("{}", group.points), cells_text(group),
                    group.dimension > 0 ? lengths.text(group.measure, group.dimension) : "-",
                    lengths.sides(group.upper - group.lower), group.edges > 0 ? lengths.text(group.median) : "-",
                    surface_text(group, lengths)});
  }
  return rows;
}

}  // namespace

void inspect_mesh(const std::filesystem::path& file, bool json) {
  const Mesh mesh = read_mesh(file);
  const MeshSummary summary = summarise(mesh);
  if (json) {
    fmt::print("{}", to_json(summary));
    return;
  }
  const Lengths lengths(summary.unit.scale);
  const std::string name = printable_message(file.string());
  fmt::print("{}: a mesh\n{}", name, align_columns(facts(summary, lengths)));
  fmt::print("\nGroups, for selections:\n{}",
             summary.groups.empty() ? "  none\n" : align_columns(group_rows(summary, lengths)));
  for (const std::string& note : summary.notes) fmt::print("note: {}\n", printable_message(note));
  if (!(summary.whole.size() > 0.0)) return;
  fmt::print("\nIn a scene in the same folder:\n\n{}", scene_of(file.filename().string(), mesh, summary).body);
  fmt::print("\n'springnet new {}' writes a whole scene that runs as it is.\n", name);
}

}  // namespace springnet::tool
