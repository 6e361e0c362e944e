// Elements of a scene: which they are, and what is wrong with them.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <springnet/mesh.hpp>

#include "facts.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using springnet::testing::has_facts;

namespace {

const std::string springs =
    "neuron = { type = \"point_mass\", mass = 1.0 }\nspring = { type = \"linear\", stiffness = 1.0 }\n";
// Ten lines; a solid bar, and a sheet of 3 x 3 nodes above it.
const std::string bodies =
    simulation + "[[body]]\nname = \"bar\"\nmesh = { file = \"bar.msh\", scale = 0.001 }\n" + springs +
    "[[body]]\nname = \"sheet\"\nmesh = { lattice = [3, 3, 1], spacing = 1.0, origin = [0, 0, 9] }\n" + springs;
const std::string law = "spring = { type = \"linear\", stiffness = 2.0 }\n";

std::string element(const std::string& keys) { return bodies + "[[element]]\n" + law + keys + "\n"; }

double sum(const Network& network) {
  double result = 0;
  for (const Element& e : network.elements()) result += e.reference;
  return result;
}

}  // namespace

TEST_CASE("elements of selections") {
  const Network areas = parse(element("invariant = \"area\"\nselect = { body = \"bar\" }")).network;
  CHECK(areas.elements().size() == areas.bodies()[0].face_count);
  // The surface of the bar; the sums of this file are of some hundred numbers, each rounded.
  CHECK(sum(areas) == doctest::Approx(2 * (0.02 * 0.02 + 2 * 0.1 * 0.02)).epsilon(1e-12));
  CHECK(areas.elements()[0].invariant == Invariant::area);
  CHECK(areas.materials()[areas.elements()[0].material].spring->parameters.at("stiffness") == 2.0);

  const Network end = parse(element("invariant = \"area\"\nselect = { group = \"left\" }")).network;
  CHECK(sum(end) == doctest::Approx(0.02 * 0.02).epsilon(1e-12));

  const Network volumes = parse(element("invariant = \"volume\"\nselect = {}")).network;
  CHECK(volumes.elements().size() == tetrahedra_of(read_mesh(std::filesystem::path(SCENE_FOLDER) / "bar.msh")).size());
  CHECK(sum(volumes) == doctest::Approx(0.1 * 0.02 * 0.02).epsilon(1e-12));

  const Network filling =
      parse(element("invariant = \"enclosed_volume\"\nselect = { body = \"bar\" }\nreference_scale = 1.5")).network;
  REQUIRE(filling.elements().size() == 1);
  CHECK(filling.elements()[0].reference == doctest::Approx(1.5 * 0.1 * 0.02 * 0.02).epsilon(1e-12));

  // The sheet: four inner edges and four diagonals are hinges.
  const Network hinges = parse(element("invariant = \"dihedral\"\nselect = { body = \"sheet\" }")).network;
  CHECK(hinges.elements().size() == 8);
  for (const Element& hinge : hinges.elements()) CHECK(hinge.reference == 0.0);  // flat
}

TEST_CASE("of a group those triangles and cells that are in it, not all between its nodes") {
  // The unit cube, 3 x 3 x 3 divided, of tetrahedra; the group wall is its sides x = 0, y = 0 and z = 0: 54 triangles.
  // Three triangles of the other sides have all of their corners on these.
  const auto box = [](const std::string& invariant, const std::string& selection) {
    return parse(simulation + "[[body]]\nname = \"box\"\nmesh = { file = \"box.msh\" }\n" + springs +
                 "[[element]]\ninvariant = \"" + invariant + "\"\nselect = " + selection + "\n" + law)
        .network;
  };
  const Network walls = box("area", "{ group = \"wall\" }");
  CHECK(walls.elements().size() == 54);
  CHECK(sum(walls) == doctest::Approx(3.0).epsilon(1e-12));
  for (const Element& e : walls.elements()) {
    const auto at_0 = [&](Eigen::Index axis) {
      return std::all_of(e.nodes.begin(), e.nodes.end(),
                         [&](NodeIndex k) { return std::abs(walls.nodes()[k].position[axis]) < 1e-12; });
    };
    CHECK((at_0(0) || at_0(1) || at_0(2)));
  }
  // Three sides of a triangle each, but for the rim of six times three edges.
  CHECK(box("dihedral", "{ group = \"wall\" }").elements().size() == (3 * 54 - 18) / 2);
  CHECK(box("area", "{ group = \"wall\", box = { max = [0, 1, 1] } }").elements().size() == 18);
  CHECK(box("volume", "{ group = \"v\" }").elements().size() == 162);
  // A group of solid cells has no triangles: those between its nodes.
  CHECK(box("area", "{ group = \"v\" }").elements().size() == 108);
  CHECK(box("area", "{ group = [\"wall\", \"v\"] }").elements().size() == 108);
  const Network filling = box("enclosed_volume", "{ group = \"v\" }");
  REQUIRE(filling.elements().size() == 1);
  CHECK(sum(filling) == doctest::Approx(1.0).epsilon(1e-12));
}

TEST_CASE("groups of quadrilaterals, of solid cells and of points") {
  // Cubes in a row along x; the first and the last one are of one material, so are the quadrilaterals below these. All
  // nodes of the middle one are theirs too.
  std::string points, groups;
  for (int k = 0; k < 16; ++k) {
    points += fmt::format("{} {} {}\n", k / 4, k % 2, k / 2 % 2);
    groups += k < 8 ? "5 " : "6 ";
  }
  std::string cells;
  for (int c = 0; c < 12; c += 4) {
    cells += fmt::format("8 {} {} {} {} {} {} {} {}\n", c, c + 4, c + 5, c + 1, c + 2, c + 6, c + 7, c + 3);
  }
  for (int c = 0; c < 12; c += 4) cells += fmt::format("4 {} {} {} {}\n", c, c + 1, c + 5, c + 4);
  const testing::TemporaryFolder folder;
  folder.write("row.vtk", "# vtk DataFile Version 3.0\nrow\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 16 double\n" +
                              points + "CELLS 6 42\n" + cells +
                              "CELL_TYPES 6\n12 12 12 9 9 9\nCELL_DATA 6\nSCALARS material int\nLOOKUP_TABLE "
                              "default\n1 2 1 3 4 3\nPOINT_DATA 16\nSCALARS group int\nLOOKUP_TABLE default\n" +
                              groups + "\n");
  const auto row = [&](const std::string& invariant, const std::string& group) {
    return parse_scene(simulation + "[[body]]\nname = \"row\"\nmesh = { file = \"row.vtk\", origin = [7, 0, 0] }\n" +
                           springs + "[[body]]\nname = \"other\"\nmesh = { file = \"row.vtk\" }\n" + springs +
                           "[[element]]\ninvariant = \"" + invariant + "\"\nselect = { body = \"other\", group = \"" +
                           group + "\" }\n" + law,
                       "test.toml", plugins(), {}, folder.path())
        .network;
  };
  const Network squares = row("area", "material 3");
  for (const Element& e : squares.elements()) CHECK(e.nodes[0] >= 16);
  CHECK(squares.elements().size() == 4);  // two halves of two squares
  CHECK(sum(squares) == doctest::Approx(2.0).epsilon(1e-14));
  CHECK(sum(row("volume", "material 1")) == doctest::Approx(2.0).epsilon(1e-14));
  CHECK(sum(row("volume", "material 2")) == doctest::Approx(1.0).epsilon(1e-14));
  // Of the first cube all sides but that to the next one.
  CHECK(sum(row("area", "group 5")) == doctest::Approx(5.0).epsilon(1e-14));
  CHECK(sum(row("volume", "group 5")) == doctest::Approx(1.0).epsilon(1e-14));
}

TEST_CASE("the solid cells of a lattice are tetrahedra of their whole volume") {
  const Network network = parse(small + "[[element]]\ninvariant = \"volume\"\nselect = {}\n" + law).network;
  CHECK(sum(network) == doctest::Approx(8.0).epsilon(1e-14));
  CHECK(network.elements().size() == 8 * 6);
}

TEST_CASE("the cavity of a solid has a volume above 0, though the solid's surface is turned into it") {
  // 3 x 3 x 3 cubes without the middle one, in VTK's legacy format.
  std::string points, cells, types;
  for (int k = 0; k < 64; ++k) points += fmt::format("{} {} {}\n", k % 4, k / 4 % 4, k / 16);
  for (int c = 0; c < 27; ++c) {
    if (c == 13) continue;
    const int n = c % 3 + 4 * (c / 3 % 3) + 16 * (c / 9);
    cells += fmt::format("8 {} {} {} {} {} {} {} {}\n", n, n + 1, n + 5, n + 4, n + 16, n + 17, n + 21, n + 20);
    types += "12\n";
  }
  const testing::TemporaryFolder folder;
  folder.write("hollow.vtk",
               "# vtk DataFile Version 3.0\nhollow\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 64 double\n" + points +
                   "CELLS 26 234\n" + cells + "CELL_TYPES 26\n" + types);
  const auto volume = [&](const std::string& selection) {
    const Scene scene =
        parse_scene(simulation + "[[body]]\nname = \"b\"\nmesh = { file = \"hollow.vtk\" }\n" + springs +
                        "[[element]]\ninvariant = \"enclosed_volume\"\nselect = " + selection + "\n" + law,
                    "test.toml", plugins(), {}, folder.path());
    REQUIRE(scene.network.elements().size() == 1);
    return scene.network.elements()[0].reference;
  };
  CHECK(volume("{ box = { min = [1, 1, 1], max = [2, 2, 2] } }") == doctest::Approx(1.0).epsilon(1e-14));
  CHECK(volume("{}") == doctest::Approx(26.0).epsilon(1e-14));
}

TEST_CASE("angles at nodes of chains") {
  const std::string chain = simulation + "[[body]]\nname = \"y\"\n" +
                            "nodes = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [3, 1, 0], [2, 2, 0]]\n" +
                            "springs = [[1, 0], [1, 2], [2, 3], [3, 4], [3, 5]]\n" + springs;
  const Network network = parse(chain + "[[element]]\ninvariant = \"angle\"\nselect = {}\n" + law).network;
  REQUIRE(network.elements().size() == 2);  // node 3 has three springs, the ends one
  CHECK(network.elements()[0].nodes == std::vector<NodeIndex>{0, 1, 2});
  CHECK(network.elements()[0].reference == doctest::Approx(std::numbers::pi).epsilon(1e-15));
  CHECK(network.elements()[1].nodes == std::vector<NodeIndex>{1, 2, 3});
  CHECK(network.elements()[1].reference == doctest::Approx(std::numbers::pi / 2).epsilon(1e-15));
  const Network one =
      parse(chain + "[[element]]\ninvariant = \"angle\"\nselect = { nodes = [2] }\nreference = 3.0\n" + law).network;
  REQUIRE(one.elements().size() == 1);
  CHECK(one.elements()[0].reference == 3.0);
}

TEST_CASE("elements by their nodes, numbered in the order of the tables, with names") {
  const Scene scene =
      parse(element("name = \"one\"\ninvariant = \"area\"\nbody = \"sheet\"\nnodes = [[0, 1, 3], [1, 2, 4]]") +
            "[[element]]\nname = \"two\"\ninvariant = \"volume\"\nnodes = [[0, 1, 2, 3]]\n" + law +
            "viscosity = { type = \"linear\", damping = 3.0 }\n");
  const NodeIndex first = scene.network.bodies()[1].first_node;
  REQUIRE(scene.network.elements().size() == 3);
  CHECK(scene.network.elements()[1].nodes == std::vector<NodeIndex>{first + 1, first + 2, first + 4});
  CHECK(scene.network.elements()[0].reference == 0.5);
  CHECK(scene.network.elements()[2].nodes == std::vector<NodeIndex>{0, 1, 2, 3});
  CHECK(scene.network.materials()[scene.network.elements()[2].material].viscosity.has_value());
  REQUIRE(scene.elements.size() == 2);
  CHECK(scene.elements[0].name == "one");
  CHECK(scene.elements[0].count == 2);
  CHECK(scene.elements[1].first == 2);
}

TEST_CASE("errors of an element name its place") {
  const auto refused = [](const std::string& keys) { return refusal(element(keys)); };
  // Line 14 is [[element]], 15 its law.
  CHECK(has_facts(refused("invariant = \"angel\"\nselect = {}"),
                  "test.toml:16:13: element.0.invariant: | 'angle' | 'angel'"));
  CHECK(has_facts(refused("invariant = \"area\""), "element.0: | 'select' | 'nodes'"));
  CHECK(has_facts(refused("invariant = \"area\"\nselect = {}\nnodes = []"), "element.0: | 'select' | 'nodes'"));
  CHECK(has_facts(refused("invariant = \"area\"\nselect = {}\nbody = \"bar\""), "requires 'nodes'"));
  CHECK(has_facts(refused("invariant = \"area\"\nnodes = []"), "element.0.nodes: "));
  CHECK(has_facts(refused("invariant = \"area\"\nnodes = [[0, 1, 9999]]"),
                  "test.toml:17:17: element.0.nodes.0.2: | node 9999"));
  CHECK(
      has_facts(refused("invariant = \"area\"\nnodes = [[0, 1, 2], [0, 1]]"), "test.toml:17:21: element.0.nodes.1: "));
  CHECK(has_facts(refused("invariant = \"area\"\nselect = {}\nreference = 1\nreference_scale = 1"),
                  "element.0.reference_scale: | 'reference'"));
  CHECK(has_facts(refused("invariant = \"angle\"\nselect = { body = \"bar\" }"), "element.0.select: | two springs"));
  CHECK(has_facts(refused("invariant = \"volume\"\nselect = { body = \"sheet\" }"), "element.0.select: | solid cell"));
  CHECK(has_facts(refused("invariant = \"area\"\nselect = { nodes = [0] }"), "element.0.select: | triangle"));
  CHECK(has_facts(refusal(bodies + "[[element]]\ninvariant = \"area\"\nselect = {}\n"),
                  "element.0: | 'spring' | 'viscosity'"));
  CHECK(has_facts(refused("name = \"a\"\ninvariant = \"area\"\nselect = {}\n[[element]]\nname = \"a\"\ninvariant = "
                          "\"area\"\nselect = {}\n" +
                          law),
                  "element.1.name: | [[element]]"));
  // Half of the bar's surface has an open rim.
  const std::string open =
      refused("invariant = \"enclosed_volume\"\nselect = { body = \"bar\", box = { max = [0.06, inf, inf] } }");
  CHECK(has_facts(open, "test.toml:17:10: element.0.select: | open | edge"));
  CHECK(has_facts(refused("invariant = \"enclosed_volume\"\nselect = { body = \"sheet\" }"), "open | [0, 0, 9]"));
}
