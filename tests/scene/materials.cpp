// Masses from densities and springs from materials, as a scene says them.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <springnet/material.hpp>

#include "facts.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using springnet::testing::has_facts;

namespace {

std::string body(const std::string& mesh, const std::string& keys, const std::string& neuron = "") {
  return simulation + "[[body]]\nname = \"b\"\n" + mesh + "\nneuron = { type = \"point_mass\"" + neuron + " }\n" +
         keys + "\n";
}
const std::string bar_mesh = "mesh = { file = \"bar.msh\", scale = 0.001 }";
const std::string box_mesh = "mesh = { lattice = [3, 4, 5], spacing = 0.5, diagonals = \"all\" }";
const std::string sheet_mesh = "mesh = { lattice = [3, 4, 1], spacing = 0.5, diagonals = \"face\" }";
const std::string rope = "nodes = [[0, 0, 0], [0, 0, 2], [0, 0, 3]]\nsprings = [[1, 0], [1, 2]]";
const std::string spring = "spring = { type = \"linear\", stiffness = 1.0 }\n";

double mass_of(const std::string& text) {
  const Network network = parse(text).network;
  double sum = 0;
  for (const Node& node : network.nodes()) sum += node.mass;
  return sum;
}

double parameter(const Network& net, std::size_t spring_index, const char* name) {
  return net.materials()[net.springs()[spring_index].material].spring->parameters.at(name);
}

}  // namespace

TEST_CASE("masses from a density") {
  // Sums of some hundred rounded numbers.
  CHECK(mass_of(body(bar_mesh, "density = 1000.0\n" + spring)) == doctest::Approx(0.04).epsilon(1e-12));
  CHECK(mass_of(body(box_mesh, "density = 10.0\n" + spring)) == doctest::Approx(10 * 1.0 * 1.5 * 2.0).epsilon(1e-12));
  CHECK(mass_of(body(sheet_mesh, "density = 10.0\nthickness = 0.1\n" + spring)) == doctest::Approx(1.5).epsilon(1e-12));
  const Network net = parse(body(rope, "density = 10.0\ncross_section = 0.1\n" + spring)).network;
  CHECK(net.nodes()[0].mass == doctest::Approx(1.0));
  CHECK(net.nodes()[1].mass == doctest::Approx(1.5));
  CHECK(net.nodes()[2].mass == doctest::Approx(0.5));
}

TEST_CASE("each spring gets the stiffness of its edge, and its share of damping") {
  const std::string keys =
      "density = 1.0\nmaterial = { youngs_modulus = 1e4, damping_time = 0.01, law = { type = "
      "\"nonlinear\", cubic = 7.0 } }";
  const Network net = parse(body(bar_mesh, keys)).network;
  Mesh mesh = read_mesh(std::filesystem::path(SCENE_FOLDER) / "bar.msh");
  for (Vector3& point : mesh.points) point *= 0.001;
  const NetStiffness expected = stiffness_of(mesh, edges_of(mesh), 1e4, {});
  REQUIRE(expected.stiffness.size() == net.springs().size());
  for (std::size_t k = 0; k < expected.stiffness.size(); ++k) {
    CHECK(parameter(net, k, "stiffness") == expected.stiffness[k]);
    CHECK(parameter(net, k, "cubic") == 7.0);
    const LawUse& viscosity = *net.materials()[net.springs()[k].material].viscosity;
    CHECK(viscosity.id == "linear");
    CHECK(viscosity.parameters.at("damping") == 0.01 * expected.stiffness[k]);
  }

  // Lines: E A / l, also where the springs are not in the order of the edges.
  const Network lines =
      parse(body(rope, "cross_section = 0.1\nmaterial = { youngs_modulus = 50.0 }", ", mass = 1.0")).network;
  CHECK(parameter(lines, 0, "stiffness") == doctest::Approx(50.0 * 0.1 / 2.0).epsilon(1e-15));
  CHECK(parameter(lines, 1, "stiffness") == doctest::Approx(50.0 * 0.1 / 1.0).epsilon(1e-15));

  // A lattice numbers its springs in another order than edges_of.
  const Network lattice = parse(body(box_mesh, "density = 1.0\nmaterial = { youngs_modulus = 100.0 }")).network;
  double trace = 0;  // sum of k l^2 is 6 E V
  for (std::size_t k = 0; k < lattice.springs().size(); ++k) {
    const double l = lattice.springs()[k].rest_length;
    trace += parameter(lattice, k, "stiffness") * l * l;
    // Axial springs at the four long edges of the box are in one cell, those within in four.
    if (lattice.springs()[k].first == 0) CHECK(parameter(lattice, k, "stiffness") > 0);
  }
  // So each is compared with that of the edge between the same nodes. With three spacings no two directions are alike.
  const std::string uneven = "mesh = { lattice = [3, 4, 5], spacing = [0.5, 0.45, 0.6], diagonals = \"all\" }";
  const Network unlike = parse(body(uneven, "density = 1.0\nmaterial = { youngs_modulus = 100.0 }")).network;
  Lattice shape;
  shape.nodes = {3, 4, 5};
  shape.spacing = {0.5, 0.45, 0.6};
  const Mesh cells = mesh_of(shape);
  const std::vector<Edge> edges = edges_of(cells, {.face_diagonals = true, .space_diagonals = true});
  const NetStiffness net_stiffness = stiffness_of(cells, edges, 100.0, {});
  CHECK(std::set<double>(net_stiffness.stiffness.begin(), net_stiffness.stiffness.end()).size() > 10);
  REQUIRE(unlike.springs().size() == edges.size());
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const Edge pair = std::minmax(unlike.springs()[k].first, unlike.springs()[k].second);
    const auto found = std::lower_bound(edges.begin(), edges.end(), pair);
    REQUIRE(found != edges.end());
    REQUIRE(*found == pair);
    CHECK(parameter(unlike, k, "stiffness") ==
          net_stiffness.stiffness[static_cast<std::size_t>(found - edges.begin())]);
  }
  CHECK(trace == doctest::Approx(6 * 100.0 * 3.0).epsilon(1e-9));  // shares are exact to 1e-10
}

TEST_CASE("properties that a net of springs cannot have are noted") {
  const auto notes = [](const std::string& mesh, const std::string& material) {
    std::string all;
    for (const std::string& note : notes_of(parse(
             body(mesh, "density = 1.0\nthickness = 0.1\nmaterial = { youngs_modulus = 1.0" + material + " }")))) {
      all += note + "\n";
    }
    return all;
  };
  for (const char* fact : {"Body 'b'", "Poisson ratio", "1/4", "0.3"}) {
    CAPTURE(fact);
    CHECK(has_facts(notes(box_mesh, ", poisson_ratio = 0.3"), fact));
  }
  CHECK_FALSE(has_facts(notes(box_mesh, ", poisson_ratio = 0.25"), "Poisson"));
  CHECK_FALSE(has_facts(notes(box_mesh, ""), "Poisson"));
  CHECK(has_facts(notes(box_mesh, ", poisson_ratio = 0.45"), "0.45"));
  CHECK(has_facts(notes(sheet_mesh, ", poisson_ratio = 0.25"), "1/3"));
  CHECK(has_facts(notes(sheet_mesh, ", poisson_ratio = 0.25"), "0.25"));
  CHECK_FALSE(has_facts(notes(box_mesh, ""), "shear"));
  CHECK(has_facts(notes("mesh = { lattice = [3, 3, 3], spacing = 1.0 }", ""), "shear | diagonals"));

  // Flat cells, whose springs are another material.
  const auto flat = [&](double height) {
    return notes(
        "mesh = { lattice = [3, 3, 3], spacing = [1, 1, " + std::to_string(height) + "], diagonals = \"all\" }", "");
  };
  const std::string misfit = "elasticity";
  CHECK_FALSE(has_facts(flat(0.6), misfit));
  CHECK(has_facts(flat(0.5), misfit + " | 11 %"));
  CHECK(has_facts(flat(0.2), misfit + " | 51 %"));
  CHECK(has_facts(flat(0.2), "diagonals = \"all\""));
  // Without diagonals there is no shear at all, which is said by itself.
  CHECK_FALSE(has_facts(notes("mesh = { lattice = [3, 3, 3], spacing = [1, 1, 0.2] }", ""), misfit));
  // Tetrahedra are not isotropic one by one, and have a Poisson ratio that is only about that of a regular net.
  CHECK_FALSE(has_facts(notes(bar_mesh, ""), misfit));
  CHECK(has_facts(notes(bar_mesh, ", poisson_ratio = 0.3"), "Poisson ratio | about 1/4"));
  CHECK_FALSE(has_facts(notes(box_mesh, ", poisson_ratio = 0.3"), "about"));
}

#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__)
TEST_CASE("a body of a hundred thousand tetrahedra is read in seconds, with its material") {
  // 26^3 cubes in six tetrahedra each.
  Lattice lattice;
  lattice.nodes = {27, 27, 27};
  const Mesh cubes = mesh_of(lattice);
  std::string text = fmt::format("# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
                                 cubes.points.size());
  for (const Vector3& p : cubes.points) text += fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
  const auto tetrahedra = tetrahedra_of(cubes);
  REQUIRE(tetrahedra.size() == 105456);
  text += fmt::format("CELLS {} {}\n", tetrahedra.size(), 5 * tetrahedra.size());
  for (const auto& [a, b, c, d] : tetrahedra) text += fmt::format("4 {} {} {} {}\n", a, b, c, d);
  text += fmt::format("CELL_TYPES {}\n", tetrahedra.size());
  for (std::size_t k = 0; k < tetrahedra.size(); ++k) text += "10\n";
  const testing::TemporaryFolder folder;
  folder.write("block.vtk", text);
  const auto begin = std::clock();
  const Scene scene = parse_scene(
      body("mesh = { file = \"block.vtk\" }", "density = 1.0\nmaterial = { youngs_modulus = 1e4 }") +
          "[[element]]\ninvariant = \"volume\"\nselect = {}\nspring = { type = \"linear\", stiffness = 1.0 }\n",
      "test.toml", plugins(), {}, folder.path());
  // It takes about one.
  CHECK(static_cast<double>(std::clock() - begin) < 20.0 * CLOCKS_PER_SEC);
  CHECK(scene.network.nodes().size() == 27 * 27 * 27);
  CHECK(scene.network.elements().size() == tetrahedra.size());
}
#endif

TEST_CASE("errors of a material name its place") {
  const auto refused = [](const std::string& keys, const std::string& neuron = "") {
    return refusal(body(bar_mesh, keys, neuron));
  };
  const std::string material = "density = 1.0\nmaterial = { youngs_modulus = 1.0";
  CHECK(has_facts(refused("density = 1.0\n" + spring, ", mass = 1.0"),
                  "test.toml:7:40: body.0.neuron.mass: | 'density'"));
  CHECK(has_facts(refused(spring), "'mass' | 'density'"));
  CHECK(has_facts(refused("density = 0\n" + spring), "test.toml:8:11: body.0.density: | above 0"));
  CHECK(has_facts(refused(material + " }\n" + spring), "body.0.spring: | 'material'"));
  CHECK(has_facts(refused("density = 1.0\nmaterial = { }"), "'youngs_modulus' | missing"));
  CHECK(has_facts(refused(material + ", poisson_ratio = 0.5 }"), "poisson_ratio | -1 | 0.5"));
  CHECK(has_facts(refused(material + ", damping_time = 1.0 }\nviscosity = { type = \"linear\", damping = 1.0 }"),
                  "damping_time: | 'viscosity'"));
  CHECK(has_facts(refused(material + ", law = \"liner\" }"), "did you mean 'linear'"));
  CHECK(has_facts(refused(material + ", law = { type = \"linear\", stiffness = 1.0 } }"),
                  "body.0.material.law.stiffness: | material"));
  CHECK(has_facts(refused(material + ", law = \"rupturing\" }"), "strength"));
  CHECK(has_facts(refused("thickness = 1.0\n" + spring, ", mass = 1.0"), "body.0.thickness: | 'density' | 'material'"));
  CHECK(has_facts(refusal(body(sheet_mesh, material + " }")), "body.0.density: | quadrilateral 0 | thickness"));
  CHECK(has_facts(refusal(body(rope, material + " }")), "a cross section"));
  CHECK(has_facts(refusal(body("nodes = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]\nsprings = [[0, 1]]",
                               "cross_section = 1.0\n" + material + " }")),
                  "point 2 | [2, 0, 0] | mass"));
  CHECK(has_facts(refusal(body("nodes = [[0, 0, 0], [1, 0, 0]]\nsprings = [[0, 1], [1, 0]]",
                               "cross_section = 1.0\n" + material + " }")),
                  "joins two nodes twice"));
  CHECK(has_facts(
      refusal(body("mesh = { lattice = [100000, 100000, 100000], spacing = 1.0 }", "density = 1.0\n" + spring)),
      "body.0.mesh: | lattice 'b' | 1e+15 nodes"));
}
