// What a network takes and what it refuses.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/network.hpp>

#include "facts.hpp"
#include "not_finite.hpp"

using springnet::LawUse;
using springnet::Material;
using springnet::Network;
using springnet::Vector3;
using springnet::testing::inf;
using springnet::testing::nan_value;

namespace {

const Material linear{LawUse{"linear", {{"stiffness", 3.0}}}, std::nullopt};

// Two nodes one metre apart, joined by a spring.
Network pair() {
  Network network;
  network.add_node({});
  network.add_node({Vector3::UnitX(), Vector3::Zero(), 2.0, 0, false});
  network.add_spring(0, 1, network.add_material(linear));
  return network;
}

// The message of the Error(input) that `change` throws, "" if none.
template <class Change>
std::string error_of(Change&& change) {
  Network network = pair();
  try {
    change(network);
  } catch (const springnet::Error& error) {
    CHECK(error.kind() == springnet::ErrorKind::input);
    return error.what();
  }
  return {};
}

template <class Change>
bool refused(Change&& change, const std::string& words) {
  const std::string message = error_of(change);
  CAPTURE(message);
  const bool found = springnet::testing::has_facts(message, words);
  CHECK(found);
  return found;
}

}  // namespace

TEST_CASE("a network begins with the neuron point_mass and without materials") {
  const Network network;
  REQUIRE(network.neurons().size() == 1);
  CHECK(network.neurons()[0] == LawUse{"point_mass", {}});
  CHECK(network.materials().empty());
  CHECK(network.gravity() == Vector3::Zero());
}

TEST_CASE("equal neurons and materials have one index, different ones have their own") {
  Network network;
  CHECK(network.add_neuron({"point_mass", {}}) == 0);
  const auto dragged = network.add_neuron({"dragged", {{"drag", 1.0}}});
  CHECK(dragged == 1);
  CHECK(network.add_neuron({"dragged", {{"drag", 1.0}}}) == dragged);
  CHECK(network.add_neuron({"dragged", {{"drag", 2.0}}}) != dragged);

  const auto a = network.add_material(linear);
  CHECK(network.add_material(linear) == a);
  // The same function as viscosity is another material, as is any other parameter, name or number.
  CHECK(network.add_material({std::nullopt, linear.spring}) == 1);
  CHECK(network.add_material({linear.spring, linear.spring}) == 2);
  CHECK(network.add_material({LawUse{"linear", {{"stiffness", std::nextafter(3.0, 4.0)}}}, std::nullopt}) == 3);
  CHECK(network.add_material({LawUse{"linear", {}}, std::nullopt}) == 4);
  // Equal numbers are equal, whatever the sign of a zero.
  const auto zero = network.add_material({LawUse{"linear", {{"stiffness", 0.0}}}, std::nullopt});
  CHECK(network.add_material({LawUse{"linear", {{"stiffness", -0.0}}}, std::nullopt}) == zero);
}

TEST_CASE("a hundred thousand different materials are added in seconds") {
  // With a linear search these were 5e9 comparisons; the test then runs into the time limit of any test runner.
  Network network;
  for (int i = 0; i < 100'000; ++i) {
    network.add_material({LawUse{"linear", {{"stiffness", i}}}, std::nullopt});
  }
  CHECK(network.materials().size() == 100'000);
  CHECK(network.add_material({LawUse{"linear", {{"stiffness", 77'777.0}}}, std::nullopt}) == 77'777);
}

TEST_CASE("uses of components that are refused") {
  refused([](Network& n) { n.add_neuron({"", {}}); }, "has no id");
  refused([](Network& n) { n.add_neuron({"dragged", {{"drag", nan_value}}}); }, "'dragged' | 'drag' | nan");
  refused([](Network& n) { n.add_material({}); }, "spring function | viscosity function");
  refused([](Network& n) { n.add_material({LawUse{"linear", {{"stiffness", inf}}}, std::nullopt}); }, "is inf");
}

TEST_CASE("nodes: values are kept, wrong ones are refused") {
  Network network;
  const springnet::Node node{{1, 2, 3}, {4, 5, 6}, 7, 0, false};
  CHECK(network.add_node(node) == 0);
  CHECK(network.add_node(node) == 1);
  CHECK(network.nodes()[1].position == Vector3(1, 2, 3));
  CHECK(network.nodes()[1].velocity == Vector3(4, 5, 6));
  CHECK(network.nodes()[1].mass == 7);

  springnet::Node bad;
  const auto add = [&](Network& n) { n.add_node(bad); };
  bad.mass = 0;
  refused(add, "node 2: | mass | above 0 kg | is 0");
  bad.mass = -1;
  refused(add, "is -1");
  bad.mass = nan_value;
  refused(add, "is nan");
  bad.mass = inf;
  refused(add, "is inf");
  bad = {};
  bad.position.y() = nan_value;
  refused(add, "position | [0, nan, 0]");
  bad = {};
  bad.velocity.z() = -inf;
  refused(add, "velocity | [0, 0, -inf]");
  bad = {};
  bad.neuron = 1;
  refused(add, "neuron 1 | only 1");
  refused([&](Network& n) { n.set_node(0, bad); }, "node 0: | neuron 1");
  refused([](Network& n) { n.set_node(2, {}); }, "node 2 | only 2");
}

TEST_CASE("a fixed node has no velocity, however it came to be fixed") {
  Network network;
  const springnet::Node moving{Vector3::Zero(), Vector3::UnitX(), 1, 0, false};
  springnet::Node fixed = moving;
  fixed.fixed = true;
  network.add_node(fixed);
  network.add_node(moving);
  network.fix(1);
  network.add_node(moving);
  network.set_node(2, fixed);
  for (const springnet::Node& node : network.nodes()) {
    CHECK(node.fixed);
    CHECK(node.velocity == Vector3::Zero());
  }
  refused([](Network& n) { n.fix(2); }, "node 2 | only 2");
}

TEST_CASE("springs: the rest length is the distance by default") {
  Network network;
  network.add_node({{1, 1, 1}, Vector3::Zero(), 1, 0, false});
  network.add_node({{1, 4, 5}, Vector3::Zero(), 1, 0, false});
  const auto material = network.add_material(linear);
  CHECK(network.springs()[network.add_spring(0, 1, material)].rest_length == 5);
  CHECK(network.springs()[network.add_spring(1, 0, material, 2.5)].rest_length == 2.5);
  CHECK(network.springs()[network.add_spring(1, 0, material, 0.0)].rest_length == 0);
  CHECK(network.springs()[1].first == 1);
  CHECK(network.springs()[1].second == 0);
}

TEST_CASE("springs that are refused") {
  refused([](Network& n) { n.add_spring(0, 2, 0); }, "node 2 | only 2");
  refused([](Network& n) { n.add_spring(1, 1, 0); }, "joins node 1 to itself");
  refused([](Network& n) { n.add_spring(0, 1, 1); }, "material 1 | only 1");
  refused([](Network& n) { n.add_spring(0, 1, 0, -1.0); }, "at least 0 m | is -1");
  refused([](Network& n) { n.add_spring(0, 1, 0, nan_value); }, "is nan");
  refused([](Network& n) { n.add_spring(0, 1, 0, inf); }, "is inf");
  refused(
      [](Network& n) {
        n.add_node({Vector3::UnitX(), Vector3::Zero(), 1, 0, false});
        n.add_spring(1, 2, 0);
      },
      "node 1 | node 2 | length zero | [1, 0, 0]");
  refused([](Network& n) { n.set_spring_material(1, 0); }, "spring 1 | only 1");
  refused([](Network& n) { n.set_spring_material(0, 1); }, "material 1");
  refused([](Network& n) { n.set_rest_length(1, 1); }, "spring 1");
  refused([](Network& n) { n.set_rest_length(0, -2); }, "is -2");
}

TEST_CASE("nodes at one place may be joined by a spring with a rest length") {
  Network network;
  network.add_node({});
  network.add_node({});
  network.add_spring(0, 1, network.add_material(linear), 1.0);
  CHECK(network.springs().size() == 1);
}

TEST_CASE("changes of springs") {
  Network network = pair();
  const auto other = network.add_material({std::nullopt, LawUse{"relative", {{"damping", 1.0}}}});
  network.set_spring_material(0, other);
  network.set_rest_length(0, 4);
  CHECK(network.springs()[0].material == other);
  CHECK(network.springs()[0].rest_length == 4);
}

TEST_CASE("a body has the nodes and springs added between begin and end") {
  Network network;
  const auto material = network.add_material(linear);
  network.add_node({{9, 9, 9}, Vector3::Zero(), 1, 0, false});
  network.begin_body("pair");
  network.add_node({});
  network.add_node({Vector3::UnitX(), Vector3::Zero(), 1, 0, false});
  network.add_spring(1, 2, material);
  network.end_body();
  REQUIRE(network.bodies().size() == 1);
  CHECK(network.bodies()[0].name == "pair");
  CHECK(network.bodies()[0].first_node == 1);
  CHECK(network.bodies()[0].node_count == 2);
  CHECK(network.bodies()[0].first_spring == 0);
  CHECK(network.bodies()[0].spring_count == 1);

  CHECK_THROWS_WITH_AS(network.begin_body("pair"), doctest::Contains("bodies 'pair'"), springnet::Error);
  CHECK_THROWS_WITH_AS(network.begin_body(""), "a body needs a name", springnet::Error);
  CHECK_THROWS_AS(network.end_body(), springnet::Error);
  network.begin_body("open");
  CHECK_THROWS_WITH_AS(network.begin_body("other"), doctest::Contains("body 'other'"), springnet::Error);
}

TEST_CASE("loads: each node once, intervals of some length") {
  Network network = pair();
  network.add_load({{1, 0, 1}, {0, 0, 5}, 1.0, 2.0});
  REQUIRE(network.loads().size() == 1);
  CHECK(network.loads()[0].nodes == std::vector<springnet::NodeIndex>{0, 1});
  CHECK(network.loads()[0].force == Vector3(0, 0, 5));
  network.add_load({{0}, {0, 0, 5}, -inf, inf});

  refused([](Network& n) { n.add_load({{2}, {0, 0, 1}, 0, 1}); }, "load | node 2 | 2 nodes");
  refused([](Network& n) { n.add_load({{0}, {0, nan_value, 1}, 0, 1}); }, "load's force | nan");
  refused([](Network& n) { n.add_load({{0}, {0, 0, 1}, 2, 2}); }, "load | from 2 s | until 2 s");
  refused([](Network& n) { n.add_load({{0}, {0, 0, 1}, nan_value, 2}); }, "load | not a number | 2 s");
  // A refused load leaves nothing behind.
  CHECK_THROWS_AS(network.add_load({{2}, {0, 0, 1}, 0, 1}), springnet::Error);
  CHECK(network.loads().size() == 2);
}

TEST_CASE("planes: normals are normalised, whatever their length") {
  Network network = pair();
  network.add_plane({"floor", Vector3::Zero(), {0, 3, 4}});
  CHECK(network.planes()[0].normal.isApprox(Vector3(0, 0.6, 0.8), 1e-15));  // one rounding a coordinate
  network.add_plane({"", Vector3::Zero(), {0, 0, 1e-200}});
  network.add_plane({"", Vector3::Zero(), {0, 1e200, 0}});
  CHECK(network.planes()[1].normal == Vector3::UnitZ());
  CHECK(network.planes()[2].normal == Vector3::UnitY());

  refused([](Network& n) { n.add_plane({"", Vector3::Zero(), Vector3::Zero()}); }, "normal | zero");
  refused([](Network& n) { n.add_plane({"", {nan_value, 0, 0}, Vector3::UnitZ()}); }, "point | nan");
  refused([](Network& n) { n.add_plane({"", Vector3::Zero(), {0, inf, 0}}); }, "normal | inf");
  CHECK_THROWS_WITH_AS(network.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()}),
                       doctest::Contains("planes 'floor'"), springnet::Error);
}

TEST_CASE("cuts: springs, polygons planar to rounding, convex or not") {
  Network network = pair();
  network.add_cut({1.0, {0}, {}});
  network.add_cut({0.0, {}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
  // An L whose corners are off the plane z = x by a rounding.
  network.add_cut({0.0, {}, {{0, 0, 0}, {2, 0, 2}, {2, 1, 2}, {1, 1, 1 + 1e-15}, {1, 2, 1}, {0, 2, 0}}});
  CHECK(network.cuts().size() == 3);

  refused([](Network& n) { n.add_cut({1.0, {}, {}}); }, "springs | polygon");
  refused([](Network& n) { n.add_cut({nan_value, {0}, {}}); }, "time | nan");
  refused([](Network& n) { n.add_cut({1.0, {1}, {}}); }, "spring 1 | only 1");
  refused([](Network& n) { n.add_cut({1.0, {}, {{0, 0, 0}, {1, 0, 0}}}); }, "three corners | has 2");
  refused([](Network& n) { n.add_cut({1.0, {}, {{0, 0, 0}, {1, 0, 0}, {nan_value, 1, 0}}}); }, "corner | nan");
  refused([](Network& n) { n.add_cut({1.0, {}, {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}}); }, "lie on a line");
  refused(
      [](Network& n) {
        n.add_cut({1.0, {}, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}}});
      },
      "must be planar; corner ");
}

TEST_CASE("gravity is finite") {
  Network network;
  network.set_gravity({0, 0, -9.81});
  CHECK(network.gravity() == Vector3(0, 0, -9.81));
  CHECK_THROWS_AS(network.set_gravity({0, 0, nan_value}), springnet::Error);
  CHECK(network.gravity() == Vector3(0, 0, -9.81));
}
