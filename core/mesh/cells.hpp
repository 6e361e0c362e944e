// Faces and tetrahedra of a cell, as places among its corners.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include <springnet/mesh.hpp>

namespace springnet::meshes {

constexpr std::uint8_t no_corner = 255;

// Of a solid cell whose volume (solid_volume) is positive: corners counterclockwise seen from outside; triangles end
// with no_corner. Empty for others.
[[nodiscard]] std::span<const std::array<std::uint8_t, 4>> face_places(CellType type) noexcept;
// Tetrahedra that fill a solid cell, of positive volume where its volume is. Empty for others.
[[nodiscard]] std::span<const std::array<std::uint8_t, 4>> tetrahedron_places(CellType type) noexcept;

// The corners of a face (or of an edge, or a triangle or quadrilateral) rising, then no_point: equal for all cells that
// have it, however they are turned.
using FaceKey = std::array<std::uint32_t, 4>;
constexpr std::uint32_t no_point = std::numeric_limits<std::uint32_t>::max();
[[nodiscard]] FaceKey face_key(std::span<const std::uint32_t> corners);  // four at most
// Of one of face_places.
[[nodiscard]] FaceKey face_key(std::span<const std::uint32_t> cell, const std::array<std::uint8_t, 4>& places);

// (b - a) . ((c - a) x (d - a)) / 6, m^3.
[[nodiscard]] double tetrahedron_volume(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d);
// Volume within the faces of a solid cell, m^3; negative if it is turned inside out. Faces that are not plane count as
// the mean of their two divisions into triangles, which is the bilinear patch on them.
[[nodiscard]] double solid_volume(const Mesh& mesh, std::size_t cell);

}  // namespace springnet::meshes
