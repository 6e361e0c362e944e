// Meshes as files contain them: points, cells and named groups. Their edges become the springs of a network.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/loading.hpp>
#include <springnet/network.hpp>

namespace springnet {

// Nodes of a cell are in VTK's order, which is that of Gmsh's first-order elements too.
enum class CellType : std::uint8_t { vertex, line, triangle, quadrilateral, tetrahedron, hexahedron, wedge, pyramid };
[[nodiscard]] SPRINGNET_API std::size_t corner_count(CellType type) noexcept;
[[nodiscard]] SPRINGNET_API int dimension_of(CellType type) noexcept;  // 0 to 3
[[nodiscard]] SPRINGNET_API std::string_view name_of(CellType type) noexcept;

// A named set of cells and points: a physical group of Gmsh, a group of OBJ, a solid of STL.
struct MeshGroup {
  std::string name;
  std::vector<std::uint32_t> cells;   // ascending
  std::vector<std::uint32_t> points;  // of the cells, and single ones; ascending, unique
};

struct Mesh {
  std::vector<Vector3> points;          // m
  std::vector<CellType> types;          // [cell]
  std::vector<std::size_t> offsets{0};  // [cell + 1] into `corners`
  std::vector<std::uint32_t> corners;   // points of all cells
  std::vector<MeshGroup> groups;
  // Notes, in plain sentences, on what was not taken from the file: middle nodes of second-order cells, unknown
  // sections, …
  std::vector<std::string> notes;

  [[nodiscard]] std::size_t cell_count() const noexcept { return types.size(); }
  [[nodiscard]] std::span<const std::uint32_t> cell(std::size_t index) const {
    return {corners.data() + offsets[index], offsets[index + 1] - offsets[index]};
  }
  SPRINGNET_API void add_cell(CellType type, std::span<const std::uint32_t> points_of_cell);
};

// Whether the file has an extension that read_mesh accepts.
[[nodiscard]] SPRINGNET_API bool has_mesh_ending(const std::filesystem::path& file);

// Reads a mesh file. The extension selects the format: .msh (Gmsh 4.0 and 4.1, text and binary), .vtk (legacy, text and
// binary: unstructured grid, polydata, structured grids), .vtu and .vtp (XML: text, inline binary, appended raw or
// base64, zlib), .obj, .stl (text and binary; equal corners become one point), .ply (text and binary; vertices alone
// become cells). Points that no cell uses are left out, with a note. Throws Error(input) with "file:line: what; what to
// do" (in binary parts the byte) if the file cannot be read.
[[nodiscard]] SPRINGNET_API Mesh read_mesh(const std::filesystem::path& file, const LoadingCallback& loading = {});
// The same for a cloud of points: all points are kept, and there need not be a cell.
[[nodiscard]] SPRINGNET_API Mesh read_points(const std::filesystem::path& file, const LoadingCallback& loading = {});

// Which edges become springs.
struct EdgeOptions {
  bool face_diagonals = false;   // both of each quadrilateral, also as a face of a solid cell
  bool space_diagonals = false;  // the four through each hexahedron
};
using Edge = std::pair<std::uint32_t, std::uint32_t>;  // lower point first

// Edges of all cells and the requested diagonals, unique, in ascending order of points.
[[nodiscard]] SPRINGNET_API std::vector<Edge> edges_of(const Mesh& mesh, const EdgeOptions& options = {});
// The same for one cell: pairs of indices of its corners.
[[nodiscard]] SPRINGNET_API std::span<const std::array<std::uint8_t, 2>> edge_places(CellType type) noexcept;
[[nodiscard]] SPRINGNET_API std::span<const std::array<std::uint8_t, 2>> face_diagonal_places(CellType type) noexcept;
[[nodiscard]] SPRINGNET_API std::span<const std::array<std::uint8_t, 2>> space_diagonal_places(CellType type) noexcept;

// Pairs of the points of a cloud: each with at most so many of the nearest others within a radius (m), of equally near
// ones those of lower numbers; in ascending order, unique. A point may be in more pairs, as neighbour of others. Throws
// Error(input) for points at the same place, and for too many pairs.
[[nodiscard]] SPRINGNET_API std::vector<Edge> near_pairs(std::span<const Vector3> points, double radius,
                                                         std::size_t most);
inline constexpr std::size_t most_near_pairs = 20'000'000;  // each may be counted twice

// Triangles of the surface: faces that belong to only one solid cell, outward; and surface cells, oriented as in the
// file, except those that lie on a solid cell. Quadrilaterals are divided along their shorter diagonal.
[[nodiscard]] SPRINGNET_API std::vector<Face> surface_of(const Mesh& mesh);
// Orients triangles consistently, and closed parts outward. Throws Error(input) if an edge belongs to more than two
// triangles or the surface cannot be oriented (a Möbius strip).
[[nodiscard]] SPRINGNET_API std::vector<Face> oriented(std::vector<Face> faces, std::span<const Vector3> points);
// Whether every edge belongs to two triangles.
[[nodiscard]] SPRINGNET_API bool is_closed(std::span<const Face> faces);
// For each edge between two triangles: the edge's points, then the tips, as Invariant::dihedral takes them.
[[nodiscard]] SPRINGNET_API std::vector<std::array<std::uint32_t, 4>> hinges_of(std::span<const Face> faces);
// Solid cells as tetrahedra of positive volume (hexahedra as six, wedges as three, pyramids as two).
[[nodiscard]] SPRINGNET_API std::vector<std::array<std::uint32_t, 4>> tetrahedra_of(const Mesh& mesh);
[[nodiscard]] SPRINGNET_API std::vector<std::array<std::uint32_t, 4>> tetrahedra_of(const Mesh& mesh, std::size_t cell);
// A solid cell as tetrahedra that fit together with those of its neighbours: quadrilaterals are divided from their
// lowest point, cells from theirs (J. Dompierre et al., How to subdivide pyramids, prisms and hexahedra into
// tetrahedra, 8th Int. Meshing Roundtable, 1999). Tetrahedra of strongly distorted cells may have no volume, or a
// negative one.
[[nodiscard]] SPRINGNET_API std::vector<std::array<std::uint32_t, 4>> conforming_tetrahedra_of(const Mesh& mesh,
                                                                                               std::size_t cell);

// Length, area or volume of a cell, depending on its dimension; m, m^2, m^3. Positive for either orientation.
[[nodiscard]] SPRINGNET_API double measure_of(const Mesh& mesh, std::size_t cell);

}  // namespace springnet
