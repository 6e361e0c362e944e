// Summary of a mesh file, before it is used in a scene: groups, sizes, likely unit of its coordinates.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/mesh.hpp>

namespace springnet {

inline constexpr std::size_t cell_type_count = 8;

// Extent of a mesh or of a group. Lengths are in the unit of the file.
struct MeshExtent {
  std::string name;    // of the group
  int dimension = -1;  // highest of its cells; -1: points only
  std::size_t points = 0;
  std::size_t cells = 0;
  std::array<std::size_t, cell_type_count> cells_of{};  // by CellType
  double measure = 0.0;                                 // total length, area or volume of the cells of that dimension
  Vector3 lower = Vector3::Zero(), upper = Vector3::Zero();  // corners of the box around its points
  // Edges of its cells; lengths are 0 if there are none.
  std::size_t edges = 0;
  double shortest = 0.0, median = 0.0, longest = 0.0;
  // Whether the surface cells, or the surface of the solid cells, are closed. Empty if there is no surface.
  std::optional<bool> closed;
  // Volume enclosed by a closed surface without solid cells; empty if there is none, or it cannot be oriented.
  std::optional<double> enclosed;

  [[nodiscard]] double size() const { return (upper - lower).maxCoeff(); }  // the longest side of the box
};

struct UnitGuess {
  std::string unit;    // "metres", "millimetres", "micrometres"
  double scale = 1.0;  // to metres: what mesh.scale should be
  bool sure = false;   // false: the size would fit another unit as well
  std::string reason;  // a sentence
};

struct MeshSummary {
  MeshExtent whole;
  std::vector<MeshExtent> groups;  // in the order of the file
  UnitGuess unit;
  std::vector<std::string> notes;  // Mesh::notes
};

// Throws nothing but std::bad_alloc.
[[nodiscard]] SPRINGNET_API MeshSummary summarise(const Mesh& mesh);

// Guesses from the longest side of the bounding box only: organs and instruments are between 1 mm and 2 m long.
[[nodiscard]] SPRINGNET_API UnitGuess guess_unit(double size);

// As JSON; lengths in the unit of the file.
[[nodiscard]] SPRINGNET_API std::string to_json(const MeshSummary& summary);

}  // namespace springnet
