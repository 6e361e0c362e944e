#include <cmath>
#include <numeric>
#include <string>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/material.hpp>

using namespace springnet;

namespace {

// A tetrahedron of volume 1/6 with one of its faces, one of its edges and a triangle of area 1/2 beside it.
Mesh mixed() {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0}};
  const auto add = [&](CellType type, std::vector<std::uint32_t> points) { mesh.add_cell(type, points); };
  add(CellType::triangle, {2, 1, 0});
  add(CellType::tetrahedron, {0, 1, 2, 3});
  add(CellType::line, {3, 1});
  add(CellType::triangle, {1, 4, 2});
  add(CellType::line, {4, 0});
  add(CellType::vertex, {3});
  return mesh;
}

std::string refusal(const Mesh& mesh, double density, const Section& section) {
  try {
    static_cast<void>(masses_of(mesh, density, section));
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("faces and edges of other cells have no mass") {
  CHECK(bearing_cells(mixed()) == std::vector<std::size_t>{1, 3, 4});
}

TEST_CASE("each cell gives its corners equal parts") {
  const std::vector<double> masses = masses_of(mixed(), 12.0, {.thickness = 0.5, .cross_section = 0.25});
  // The solid 2 kg, the triangle 3 kg, the line of 2 m 6 kg.
  const std::vector<double> expected{0.5 + 3, 0.5 + 1, 0.5 + 1, 0.5, 1 + 3};
  for (std::size_t k = 0; k < expected.size(); ++k) CHECK(masses[k] == doctest::Approx(expected[k]).epsilon(1e-14));
}

TEST_CASE("all kinds of cells") {
  Lattice lattice;
  lattice.nodes = {3, 2, 4};
  lattice.spacing = {0.5, 2.0, 1.0};
  const std::vector<double> masses = masses_of(mesh_of(lattice), 8.0, {});
  CHECK(std::accumulate(masses.begin(), masses.end(), 0.0) == doctest::Approx(8.0 * 1 * 2 * 3).epsilon(1e-14));
  CHECK(masses[0] == doctest::Approx(1.0).epsilon(1e-14));  // the corner of one cell of 1 m^3
  lattice.nodes = {3, 1, 4};
  CHECK(masses_of(mesh_of(lattice), 8.0, {.thickness = 0.1})[0] == doctest::Approx(8 * 0.5 * 0.1 / 4).epsilon(1e-14));
  lattice.nodes = {1, 1, 4};
  CHECK(masses_of(mesh_of(lattice), 8.0, {.cross_section = 0.1})[0] == doctest::Approx(0.4).epsilon(1e-14));
}

TEST_CASE("missing keys are named") {
  CHECK(refusal(mixed(), 0.0, {}).find("density") != std::string::npos);
  CHECK(refusal(mixed(), 1.0, {.cross_section = 1.0}).find("triangle 3 has no volume without a thickness") !=
        std::string::npos);
  CHECK(refusal(mixed(), 1.0, {.thickness = 1.0}).find("line 4 has no volume without a cross section") !=
        std::string::npos);
  CHECK(refusal(mixed(), 1.0, {.thickness = -1.0, .cross_section = 1.0}).find("above 0") != std::string::npos);
  Mesh mesh = mixed();
  mesh.points.emplace_back(7, 8, 9);
  CHECK(refusal(mesh, 1.0, {.thickness = 1.0, .cross_section = 1.0}).find("point 5 at [7, 8, 9]") != std::string::npos);
}
