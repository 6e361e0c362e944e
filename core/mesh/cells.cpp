#include "mesh/cells.hpp"

#include <algorithm>
#include <utility>

namespace springnet {
namespace {

using Places2 = std::array<std::uint8_t, 2>;
using Places4 = std::array<std::uint8_t, 4>;
constexpr std::uint8_t none = meshes::no_corner;

constexpr std::array<Places2, 1> line_edges{Places2{0, 1}};
constexpr std::array triangle_edges{Places2{0, 1}, Places2{1, 2}, Places2{2, 0}};
constexpr std::array quadrilateral_edges{Places2{0, 1}, Places2{1, 2}, Places2{2, 3}, Places2{3, 0}};
constexpr std::array tetrahedron_edges{Places2{0, 1}, Places2{1, 2}, Places2{2, 0},
                                       Places2{0, 3}, Places2{1, 3}, Places2{2, 3}};
constexpr std::array hexahedron_edges{Places2{0, 1}, Places2{1, 2}, Places2{2, 3}, Places2{3, 0},
                                      Places2{4, 5}, Places2{5, 6}, Places2{6, 7}, Places2{7, 4},
                                      Places2{0, 4}, Places2{1, 5}, Places2{2, 6}, Places2{3, 7}};
constexpr std::array wedge_edges{Places2{0, 1}, Places2{1, 2}, Places2{2, 0}, Places2{3, 4}, Places2{4, 5},
                                 Places2{5, 3}, Places2{0, 3}, Places2{1, 4}, Places2{2, 5}};
constexpr std::array pyramid_edges{Places2{0, 1}, Places2{1, 2}, Places2{2, 3}, Places2{3, 0},
                                   Places2{0, 4}, Places2{1, 4}, Places2{2, 4}, Places2{3, 4}};

constexpr std::array tetrahedron_faces{Places4{0, 2, 1, none}, Places4{0, 1, 3, none}, Places4{1, 2, 3, none},
                                       Places4{2, 0, 3, none}};
constexpr std::array hexahedron_faces{Places4{0, 3, 2, 1}, Places4{4, 5, 6, 7}, Places4{0, 1, 5, 4},
                                      Places4{1, 2, 6, 5}, Places4{2, 3, 7, 6}, Places4{3, 0, 4, 7}};
constexpr std::array wedge_faces{Places4{0, 2, 1, none}, Places4{3, 4, 5, none}, Places4{0, 1, 4, 3},
                                 Places4{1, 2, 5, 4}, Places4{2, 0, 3, 5}};
constexpr std::array pyramid_faces{Places4{0, 3, 2, 1}, Places4{0, 1, 4, none}, Places4{1, 2, 4, none},
                                   Places4{2, 3, 4, none}, Places4{3, 0, 4, none}};

constexpr std::array quadrilateral_diagonals{Places2{0, 2}, Places2{1, 3}};

// Both diagonals of every face of four corners.
template <std::size_t count, std::size_t face_count>
constexpr std::array<Places2, count> diagonals_of(const std::array<Places4, face_count>& faces) {
  std::array<Places2, count> result{};
  std::size_t next = 0;
  for (const Places4& face : faces) {
    if (face[3] == none) continue;
    result[next++] = {face[0], face[2]};
    result[next++] = {face[1], face[3]};
  }
  return result;
}
constexpr auto hexahedron_face_diagonals = diagonals_of<12>(hexahedron_faces);
constexpr auto wedge_face_diagonals = diagonals_of<6>(wedge_faces);
constexpr auto pyramid_face_diagonals = diagonals_of<2>(pyramid_faces);
constexpr std::array hexahedron_space_diagonals{Places2{0, 6}, Places2{1, 7}, Places2{2, 4}, Places2{3, 5}};

constexpr std::array<Places4, 1> tetrahedron_itself{Places4{0, 1, 2, 3}};
// Six around the diagonal from corner 0 to 6.
constexpr std::array hexahedron_tetrahedra{Places4{0, 1, 2, 6}, Places4{0, 2, 3, 6}, Places4{0, 3, 7, 6},
                                           Places4{0, 7, 4, 6}, Places4{0, 4, 5, 6}, Places4{0, 5, 1, 6}};
constexpr std::array wedge_tetrahedra{Places4{0, 1, 2, 5}, Places4{0, 1, 5, 4}, Places4{0, 4, 5, 3}};
constexpr std::array pyramid_tetrahedra{Places4{0, 1, 2, 4}, Places4{0, 2, 3, 4}};

struct CellInfo {
  std::string_view name;
  std::size_t corners;
  int dimension;
  std::span<const Places2> edges{}, face_diagonals{}, space_diagonals{};
  std::span<const Places4> faces{}, tetrahedra{};
};

// By CellType.
constexpr std::array<CellInfo, 8> infos{
    CellInfo{"vertex", 1, 0},
    {"line", 2, 1, line_edges},
    {"triangle", 3, 2, triangle_edges},
    {"quadrilateral", 4, 2, quadrilateral_edges, quadrilateral_diagonals},
    {"tetrahedron", 4, 3, tetrahedron_edges, {}, {}, tetrahedron_faces, tetrahedron_itself},
    {"hexahedron", 8, 3, hexahedron_edges, hexahedron_face_diagonals, hexahedron_space_diagonals, hexahedron_faces,
     hexahedron_tetrahedra},
    {"wedge", 6, 3, wedge_edges, wedge_face_diagonals, {}, wedge_faces, wedge_tetrahedra},
    {"pyramid", 5, 3, pyramid_edges, pyramid_face_diagonals, {}, pyramid_faces, pyramid_tetrahedra}};

const CellInfo& info(CellType type) noexcept { return infos[static_cast<std::size_t>(type)]; }

}  // namespace

std::size_t corner_count(CellType type) noexcept { return info(type).corners; }
int dimension_of(CellType type) noexcept { return info(type).dimension; }
std::string_view name_of(CellType type) noexcept { return info(type).name; }
std::span<const Places2> edge_places(CellType type) noexcept { return info(type).edges; }
std::span<const Places2> face_diagonal_places(CellType type) noexcept { return info(type).face_diagonals; }
std::span<const Places2> space_diagonal_places(CellType type) noexcept { return info(type).space_diagonals; }

namespace meshes {

std::span<const Places4> face_places(CellType type) noexcept { return info(type).faces; }
std::span<const Places4> tetrahedron_places(CellType type) noexcept { return info(type).tetrahedra; }

FaceKey face_key(std::span<const std::uint32_t> corners) {
  FaceKey key{no_point, no_point, no_point, no_point};
  std::copy(corners.begin(), corners.end(), key.begin());
  std::sort(key.begin(), key.end());
  return key;
}

FaceKey face_key(std::span<const std::uint32_t> cell, const Places4& places) {
  FaceKey key{no_point, no_point, no_point, no_point};
  for (std::size_t k = 0; k < 4 && places[k] != no_corner; ++k) key[k] = cell[places[k]];
  std::sort(key.begin(), key.end());
  return key;
}

double tetrahedron_volume(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const Vector3 u = b - a, v = c - a, w = d - a;
  return (u.x() * (v.y() * w.z() - v.z() * w.y()) + u.y() * (v.z() * w.x() - v.x() * w.z()) +
          u.z() * (v.x() * w.y() - v.y() * w.x())) /
         6.0;
}

double solid_volume(const Mesh& mesh, std::size_t cell) {
  const auto corners = mesh.cell(cell);
  const Vector3& origin = mesh.points[corners[0]];
  double sum = 0.0;  // divergence theorem: tetrahedra from `origin` to the triangles of the faces
  for (const Places4& face : face_places(mesh.types[cell])) {
    const auto p = [&](std::size_t k) -> const Vector3& { return mesh.points[corners[face[k]]]; };
    if (face[3] == no_corner) {
      sum += tetrahedron_volume(origin, p(0), p(1), p(2));
    } else {
      sum += 0.5 * (tetrahedron_volume(origin, p(0), p(1), p(2)) + tetrahedron_volume(origin, p(0), p(2), p(3)) +
                    tetrahedron_volume(origin, p(0), p(1), p(3)) + tetrahedron_volume(origin, p(1), p(2), p(3)));
    }
  }
  return sum;
}

}  // namespace meshes
}  // namespace springnet
