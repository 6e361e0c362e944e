// What a mesh file holds, before a scene is made of it: groups, sizes, and which unit its coordinates have.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <springnet/mesh.hpp>

namespace springnet {

inline constexpr std::size_t cell_type_count = 8;

// Of the whole mesh, or of a group. Lengths are in the unit of the file.
struct MeshExtent {
  std::string name;    // of the group
  int dimension = -1;  // the greatest of its cells; -1: points alone
  std::size_t points = 0;
  std::size_t cells = 0;
  std::array<std::size_t, cell_type_count> cells_of{};  // by CellType
  double measure = 0.0;  // length, area or volume of the cells of that dimension, together
  Vector3 lower = Vector3::Zero(), upper = Vector3::Zero();  // corners of the box around its points
  // Edges of its cells; lengths are 0 where there are none.
  std::size_t edges = 0;
  double shortest = 0.0, median = 0.0, longest = 0.0;
  // Of surface cells, or of the surface of solid ones: whether it is closed. Empty where there is no surface.
  std::optional<bool> closed;
  // The volume in a closed surface without solid cells; empty where there is none, or it has one side only.
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
  std::vector<MeshExtent> groups;  // as in the file
  UnitGuess unit;
  std::vector<std::string> notes;  // of reading
};

// Throws nothing but std::bad_alloc.
[[nodiscard]] MeshSummary summarise(const Mesh& mesh);

// By the longest side of the box around the points alone: organs and instruments are between 1 mm and 2 m long.
[[nodiscard]] UnitGuess guess_unit(double size);

// As JSON; lengths in the unit of the file.
[[nodiscard]] std::string to_json(const MeshSummary& summary);

}  // namespace springnet
