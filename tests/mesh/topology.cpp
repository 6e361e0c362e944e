// Edges, surfaces, hinges and volumes of meshes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

#include <springnet/error.hpp>

#include "samples.hpp"

namespace springnet::testing {
namespace {

Mesh body() {
  Mesh mesh;
  mesh.points = body_points();
  for (const SampleCell& cell : body_cells()) mesh.add_cell(cell.type, cell.points);
  return mesh;
}

// Coordinates are small whole numbers and halves: sums of products are exact but for the last digits of a sixth.
constexpr double rounding = 1e-14;

TEST_CASE("edges and diagonals of a body") {
  const Mesh mesh = body();
  const std::vector<Edge> edges = edges_of(mesh);
  // Euler: 12 points, and a surface of 6 quadrilaterals and 8 triangles has 12 + 14 - 2 = 24 edges, none is inside.
  CHECK(edges.size() == 24);
  CHECK(std::is_sorted(edges.begin(), edges.end()));
  CHECK(std::adjacent_find(edges.begin(), edges.end()) == edges.end());
  CHECK(std::all_of(edges.begin(), edges.end(), [](const Edge& edge) { return edge.first < edge.second; }));
  // Quadrilaterals: 6 outside, 2 between cells; two diagonals each.
  CHECK(edges_of(mesh, {.face_diagonals = true}).size() == 24 + 16);
  CHECK(edges_of(mesh, {.space_diagonals = true}).size() == 24 + 4);
  CHECK(edges_of(mesh, {.face_diagonals = true, .space_diagonals = true}).size() == 24 + 20);
}

TEST_CASE("all pairs of corners are edges or diagonals") {
  // Wedges and pyramids have no others; so have a tetrahedron, a hexahedron with its space diagonals.
  for (const CellType type : {CellType::vertex, CellType::line, CellType::triangle, CellType::quadrilateral,
                              CellType::tetrahedron, CellType::hexahedron, CellType::wedge, CellType::pyramid}) {
    CAPTURE(name_of(type));
    const std::size_t n = corner_count(type);
    CHECK(edge_places(type).size() + face_diagonal_places(type).size() + space_diagonal_places(type).size() ==
          n * (n - 1) / 2);
    Mesh mesh;
    mesh.points.resize(n);
    std::vector<std::uint32_t> corners(n);
    std::iota(corners.begin(), corners.end(), 0U);
    mesh.add_cell(type, corners);
    CHECK(edges_of(mesh, {.face_diagonals = true, .space_diagonals = true}).size() == n * (n - 1) / 2);
  }
}

TEST_CASE("the surface of a body is closed, outward, and encloses its volume") {
  Mesh mesh = body();
  for (const bool inside_out : {false, true}) {
    CAPTURE(inside_out);
    if (inside_out) {  // mirrored cells: the same points in an order that inverts them
      for (std::size_t cell = 0; cell < 4; ++cell) {
        std::uint32_t* corners = mesh.corners.data() + mesh.offsets[cell];
        if (mesh.types[cell] == CellType::hexahedron) std::swap_ranges(corners, corners + 4, corners + 4);
        if (mesh.types[cell] == CellType::wedge) std::swap_ranges(corners, corners + 3, corners + 3);
        if (mesh.types[cell] == CellType::pyramid) std::swap(corners[1], corners[3]);
        if (mesh.types[cell] == CellType::tetrahedron) std::swap(corners[0], corners[1]);
      }
    }
    const std::vector<Face> surface = surface_of(mesh);
    CHECK(surface.size() == 20);  // and not the quadrilateral on the bottom
    CHECK(is_closed(surface));
    CHECK(euler_characteristic(surface) == 2);
    CHECK(std::abs(enclosed_volume(mesh, surface) - 2.0) < rounding);
    CHECK(std::abs(volume_of(mesh) - 2.0) < rounding);
    // Four sides of the cube, the wedge's 1 + sqrt(2) + 1, three of the pyramid, three of the tetrahedron.
    const double pyramid_side = 0.5 * std::sqrt(1.25);
    const double at_tip = 0.5 * std::sqrt(1.0 + 0.25 + 0.5625);  // |(1/2, 1/2, 1) x (1/2, -1, 0)| / 2
    CHECK(area_of(mesh, surface) == doctest::Approx(4 + 2 + std::sqrt(2.0) + 3 * pyramid_side + 0.5 + 2 * at_tip));
    const auto tetrahedra = tetrahedra_of(mesh);
    CHECK(tetrahedra.size() == 6 + 3 + 2 + 1);
    Mesh divided;
    divided.points = mesh.points;
    for (const auto& nodes : tetrahedra) {
      const auto p = [&](std::size_t k) -> const Vector3& { return mesh.points[nodes[k]]; };
      CHECK((p(1) - p(0)).dot((p(2) - p(0)).cross(p(3) - p(0))) > 0.0);
      divided.add_cell(CellType::tetrahedron, nodes);
    }
    CHECK(std::abs(volume_of(divided) - 2.0) < rounding);
    CHECK(oriented(surface, mesh.points) == surface);
  }
}

TEST_CASE("the volume of a hexahedron with curved faces does not depend on its numbering") {
  Mesh mesh;
  for (const double z : {0.0, 1.0}) {
    mesh.points.insert(mesh.points.end(), {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}});
  }
  mesh.points[6].z() = 1.6;  // the top is the bilinear patch z = 1 + 0.6 x y, under which is 1 + 0.6 / 4
  mesh.add_cell(CellType::hexahedron, std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7});
  mesh.add_cell(CellType::hexahedron, std::vector<std::uint32_t>{1, 2, 3, 0, 5, 6, 7, 4});
  mesh.add_cell(CellType::hexahedron, std::vector<std::uint32_t>{4, 5, 6, 7, 0, 1, 2, 3});
  for (std::size_t cell = 0; cell < 3; ++cell) CHECK(std::abs(measure_of(mesh, cell) - 1.15) < rounding);
}

TEST_CASE("measures of lines and surface cells") {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {3, 4, 0}, {0, 2, 0}, {-1, 0, 0}, {0, 0.5, 0}, {1, 0, 0}};
  mesh.add_cell(CellType::line, std::vector<std::uint32_t>{0, 1});
  mesh.add_cell(CellType::triangle, std::vector<std::uint32_t>{0, 5, 2});
  mesh.add_cell(CellType::quadrilateral,
                std::vector<std::uint32_t>{3, 4, 5, 2});  // an arrow: concave at its second corner
  mesh.add_cell(CellType::vertex, std::vector<std::uint32_t>{0});
  CHECK(measure_of(mesh, 0) == 5.0);
  CHECK(measure_of(mesh, 1) == 1.0);
  CHECK(measure_of(mesh, 2) == 1.5);  // a triangle of base 2 and height 2 without one of height 1/2
  CHECK(measure_of(mesh, 3) == 0.0);
  CHECK_THROWS_AS(mesh.add_cell(CellType::line, std::vector<std::uint32_t>{0}), Error);
}

TEST_CASE("quadrilaterals are divided along their shorter diagonal") {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 1, 0}};
  for (const std::vector<std::uint32_t>& corners : {std::vector<std::uint32_t>{0, 1, 2, 3}, {1, 2, 3, 0}}) {
    mesh.types.clear();
    mesh.corners.clear();
    mesh.offsets = {0};
    mesh.add_cell(CellType::quadrilateral, corners);
    const std::vector<Face> faces = surface_of(mesh);
    REQUIRE(faces.size() == 2);
    for (const Face& face : faces) {  // points 1 and 3 are in both
      CHECK(std::count(face.begin(), face.end(), 1U) == 1);
      CHECK(std::count(face.begin(), face.end(), 3U) == 1);
    }
    CHECK(area_of(mesh, faces) == doctest::Approx(2.0));
    CHECK(oriented(faces, mesh.points) == faces);
  }
}

TEST_CASE("surfaces are oriented so that neighbours agree and closed parts point outward") {
  const Mesh mesh = body();
  const std::vector<Face> surface = surface_of(mesh);
  std::vector<Face> faces = surface;
  for (std::size_t i = 0; i < faces.size(); i += 3) std::swap(faces[i][0], faces[i][1]);
  CHECK(enclosed_volume(mesh, oriented(faces, mesh.points)) == doctest::Approx(2.0));
  std::vector<Face> all_inward = surface;
  for (Face& face : all_inward) std::swap(face[0], face[1]);
  CHECK(enclosed_volume(mesh, oriented(all_inward, mesh.points)) == doctest::Approx(2.0));
  CHECK(oriented({}, mesh.points).empty());

  // A sheet of two triangles keeps the orientation of the first.
  const std::vector<Face> sheet{{0, 2, 1}, {0, 2, 3}};
  CHECK(oriented(sheet, mesh.points) == std::vector<Face>{{0, 2, 1}, {0, 3, 2}});
  CHECK(!is_closed(sheet));
  CHECK(!is_closed({}));

  // A ring of 5 triangles is a Moebius strip: i, i + 1, i + 2 modulo 5.
  std::vector<Face> strip;
  for (std::uint32_t i = 0; i < 5; ++i) strip.push_back({i, (i + 1) % 5, (i + 2) % 5});
  CHECK_THROWS_WITH_AS(static_cast<void>(oriented(strip, mesh.points)), doctest::Contains("Moebius"), Error);
  CHECK_THROWS_WITH_AS(static_cast<void>(oriented({{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}, mesh.points)),
                       doctest::Contains("point 0 to point 1"), Error);
  CHECK_THROWS_WITH_AS(static_cast<void>(oriented({{0, 1, 99}}, mesh.points)), doctest::Contains("has point 99"),
                       Error);
  CHECK_THROWS_WITH_AS(static_cast<void>(oriented({{0, 1, 1}}, mesh.points)), doctest::Contains("twice"), Error);
}

TEST_CASE("hinges have the nodes of a dihedral angle in its order") {
  const Mesh mesh = body();
  const std::vector<Face> surface = surface_of(mesh);
  const auto hinges = hinges_of(surface);
  CHECK(hinges.size() == 30);  // closed: 3/2 a triangle
  Network network;
  for (const Vector3& point : mesh.points) network.add_node({.position = point});
  std::size_t flat = 0, right = 0;
  for (const auto& [a, b, c, d] : hinges) {
    // (a, b, c) and (b, a, d) are triangles of the surface with its orientation.
    const auto has = [&](std::array<std::uint32_t, 3> wanted) {
      for (int k = 0; k < 3; ++k) {
        if (std::find(surface.begin(), surface.end(), wanted) != surface.end()) return true;
        std::rotate(wanted.begin(), wanted.begin() + 1, wanted.end());
      }
      return false;
    };
    CHECK(has({a, b, c}));
    CHECK(has({b, a, d}));
    const double angle = network.value_of({Invariant::dihedral, {a, b, c, d}, 0, 0.0});
    flat += std::abs(angle) < 1e-12 ? 1 : 0;  // the angle of exact coordinates, but for rounding
    right += std::abs(std::abs(angle) - std::acos(0.0)) < 1e-12 ? 1 : 0;
  }
  // Flat: across the diagonals of 6 quadrilaterals; at the bottom and at both sides, where wedge and cube go on.
  CHECK(flat == 6 + 3);
  CHECK(right >= 6);
  CHECK(hinges_of(std::vector<Face>{{0, 1, 2}}).empty());
  CHECK(hinges_of(std::vector<Face>{{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}).empty());
}

TEST_CASE("surface cells beside solid ones belong to the surface, those between solid ones do not") {
  Mesh mesh = body();
  mesh.add_cell(CellType::triangle, std::vector<std::uint32_t>{9, 10, 12});        // a fin
  mesh.add_cell(CellType::quadrilateral, std::vector<std::uint32_t>{6, 5, 1, 2});  // between cube and wedge
  const std::vector<Face> surface = surface_of(mesh);
  REQUIRE(surface.size() == 21);
  CHECK(surface.back() == Face{9, 10, 12});
}

}  // namespace
}  // namespace springnet::testing
