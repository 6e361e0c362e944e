#include <springnet/inspection.hpp>

#include <cmath>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using testing::plugins;

namespace {

// A lattice of 2 x 2 x 2 nodes, a pair with a spring that is stretched, and a node alone.
Network mixed() {
  Network network;
  const MaterialIndex soft = network.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, std::nullopt});
  const MaterialIndex damped = network.add_material(
      {LawUse{"nonlinear", {{"stiffness", 5.0}, {"cubic", 7.0}}}, LawUse{"relative", {{"damping", 2.0}}}});
  const MaterialIndex viscous = network.add_material({std::nullopt, LawUse{"linear", {{"damping", 0.25}}}});
  Node prototype;
  prototype.mass = 0.5;
  network.add_lattice("box", {{2, 2, 2}, Vector3(1.0, 2.0, 3.0), Vector3(-1.0, 0.0, 0.0), Diagonals::none}, prototype,
                      soft);
  Node node;
  node.mass = 4.0;
  node.neuron = network.add_neuron({"dragged", {{"drag", 0.1}}});
  node.position = Vector3(10.0, 0.0, 0.0);
  const NodeIndex a = network.add_node(node);
  node.position = Vector3(10.0, 0.0, 1.5);
  const NodeIndex b = network.add_node(node);
  node.position = Vector3(0.0, 0.0, 8.0);
  network.fix(network.add_node(node));
  network.add_spring(a, b, damped, 1.0);
  network.add_spring(a, b, viscous);
  network.add_plane({});
  return network;
}

}  // namespace

TEST_CASE("a network is counted and measured") {
  const Inspection found = inspect(mixed(), *plugins());
  CHECK(found.nodes == 11);
  CHECK(found.springs == 14);
  CHECK(found.bodies == 1);
  CHECK(found.fixed_nodes == 1);
  CHECK(found.planes == 1);
  CHECK(found.loads == 0);
  CHECK(found.cuts == 0);
  CHECK(found.spring_functions == std::map<std::string, std::size_t>{{"linear", 12}, {"nonlinear", 1}, {"none", 1}});
  CHECK(found.viscosity_functions == std::map<std::string, std::size_t>{{"linear", 1}, {"none", 12}, {"relative", 1}});
  CHECK(found.neurons == std::map<std::string, std::size_t>{{"dragged", 3}, {"point_mass", 8}});
  CHECK(found.total_mass == 16.0);
  CHECK(found.mass->smallest == 0.5);
  CHECK(found.mass->largest == 4.0);
  CHECK(found.length->smallest == 1.0);
  CHECK(found.length->largest == 3.0);
  CHECK(found.rest_length->smallest == 1.0);
  CHECK(found.springs_under_load == 1);
  CHECK(found.lower == Vector3(-1.0, 0.0, 0.0));
  CHECK(found.upper == Vector3(10.0, 2.0, 8.0));
  CHECK(found.parts.size() == 3);
  CHECK(found.nodes_without_springs == 1);
}

TEST_CASE("stiffness and damping are the derivatives of the laws where the springs start") {
  const Inspection found = inspect(mixed(), *plugins());
  CHECK(found.stiffness->smallest == 3.0);
  // T = 5 x + 7 x^3 at x = 0.5; derivative to rounding.
  CHECK(found.stiffness->largest == doctest::Approx(5.0 + 21.0 * 0.25).epsilon(1e-14));
  CHECK(found.damping->smallest == 0.25);
  CHECK(found.damping->largest == 2.0);
}

TEST_CASE("an empty network has nothing to measure") {
  const Inspection found = inspect(Network(), *plugins());
  CHECK(found.nodes == 0);
  CHECK(found.parts.empty());
  CHECK_FALSE(found.mass);
  CHECK_FALSE(found.stiffness);
  CHECK(found.limit("synchronous").kind == TimeConstantLimit::Kind::none);
}

TEST_CASE("an unknown law is a plugin error that names it") {
  Network network;
  network.add_node({});
  Node other;
  other.position = Vector3::UnitX();
  network.add_node(other);
  network.add_spring(0, 1, network.add_material({LawUse{"no_such_law", {}}, std::nullopt}));
  try {
    static_cast<void>(inspect(network, *plugins()));
    FAIL("inspected");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::plugin);
    CHECK(std::string(error.what()).find("no_such_law") != std::string::npos);
  }
}

TEST_CASE("laws of elements are counted, too") {
  Network network = mixed();
  const MaterialIndex solid = network.add_material({LawUse{"solid", {{"youngs_modulus", 3.0}, {"poisson_ratio", 0.3}}},
                                                    LawUse{"viscous_solid", {{"shear_viscosity", 0.5}}}});
  network.add_element(Invariant::tetrahedron, {0, 1, 2, 4}, solid);
  network.add_element(Invariant::area, {0, 1, 2}, 0);
  const Inspection found = inspect(network, *plugins());
  using Counts = std::map<std::string, std::size_t>;
  CHECK(found.element_spring_functions == Counts{{"linear", 1}, {"solid", 1}});
  CHECK(found.element_viscosity_functions == Counts{{"none", 1}, {"viscous_solid", 1}});
  CHECK(found.spring_functions == Counts{{"linear", 12}, {"nonlinear", 1}, {"none", 1}});
  CHECK(nlohmann::json::parse(to_json(found))["element_spring_functions"]["solid"] == 1);
}

TEST_CASE("what was found is told as JSON") {
  const auto json = nlohmann::json::parse(to_json(inspect(mixed(), *plugins())));
  CHECK(json["nodes"] == 11);
  CHECK(json["springs"] == 14);
  CHECK(json["mass_kg"]["largest"] == 4.0);
  CHECK(json["spring_functions"]["linear"] == 12);
  CHECK(json["upper_m"] == nlohmann::json::array({10.0, 2.0, 8.0}));
  CHECK(json["time_constants"]["synchronous"]["time_constant_s"].is_number());
  CHECK(nlohmann::json::parse(to_json(Inspection{}))["stiffness_n_per_m"].is_null());
}
