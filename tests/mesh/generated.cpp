// Meshes that Gmsh generates: the same geometry in each format, with the measures of the closed form.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include <fmt/format.h>

#include "samples.hpp"

namespace springnet::testing {
namespace {

const double pi = std::acos(-1.0);

// Runs Gmsh on a geometry, to one file for each of the given options and names.
void run_gmsh(const TemporaryFolder& folder, const std::string& geometry, const std::string& options,
              const std::string& file) {
  folder.write("body.geo", geometry);
  const std::string command = fmt::format("cd '{}' && '{}' body.geo {} -o {} -v 1 -nt 1 > log 2>&1",
                                          folder.path().string(), GMSH, options, file);
  const int status = std::system(command.c_str());
  INFO(read_text(folder.path() / "log"));
  REQUIRE(status == 0);
}

constexpr const char* ball = R"(
SetFactory("OpenCASCADE");
Sphere(1) = {1, 2, 3, 0.5};
Physical Volume("ball") = {1};
Physical Surface("skin") = {1};
Mesh.CharacteristicLengthMax = 0.15;
Mesh.CharacteristicLengthMin = 0.15;
)";

TEST_CASE("a ball in each format") {
  const TemporaryFolder folder;
  run_gmsh(folder, ball, "-3 -format msh41", "a.msh");
  run_gmsh(folder, ball, "-3 -format msh41 -bin", "b.msh");
  run_gmsh(folder, ball, "-3 -format msh40", "c.msh");
  run_gmsh(folder, ball, "-3 -format vtk", "e.vtk");
  run_gmsh(folder, ball, "-3 -format vtk -bin", "f.vtk");
  run_gmsh(folder, ball, "-3 -order 2 -format msh41", "g.msh");
  run_gmsh(folder, ball, "-2 -format stl", "h.stl");
  run_gmsh(folder, ball, "-2 -format stl -bin", "i.stl");

  const Mesh first = read_mesh(folder.path() / "a.msh");
  const std::vector<Face> skin = surface_of(first);
  const double volume = volume_of(first), area = area_of(first, skin);
  // Flat triangles of edge h within a sphere of radius r lie up to h^2 / (6 r) below it (a triangle's circumradius is
  // h / sqrt(3)): volume and area are less than 3 h^2 / (6 r^2) = 4.5 % too small.
  CHECK(volume < pi / 6.0);
  CHECK(volume > 0.955 * pi / 6.0);
  CHECK(area < pi);
  CHECK(area > 0.955 * pi);
  CHECK(is_closed(skin));
  CHECK(euler_characteristic(skin) == 2);
  // Sums of thousands of terms in another order: their rounding, and the 16 digits of a text.
  const double rounding = 1e-12;
  CHECK(std::abs(enclosed_volume(first, skin) - volume) < rounding);

  const MeshGroup& group = group_of(first, "skin");
  std::set<std::uint32_t> of_skin;
  for (const Face& face : skin) of_skin.insert(face.begin(), face.end());
  CHECK(std::vector<std::uint32_t>(of_skin.begin(), of_skin.end()) == group.points);
  CHECK(group_of(first, "ball").points.size() == first.points.size());
  CHECK(group_of(first, "ball").cells.size() + group.cells.size() == first.cell_count());

  for (const char* name : {"b.msh", "c.msh", "e.vtk", "f.vtk", "g.msh"}) {
    CAPTURE(name);
    const Mesh mesh = read_mesh(folder.path() / name);
    CHECK(mesh.points.size() == first.points.size());
    CHECK(edges_of(mesh).size() == edges_of(first).size());
    CHECK(std::abs(volume_of(mesh) - volume) < rounding);
    const std::vector<Face> surface = surface_of(mesh);
    CHECK(surface.size() == skin.size());
    CHECK(std::abs(area_of(mesh, surface) - area) < rounding);
    CHECK(has_note(mesh, "of second or higher order") == (std::string(name) == "g.msh"));
  }
  for (const char* name : {"h.stl", "i.stl"}) {
    CAPTURE(name);
    const Mesh mesh = read_mesh(folder.path() / name);
    CHECK(mesh.points.size() == of_skin.size());
    const std::vector<Face> surface = surface_of(mesh);
    CHECK(surface.size() == skin.size());
    CHECK(is_closed(surface));
    // Coordinates up to 3.5 in single precision are off by 1.2e-7; an area of 3 by some 1e-6.
    CHECK(std::abs(area_of(mesh, surface) - area) < 1e-5);
    CHECK(std::abs(enclosed_volume(mesh, oriented(surface, mesh.points)) - volume) < 1e-5);
  }
}

// Triangles, quadrilaterals, wedges, hexahedra.
constexpr const char* kinds = R"(
SetFactory("OpenCASCADE");
Mesh.MeshSizeMin = 1;
Mesh.MeshSizeMax = 1;
Rectangle(1) = {0, 0, 0, 1, 1};
Rectangle(2) = {5, 0, 0, 1, 1};
Recombine Surface {2};
Transfinite Surface {2};
Rectangle(3) = {10, 0, 0, 1, 1};
Transfinite Surface {3};
a[] = Extrude {0, 0, 1} { Surface{3}; Layers{1}; Recombine; };
Rectangle(50) = {15, 0, 0, 1, 1};
Transfinite Surface {50};
Recombine Surface {50};
b[] = Extrude {0, 0, 1} { Surface{50}; Layers{1}; Recombine; };
)";
// Beside a hexahedron tetrahedra, with a pyramid between them.
constexpr const char* neighbours = R"(
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {1, 0, 0, 1, 1, 1};
Coherence;
Transfinite Curve {:} = 2;
Transfinite Surface {:};
s() = Boundary { Volume{1}; };
Recombine Surface {s()};
Transfinite Volume {1};
)";

std::vector<CellType> sorted(std::vector<CellType> types) {
  std::sort(types.begin(), types.end());
  return types;
}

TEST_CASE("elements of any order are read by their corners") {
  const TemporaryFolder folder;
  std::set<CellType> types;
  for (const char* geometry : {kinds, neighbours}) {
    run_gmsh(folder, geometry, "-3 -format msh41", "order1.msh");
    const Mesh first = read_mesh(folder.path() / "order1.msh");
    types.insert(first.types.begin(), first.types.end());
    CHECK(volume_of(first) == doctest::Approx(2.0).epsilon(1e-12));
    for (const char* order : {"2", "3", "4", "5", "2 -setnumber Mesh.SecondOrderIncomplete 1",
                              "3 -setnumber Mesh.SecondOrderIncomplete 1"}) {
      CAPTURE(geometry);
      CAPTURE(order);
      run_gmsh(folder, geometry, fmt::format("-3 -order {} -format msh41 -bin", order), "higher.msh");
      const Mesh mesh = read_mesh(folder.path() / "higher.msh");
      CHECK(sorted(mesh.types) == sorted(first.types));  // Gmsh may change the order of blocks
      CHECK(mesh.points.size() == first.points.size());
      CHECK(volume_of(mesh) == doctest::Approx(2.0).epsilon(1e-12));
      CHECK(has_note(mesh, "elements of second or higher order"));
    }
  }
  CHECK(types.size() == 8);  // every type
}

constexpr const char* box = R"(
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 2, 3};
Transfinite Curve {:} = 4;
Transfinite Surface {:};
Recombine Surface {:};
Transfinite Volume {1};
)";

TEST_CASE("a box of hexahedra, without physical groups") {
  const TemporaryFolder folder;
  run_gmsh(folder, box, "-3 -format msh41 -bin", "box.msh");
  const Mesh mesh = read_mesh(folder.path() / "box.msh");
  CHECK(mesh.points.size() == 64);
  CHECK(std::count(mesh.types.begin(), mesh.types.end(), CellType::hexahedron) == 27);
  CHECK(std::count(mesh.types.begin(), mesh.types.end(), CellType::quadrilateral) == 54);
  // The paper's cube has these 144 axial springs, and the 252 with the four diagonals through each cell.
  CHECK(edges_of(mesh).size() == 144);
  CHECK(edges_of(mesh, {.space_diagonals = true}).size() == 252);
  CHECK(edges_of(mesh, {.face_diagonals = true}).size() == 144 + 2 * 108);  // 3 times 4 layers of 9 quadrilaterals
  const std::vector<Face> surface = surface_of(mesh);
  CHECK(surface.size() == 108);
  // Coordinates have 16 digits.
  CHECK(std::abs(volume_of(mesh) - 6.0) < 1e-13);
  CHECK(std::abs(area_of(mesh, surface) - 22.0) < 1e-13);
  CHECK(mesh.groups.empty());
}

TEST_CASE("the centre of a circle is not a point of the body") {
  const TemporaryFolder folder;
  run_gmsh(folder, R"(
Point(1) = {0, 0, 0, 0.2}; Point(2) = {1, 0, 0, 0.2}; Point(3) = {-1, 0, 0, 0.2};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 2};
)",
           "-1 -format msh41", "ring.msh");
  const Mesh ring = read_mesh(folder.path() / "ring.msh");
  for (const Vector3& point : ring.points) CHECK(point.norm() == doctest::Approx(1.0));
  CHECK(std::count(ring.types.begin(), ring.types.end(), CellType::line) == static_cast<long>(ring.points.size()));
}

TEST_CASE("a body of some 100,000 tetrahedra") {
  const TemporaryFolder folder;
  run_gmsh(folder, R"(
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Transfinite Curve {:} = 27;
Transfinite Surface {:};
Transfinite Volume {1};
Physical Volume("block") = {1};
)",
           "-3 -format msh41", "block.msh");
  const Mesh mesh = read_mesh(folder.path() / "block.msh");
  CHECK(mesh.points.size() == 27 * 27 * 27);
  CHECK(mesh.cell_count() == 6 * 26 * 26 * 26);  // 105,456
  // As many terms as cells, each rounded to 1e-16 of about 1e-5.
  CHECK(std::abs(volume_of(mesh) - 1.0) < 1e-11);
  const std::vector<Face> surface = surface_of(mesh);
  CHECK(surface.size() == 2 * 6 * 26 * 26);
  CHECK(is_closed(surface));
  // Euler for a ball: points - edges + triangles - tetrahedra = 1; a tetrahedron has four triangles, those inside
  // twice.
  const std::size_t triangles = (4 * mesh.cell_count() + surface.size()) / 2;
  CHECK(edges_of(mesh).size() == mesh.points.size() + triangles - mesh.cell_count() - 1);
}

}  // namespace
}  // namespace springnet::testing
