// Cells and data of VTK's files, legacy and XML.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/builder.hpp"

namespace springnet::meshes {

enum class Scalar : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };
[[nodiscard]] std::size_t size_of(Scalar type) noexcept;
[[nodiscard]] bool is_integer(Scalar type) noexcept;
// Decodes consecutive values of that type; To is double, or for integer types std::int64_t.
template <class To>
[[nodiscard]] std::vector<To> decode(Scalar type, std::string_view bytes, bool swap);

// VTK's cell type numbers that the readers use themselves.
namespace vtk {
constexpr int vertex = 1, poly_vertex = 2, line = 3, poly_line = 4, triangle_strip = 6, polygon = 7;
}

// Converts the cells of a piece of a file to those of a mesh: a polyline becomes lines, a strip triangles.
class VtkCells {
 public:
  // Point 0 of the piece is the builder's `first_point`.
  VtkCells(Builder& builder, std::uint32_t first_point) : builder_(builder), first_point_(first_point) {}

  // Throws Error(input) for points that do not exist or do not fit the type.
  void add(int type, std::span<const std::int64_t> points, Place place);
  [[nodiscard]] std::size_t count() const noexcept { return begins_.size(); }

  // Whether an array of that name gives groups: "group", "material", "CellEntityIds", "PhysicalIds", …, ignoring case.
  [[nodiscard]] static bool is_group_name(std::string_view name);
  // Makes one group for each number, named "NAME NUMBER". One value for each cell, or point, of the piece.
  void groups_of_cells(const std::string& name, std::span<const std::int64_t> values);
  void groups_of_points(const std::string& name, std::span<const std::int64_t> values);

 private:
  Builder& builder_;
  std::uint32_t first_point_;
  std::vector<std::size_t> begins_;  // [cell of the file] first cell of the mesh that was made of it
  std::vector<std::uint32_t> corners_;
};

// Cells of a grid of points, x fastest: lines, quadrilaterals or hexahedra, depending on how many dimensions are above
// 1.
void add_grid_cells(VtkCells& cells, const std::array<std::size_t, 3>& dimensions, Place place);

}  // namespace springnet::meshes
