// A network as a scene, and back.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/formula.hpp>
#include <springnet/scene_writer.hpp>

#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Scene read(const std::string& text) { return parse_scene(text, "written", *plugins()); }

Scene scene_of(const Network& network) {
  Scene scene;
  scene.network = network;
  return scene;
}

bool same_law(const std::optional<LawUse>& a, const std::optional<LawUse>& b) {
  if (!a || !b) return !a && !b;
  const LawFormula* const formula = a->component ? formula_of(*a->component) : nullptr;
  if (formula == nullptr) return *a == *b;
  const LawFormula* const other = b->component ? formula_of(*b->component) : nullptr;
  return other != nullptr && formula->force == other->force && formula->energy == other->energy &&
         formula->margin == other->margin && formula->forces == other->forces && a->parameters == b->parameters &&
         formula->states.size() == other->states.size() && formula->curves.size() == other->curves.size() &&
         formula->summary == other->summary && formula->largest_stretch == other->largest_stretch;
}

bool same_material(const Network& a, MaterialIndex of_a, const Network& b, MaterialIndex of_b) {
  return same_law(a.materials()[of_a].spring, b.materials()[of_b].spring) &&
         same_law(a.materials()[of_a].viscosity, b.materials()[of_b].viscosity);
}

bool same_motion(const std::optional<Motion>& a, const std::optional<Motion>& b) {
  if (!a || !b) return !a && !b;
  return a->times == b->times && a->displacements == b->displacements && a->amplitude == b->amplitude &&
         a->frequency == b->frequency && a->phase == b->phase && a->from == b->from && a->until == b->until &&
         (a->displacements.empty() || a->interpolation == b->interpolation);
}

bool same_turn(const std::optional<Turn>& a, const std::optional<Turn>& b) {
  if (!a || !b) return !a && !b;
  return a->axis == b->axis && a->through == b->through && a->rate == b->rate && a->from == b->from &&
         a->until == b->until && a->times == b->times && a->angles == b->angles;
}

template <class Obstacle>
void check_obstacle(const Obstacle& a, const Obstacle& b) {
  CHECK(a.name == b.name);
  CHECK(a.friction.kind == b.friction.kind);
  CHECK(a.friction.coefficient == b.friction.coefficient);
  CHECK(a.restitution == b.restitution);
  CHECK(same_motion(a.motion, b.motion));
  CHECK(same_turn(a.turn, b.turn));
}

void check_same_nets(const Network& a, const Network& b) {
  REQUIRE(a.nodes().size() == b.nodes().size());
  REQUIRE(a.springs().size() == b.springs().size());
  REQUIRE(a.elements().size() == b.elements().size());
  std::size_t differ = 0;
  for (NodeIndex k = 0; k < a.nodes().size(); ++k) {
    const Node x = a.nodes()[k], y = b.nodes()[k];
    differ += x.position != y.position || (!x.fixed && x.velocity != y.velocity) || x.mass != y.mass ||
              x.fixed != y.fixed || a.neurons()[x.neuron] != b.neurons()[y.neuron];
  }
  CHECK(differ == 0);
  for (SpringIndex s = 0; s < a.springs().size(); ++s) {
    const Spring x = a.springs()[s], y = b.springs()[s];
    differ += x.first != y.first || x.second != y.second || x.rest_length != y.rest_length ||
              !same_material(a, x.material, b, y.material);
  }
  CHECK(differ == 0);
  for (ElementIndex e = 0; e < a.elements().size(); ++e) {
    const Element &x = a.elements()[e], &y = b.elements()[e];
    differ += x.invariant != y.invariant || x.nodes != y.nodes || x.reference != y.reference || x.rest != y.rest ||
              x.direction != y.direction || !same_material(a, x.material, b, y.material);
  }
  CHECK(differ == 0);
  CHECK(a.faces() == b.faces());
  CHECK(a.gravity() == b.gravity());
  REQUIRE(a.bodies().size() == b.bodies().size());
  for (std::size_t k = 0; k < a.bodies().size(); ++k) {
    CHECK(a.bodies()[k].name == b.bodies()[k].name);
    CHECK(a.bodies()[k].first_node == b.bodies()[k].first_node);
    CHECK(a.bodies()[k].node_count == b.bodies()[k].node_count);
    CHECK(a.bodies()[k].spring_count == b.bodies()[k].spring_count);
    CHECK(a.bodies()[k].face_count == b.bodies()[k].face_count);
    REQUIRE(a.bodies()[k].groups.size() == b.bodies()[k].groups.size());
    for (std::size_t g = 0; g < a.bodies()[k].groups.size(); ++g) {
      CHECK(a.bodies()[k].groups[g].name == b.bodies()[k].groups[g].name);
      CHECK(a.bodies()[k].groups[g].nodes == b.bodies()[k].groups[g].nodes);
    }
  }
  REQUIRE(a.rigids().size() == b.rigids().size());
  for (std::size_t k = 0; k < a.rigids().size(); ++k) {
    CHECK(a.rigids()[k].first == b.rigids()[k].first);
    CHECK(a.rigids()[k].second == b.rigids()[k].second);
    CHECK(a.rigids()[k].length == b.rigids()[k].length);
  }
  REQUIRE(a.loads().size() == b.loads().size());
  for (std::size_t k = 0; k < a.loads().size(); ++k) {
    const Load &x = a.loads()[k], &y = b.loads()[k];
    CHECK(x.nodes == y.nodes);
    CHECK(x.force == y.force);
    CHECK(x.from == y.from);
    CHECK(x.until == y.until);
    CHECK(x.faces == y.faces);
    CHECK(x.areas == y.areas);
    CHECK(x.traction == y.traction);
    CHECK(x.pressure == y.pressure);
    CHECK(x.follow == y.follow);
    CHECK(x.course.times == y.course.times);
    CHECK(x.course.factors == y.course.factors);
    CHECK(x.course.frequency == y.course.frequency);
    CHECK(x.course.phase == y.course.phase);
    CHECK(x.course.amplitude == y.course.amplitude);
    CHECK(x.course.mean == y.course.mean);
    CHECK(x.course.ramp == y.course.ramp);
  }
  REQUIRE(a.moves().size() == b.moves().size());
  for (std::size_t k = 0; k < a.moves().size(); ++k) {
    CHECK(a.moves()[k].nodes == b.moves()[k].nodes);
    CHECK(same_motion(a.moves()[k].motion, b.moves()[k].motion));
  }
  REQUIRE(a.planes().size() == b.planes().size());
  for (std::size_t k = 0; k < a.planes().size(); ++k) {
    check_obstacle(a.planes()[k], b.planes()[k]);
    CHECK(a.planes()[k].point == b.planes()[k].point);
    CHECK(a.planes()[k].normal == b.planes()[k].normal);
  }
  REQUIRE(a.instruments().size() == b.instruments().size());
  for (std::size_t k = 0; k < a.instruments().size(); ++k) {
    const Instrument &x = a.instruments()[k], &y = b.instruments()[k];
    check_obstacle(x, y);
    CHECK(x.first == y.first);
    CHECK(x.second == y.second);
    REQUIRE(x.box.has_value() == y.box.has_value());
    if (!x.box) {
      CHECK(x.radius == y.radius);
      continue;
    }
    CHECK(x.box->size == y.box->size);
    CHECK(x.box->axes == y.box->axes);
    CHECK(x.box->radius == y.box->radius);
  }
  REQUIRE(a.cuts().size() == b.cuts().size());
  for (std::size_t k = 0; k < a.cuts().size(); ++k) {
    CHECK(a.cuts()[k].time == b.cuts()[k].time);
    CHECK(a.cuts()[k].springs == b.cuts()[k].springs);
    CHECK(a.cuts()[k].polygon == b.cuts()[k].polygon);
  }
  REQUIRE(a.inputs().size() == b.inputs().size());
  for (std::size_t k = 0; k < a.inputs().size(); ++k) {
    CHECK(a.inputs()[k].input == b.inputs()[k].input);
    CHECK(a.inputs()[k].name == b.inputs()[k].name);
    CHECK(a.inputs()[k].springs == b.inputs()[k].springs);
    CHECK(a.inputs()[k].elements == b.inputs()[k].elements);
    CHECK(a.inputs()[k].signal.times == b.inputs()[k].signal.times);
    CHECK(a.inputs()[k].signal.values == b.inputs()[k].signal.values);
    CHECK(a.inputs()[k].signal.mean == b.inputs()[k].signal.mean);
    CHECK(a.inputs()[k].signal.amplitude == b.inputs()[k].signal.amplitude);
    CHECK(a.inputs()[k].signal.frequency == b.inputs()[k].signal.frequency);
    CHECK(a.inputs()[k].signal.phase == b.inputs()[k].signal.phase);
  }
}

void check_same_motion(const Scene& a, const Scene& b, int steps) {
  SimulationOptions of_a = a.options, of_b = b.options;
  of_a.threads = of_b.threads = 1;
  Simulation x(a.network, plugins(), of_a), y(b.network, plugins(), of_b);
  for (int k = 0; k < steps; ++k) {
    x.step();
    y.step();
  }
  CHECK(x.in_user_order(x.positions()) == y.in_user_order(y.positions()));
  CHECK(x.in_user_order(x.velocities()) == y.in_user_order(y.velocities()));
  CHECK(x.events().size() == y.events().size());
}

void check_same_settings(const Scene& a, const Scene& b) {
  CHECK(a.title == b.title);
  CHECK(a.duration == b.duration);
  CHECK(a.options.time_step == b.options.time_step);
  CHECK(a.options.integrator == b.options.integrator);
  CHECK(a.options.renumber == b.options.renumber);
  CHECK(a.output.interval == b.output.interval);
  CHECK(a.output.elements == b.output.elements);
  CHECK(a.output.element_numbers == b.output.element_numbers);
  CHECK(a.output.springs == b.output.springs);
  CHECK(a.output.nodes == b.output.nodes);
  CHECK(a.output.force == b.output.force);
  CHECK(a.output.states == b.output.states);
}

// Everything that a scene has.
const char* const everything = R"scene(
title = "All\nof \"it\""
[simulation]
duration = 1.5
time_step = 0.001
integrator = { name = "recurrent", update = "newton", theta = 0.5, force_tolerance = 1e-8, unsettled = "accept" }
renumber = false
[gravity]
acceleration = [0, 0.1, -9.81]
[output]
interval = 0.1
elements = ["skin", "hinges"]
springs = { body = "cube" }
quantities = ["position", "force"]
[[body]]
name = "cube"
mesh = { lattice = [3, 3, 3], spacing = [0.1, 0.11, 0.13], origin = [0.3, 0, 0.5], diagonals = "all" }
neuron = { type = "dragged", drag = 0.1 }
density = 1000.0
material = { youngs_modulus = 1e4, damping_time = 0.01, law = { formula = "stiffness * e * (1 + 2 * e^2)" } }
rest_length_scale = 0.97
[[body]]
name = "chain"
nodes = [[2, 0, 1], [2.3, 0, 1], [2.6, 0.05, 1], [2.9, 0, 1.1]]
springs = [[1, 0], [1, 2], [3, 2]]
velocity = [0, 0, 0.3]
neuron = { type = "point_mass", mass = 0.3 }
spring = { type = "muscle", strength = 5.0 }
viscosity = { type = "relative", damping = 0.1 }
[[body]]
name = "sheet"
mesh = { lattice = [4, 4, 1], spacing = 0.1, origin = [0, 3, 1] }
neuron = { type = "point_mass", mass = 0.01 }
thickness = 0.01
material = { youngs_modulus = 1e4, poisson_ratio = 0.3, damping_time = 0.01, law = "membrane", bending = true }
[[body]]
name = "flesh"
mesh = { lattice = [3, 2, 2], spacing = 0.1, origin = [0, 6, 1] }
neuron = { type = "point_mass" }
density = 1000.0
material = { youngs_modulus = 1e4, poisson_ratio = 0.3, direction = [1, 2, 0.5], law = { type = "fibre_solid", fibre_modulus = 1e4 } }
[[connect]]
from = { body = "cube", nodes = [26] }
to = { body = "chain", nodes = [0] }
nearest = true
rest_length = 1.5
spring = { type = "table", elongations = [-0.5, 0, 0.5], forces = [-1, 0, 2], beyond = "constant" }
[[rigid]]
pairs = [[{ body = "chain", node = 2 }, { body = "chain", node = 3 }]]
[[element]]
name = "skin"
invariant = "area"
select = { body = "cube", box = { max = [inf, inf, 0.55] } }
spring = { type = "linear", stiffness = 3.0 }
reference_scale = 0.9
[[element]]
invariant = "angle"
body = "chain"
nodes = [[0, 1, 2]]
spring = { formula = "k * e * (1 + activation)", inputs = ["activation"], k = 0.1 }
viscosity = { formula = "c * rate", c = { value = "0.01 N m s/rad", smallest = 0, summary = "damping" } }
[[element]]
name = "hinges"
invariant = "dihedral"
select = { body = "sheet" }
spring = { type = "linear", stiffness = 0.01 }
[[node]]
select = { body = "cube", nodes = [3, 4] }
mass = 0.7
velocity = [0.1, 0, 0]
neuron = { type = "point_mass" }
[[spring]]
select = { body = "cube", springs = [5, 6] }
spring = "none"
viscosity = { type = "linear", damping = 0.3 }
rest_length = 0.2
[[fix]]
select = { body = "sheet", nodes = [0, 3] }
[[force]]
select = { body = "cube", nodes = [0, 1] }
force = [1, 0, 0]
sinusoid = { frequency = 3.0, phase = 0.1, amplitude = 2.0, mean = 0.5 }
from = 0.1
until = 0.9
[[force]]
select = { body = "cube" }
pressure = 10.0
follow = true
ramp = 0.3
[[force]]
select = { body = "sheet" }
total = [0, 0, 0.01]
table = [[0, 0], [0.4, 1], [0.8, 0.3]]
[[cut]]
time = 0.003
select = { body = "cube", springs = [9, 10] }
[[cut]]
time = 0.5
polygon = [[0.35, -1, -1], [0.35, 4, -1], [0.35, 4, 5], [0.35, -1, 5]]
[[move]]
select = { body = "chain", nodes = [0] }
sinusoid = { amplitude = [0.01, 0, 0.02], frequency = 2.0, phase = 0.7 }
from = 0.001
until = 1.0
[[move]]
select = { body = "flesh", nodes = [0, 1] }
table = [[0, 0, 0, 0], [1, 0.1, 0, 0]]
interpolation = "linear"
[[plane]]
name = "floor"
point = [0, 0, 0.45]
normal = [0.1, 0.2, 3]
friction = 0.3
restitution = 0.2
motion = { table = [[0, 0, 0, 0], [1, 0, 0, 0.01]] }
turn = { axis = [1, 1, 0.3], rate = 0.01, from = 0.1 }
[[instrument]]
name = "ball"
sphere = { center = [0.4, 0.1, 1.3], radius = 0.3 }
friction = "none"
[[instrument]]
capsule = { from = [-3, 0, 0.5], to = [-2, 1, 0.5], radius = 0.3 }
turn = { axis = [0, 0, 1], through = [1, 1, 1], table = [[0, 0], [1, 0.4]] }
[[instrument]]
name = "block"
box = { center = [-5, 0, 2], size = [1, 0.5, 0.7], rotation = { axis = [1, 2, 3], angle = 0.7 }, radius = 0.05 }
[[input]]
input = "activation"
name = "arm"
times = [0, 0.01, 0.02]
values = [0, 0.5, 1]
interpolation = "cubic"
)scene";

}  // namespace

TEST_CASE("a scene of everything is read back the same, bit for bit") {
  const Scene scene = read(everything);
  const std::string text = to_scene(scene, *plugins());
  const Scene back = read(text);
  check_same_nets(scene.network, back.network);
  check_same_settings(scene, back);
  check_same_motion(scene, back, 20);
  // What is written of what was written is the same text. (Scales of a formula's parameters come from its first use.)
  const std::string second = to_scene(back, *plugins());
  check_same_motion(back, read(second), 20);
  CHECK((to_scene(read(second), *plugins()) == second));
}

TEST_CASE("every example is read back the same") {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(SPRINGNET_EXAMPLES)) {
    if (entry.path().extension() != ".toml") continue;
    CAPTURE(entry.path().string());
    Scene scene;
    try {
      scene = load_scene(entry.path(), *plugins());
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::plugin || std::string(error.what()).find("plugin") != std::string::npos) continue;
      throw;
    }
    ++count;
    const Scene back = read(to_scene(scene, *plugins()));
    check_same_nets(scene.network, back.network);
    check_same_settings(scene, back);
    check_same_motion(scene, back, 3);
  }
  CHECK(count >= 15);
}

TEST_CASE("many values of springs are in tables, and are read back the same, bit for bit") {
  Scene scene = read(everything);
  Network& net = scene.network;
  const auto vary = [&](MaterialIndex own, std::size_t k) {
    Material material = net.materials()[own];
    for (auto* const law : {&material.spring, &material.viscosity})
      if (*law)
        for (auto& [name, value] : (*law)->parameters)
          if (name == "stiffness" || name == "damping" || name == "strength") value *= 1.0 + 0.1 / (1.0 + double(k));
    return net.add_material(material);
  };
  for (SpringIndex k = 0; k < net.springs().size(); ++k) net.set_spring_material(k, vary(net.springs()[k].material, k));
  const SceneWithTables written = to_scene_with_tables(scene, *plugins(), "varied");
  CHECK((written.scene.size() < to_scene(scene, *plugins()).size() / 2));
  REQUIRE(written.tables.size() == 1);
  CHECK(written.tables[0].name == "varied_springs.csv");
  const TemporaryFolder folder;
  for (const SceneTable& each : written.tables) folder.write(each.name, each.text);
  const Scene back = parse_scene(written.scene, "written", *plugins(), {}, folder.path());
  check_same_nets(scene.network, back.network);
  check_same_motion(scene, back, 20);
}

TEST_CASE("few laws stand in the scene itself") {
  Network net;
  for (int k = 0; k < 9; ++k) net.add_node({{0.1 * k, 0, 0}});
  for (NodeIndex k = 0; k + 1 < 9; ++k)
    net.add_spring(k, k + 1, net.add_material({LawUse{"linear", {{"stiffness", 1.0 + k}}}, std::nullopt}));
  const SceneWithTables written = to_scene_with_tables(scene_of(net), *plugins(), "few");
  CHECK(written.tables.empty());
  CHECK((written.scene == to_scene(scene_of(net), *plugins())));
}

TEST_CASE("elements with values of their own are one table") {
  Network net;
  net.begin_body("a");
  for (int k = 0; k < 30; ++k) net.add_node({{0.1 * k, 0.01 * k * k, 0}});
  net.end_body();
  for (NodeIndex k = 0; k + 2 < 30; ++k) {
    const double stiffness = k == 3 ? 1.0 : 1.0 + k;
    net.add_element(Invariant::angle, {k, k + 1, k + 2},
                    net.add_material({LawUse{"linear", {{"stiffness", stiffness}}}, std::nullopt}), 3.0 - 0.01 * k);
  }
  const SceneWithTables written = to_scene_with_tables(scene_of(net), *plugins(), "learned");
  REQUIRE(written.tables.size() == 1);
  CHECK(written.tables[0].name == "learned_elements.csv");
  CHECK(written.tables[0].text.starts_with("element,spring.stiffness\n1,2.0\n2,3.0\n4,5.0\n"));
  const TemporaryFolder folder;
  folder.write(written.tables[0].name, written.tables[0].text);
  check_same_nets(net, parse_scene(written.scene, "written", *plugins(), {}, folder.path()).network);
}

TEST_CASE("connections with values of their own are one table") {
  Network net;
  net.begin_body("a");
  for (int k = 0; k < 30; ++k) net.add_node({{0.1 * k, 0, 0}});
  net.end_body();
  for (NodeIndex k = 0; k + 1 < 30; ++k) {
    const LawUse spring{"linear", {{"stiffness", 1.0 + k}}},
        other{"exponential", {{"stiffness", 1.0 + k}, {"exponent", 2.0}}};
    net.add_spring(k, k + 1, net.add_material({k < 15 ? spring : other, std::nullopt}), k == 20 ? 0.2 : 0.1);
  }
  const SceneWithTables written = to_scene_with_tables(scene_of(net), *plugins(), "learned");
  REQUIRE(written.tables.size() == 2);
  CHECK(written.tables[0].name == "learned_springs.csv");
  CHECK(written.tables[1].name == "learned_springs_2.csv");
  CHECK(written.tables[0].text.starts_with("spring,spring.stiffness\n1,2"));
  const TemporaryFolder folder;
  for (const SceneTable& each : written.tables) folder.write(each.name, each.text);
  check_same_nets(net, parse_scene(written.scene, "written", *plugins(), {}, folder.path()).network);
}

TEST_CASE("the present state of a simulation starts with the same forces when it is read back") {
  Scene scene = read(everything);
  Simulation simulation(scene.network, plugins(), scene.options);
  simulation.advance_to(0.1);
  scene.network = simulation.present_network();
  scene.elements.clear();
  scene.output = {};
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "present.toml";
  write_scene(scene, *plugins(), file);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "present.toml.part"));
  const Scene back = load_scene(file, *plugins());
  check_same_nets(scene.network, back.network);
  const Simulation from_memory(scene.network, plugins(), scene.options),
      from_file(back.network, plugins(), back.options);
  CHECK(from_memory.in_user_order(from_memory.forces()) == from_file.in_user_order(from_file.forces()));
  CHECK(simulation.in_user_order(simulation.positions()) == from_file.in_user_order(from_file.positions()));
}

TEST_CASE("nodes, springs and faces of no body are written too, in their order") {
  Network net;
  const MaterialIndex soft = net.add_material(damped(1.0 / 3.0, 0.0)), hard = net.add_material(damped(7.0, 0.1));
  net.add_node(point({0.1, 0.2, -0.0}));
  net.add_node(point({1, 0, 0}, 1.0 / 3.0));
  net.add_node(point({0, 1, 0}));
  net.add_spring(0, 1, hard);
  net.add_face({0, 1, 2});
  net.begin_body("a \"body\"");
  net.add_node(point({3, 0, 0}));
  net.add_node(point({4, 0, 0}));
  net.add_spring(3, 4, soft);
  net.end_body();
  net.add_spring(0, 1, soft, 0.123456789012345678);
  net.add_spring(2, 4, hard, 1e-3);
  const Scene back = read(to_scene(scene_of(net), *plugins()));
  REQUIRE(back.network.bodies().size() == 2);
  CHECK(back.network.bodies()[0].name == "nodes");
  CHECK(back.network.bodies()[1].name == "a \"body\"");
  REQUIRE(back.network.springs().size() == 4);
  for (SpringIndex s = 0; s < 4; ++s) {
    CHECK(back.network.springs()[s].first == net.springs()[s].first);
    CHECK(back.network.springs()[s].rest_length == net.springs()[s].rest_length);
    CHECK(same_material(net, net.springs()[s].material, back.network, back.network.springs()[s].material));
  }
  CHECK(back.network.faces() == net.faces());
  CHECK(std::signbit(back.network.nodes()[0].position.z()));
  CHECK(back.network.nodes()[1].mass == 1.0 / 3.0);
}

TEST_CASE("what a scene cannot say is an error that names it") {
  const auto refused = [](const Network& net, const std::string& what) {
    try {
      static_cast<void>(to_scene(scene_of(net), *plugins()));
      FAIL("not refused: " << what);
    } catch (const Error& error) {
      CAPTURE(error.what());
      CHECK(error.kind() != ErrorKind::simulation);
      CHECK(std::string(error.what()).find(what) != std::string::npos);
    }
  };
  refused(Network(), "has none");
  Network net;
  net.begin_body("first");
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}));
  net.end_body();
  net.begin_body("second");
  net.add_node(point({0, 1, 0}));
  net.end_body();
  net.add_face({0, 1, 2});
  refused(net, "face 0");
  Network unknown;
  unknown.add_node(point({0, 0, 0}));
  unknown.add_node(point({1, 0, 0}));
  unknown.add_spring(0, 1, unknown.add_material({LawUse{"no such law", {}}, std::nullopt}));
  refused(unknown, "no such law");
  const Network fine = oscillator(damped(1.0, 0.0), 1.0, 0.1);
  CHECK_THROWS_AS(write_scene(scene_of(fine), *plugins(), "/no/such/folder/scene.toml"), Error);
}

TEST_CASE("changes at times are written") {
  Network net = cube(30.0, 2.0, 9.81, 0.02);
  const SpringIndex spring = 5;
  const ElementIndex area = net.add_element(Invariant::area, {0, 1, 4}, net.springs().materials()[0]);
  Change laws;
  laws.time = 0.01;
  laws.springs = {spring, 7};
  laws.elements = {area};
  laws.spring = {{"stiffness", 12.5}};
  laws.reference_scale = 1.25;
  net.add_change(laws);
  Change nodes;
  nodes.time = 0.02;
  nodes.nodes = {3};
  nodes.mass = 2.5;
  nodes.integrator = LawUse{"recurrent", {{"theta", 0.5}}};
  net.add_change(nodes);
  Change removal;
  removal.time = 0.03;
  removal.springs = {9};
  removal.nodes = {11};
  removal.elements = {area};
  removal.remove = true;
  net.add_change(removal);
  Scene scene = scene_of(net);
  scene.options.time_step = 0.005;
  const Scene again = read(to_scene(scene, *plugins()));
  // One of several kinds is written as several.
  CHECK(again.network.changes().size() == 7);
  Simulation first(scene.network, plugins(), scene.options), second(again.network, plugins(), again.options);
  for (int step = 0; step < 10; ++step) {
    first.step();
    second.step();
    for (NodeIndex k = 0; k < first.node_count(); ++k) REQUIRE(first.position(k) == second.position(k));
  }
  CHECK(second.mass(3) == 2.5);
  CHECK(second.parameter(spring, ComponentKind::spring_function, "stiffness") == 12.5);
  CHECK_FALSE(second.alive(9));
  // Those that are still to come are in the present network.
  Simulation third(scene.network, plugins(), scene.options);
  third.advance_to(0.015);
  const Network present = third.present_network();
  CHECK(present.changes().size() == 2);
  CHECK(present.changes()[0].time == doctest::Approx(0.005));
  CHECK(present.changes()[1].springs == std::vector<SpringIndex>{9});
}
