// Faces and tetrahedra of a cell, as indices into its corners.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include <springnet/mesh.hpp>

namespace springnet::meshes {

constexpr std::uint8_t no_corner = 255;

// Faces of a solid cell: corners counterclockwise seen from outside if its volume (solid_volume) is positive; triangles
// end with no_corner. Empty for other cells.
[[nodiscard]] std::span<const std::array<std::uint8_t, 4>> face_places(CellType type) noexcept;
// Tetrahedra that fill a solid cell, of positive volume if its own is. Empty for other cells.
[[nodiscard]] std::span<const std::array<std::uint8_t, 4>> tetrahedron_places(CellType type) noexcept;

// The corners of a face, edge, triangle or quadrilateral in ascending order, padded with no_point: equal for all cells
// that share it, whatever their orientation.
using FaceKey = std::array<std::uint32_t, 4>;
constexpr std::uint32_t no_point = std::numeric_limits<std::uint32_t>::max();
[[nodiscard]] FaceKey face_key(std::span<const std::uint32_t> corners);  // four at most
// Key of one of face_places.
[[nodiscard]] FaceKey face_key(std::span<const std::uint32_t> cell, const std::array<std::uint8_t, 4>& places);

// (b - a) . ((c - a) x (d - a)) / 6, m^3.
[[nodiscard]] double tetrahedron_volume(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d);
// Volume of a solid cell, m^3; negative if it is inside out. Faces that are not plane count as the mean of their two
// divisions into triangles, that is, as bilinear patches.
[[nodiscard]] double solid_volume(const Mesh& mesh, std::size_t cell);

}  // namespace springnet::meshes
