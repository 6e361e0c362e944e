// [[change]] in scenes, against the same changes by the program, and against cvode.

#include <string>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/scene.hpp>

#include "mixed_net.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

const std::string block = R"(
[simulation]
duration = 0.4
time_step = 0.01
integrator = { name = "verlet", substeps = 10 }
[gravity]
acceleration = [0, 0, -2]
[[body]]
name = "block"
mesh = { lattice = [4, 4, 3], spacing = 1.0, diagonals = "face" }
neuron = { type = "dragged", mass = 1.0, drag = 0.1 }
spring = { type = "linear", stiffness = 200.0 }
viscosity = { type = "linear", damping = 1.0 }
[[fix]]
select = { body = "block", box = { min = [0, 0, 2], max = [9, 9, 2] } }
)";

Scene read(const std::string& more) { return parse_scene(block + more, "test.toml", *plugins()); }

std::string refusal(const std::string& more) {
  try {
    static_cast<void>(read(more));
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return {};
}

Simulation start(const Scene& scene) {
  SimulationOptions options = scene.options;
  options.threads = 1;
  return {scene.network, plugins(), options};
}

const std::string changes = R"(
[[change]]
time = 0.1
select = { body = "block", box = { min = [0, 0, 0], max = [1.5, 9, 9] } }
spring = { stiffness = 500.0 }
viscosity = { damping = 2.0 }
rest_length_scale = 0.9
[[change]]
time = 0.2
select = { nodes = [0, 1, 2] }
mass = 2.0
neuron = { drag = 0.5 }
[[change]]
time = 0.3
select = { springs = [5, 6, 7] }
remove = "springs"
)";

}  // namespace

TEST_CASE("changes of a scene are those of the program at these times") {
  const Scene scene = read(changes);
  REQUIRE(scene.network.changes().size() == 3);
  Simulation own = start(scene), other = start(read(""));
  const Change& first = scene.network.changes()[0];
  own.advance_to(0.4);
  other.advance_to(0.1);
  other.set_parameter(first.springs, ComponentKind::spring_function, "stiffness", {500.0});
  other.set_parameter(first.springs, ComponentKind::viscosity_function, "damping", {2.0});
  std::vector<double> lengths;
  for (const SpringIndex s : first.springs) lengths.push_back(0.9 * other.rest_length(s));
  other.set_rest_lengths(first.springs, lengths);
  other.advance_to(0.2);
  other.set_masses({0, 1, 2}, {2.0});
  other.set_neuron_parameter({0, 1, 2}, "drag", {0.5});
  other.advance_to(0.3);
  other.cut({5, 6, 7});
  other.advance_to(0.4);
  CHECK(distance(own, other) < 1e-12);
  CHECK_FALSE(own.alive(6));
  CHECK(own.mass(1) == 2.0);
  CHECK(own.rest_length(first.springs[0]) == other.rest_length(first.springs[0]));
}

TEST_CASE("results converge to those of cvode, for changes at the ends of steps and between them") {
  std::string between = changes;
  const auto put_off = [&](const std::string& from, const std::string& to) {
    between.replace(between.find("time = " + from + "\n"), 7 + from.size(), "time = " + to);
  };
  put_off("0.1", "0.1037");
  put_off("0.2", "0.2081");
  put_off("0.3", "0.2953");
  const auto error_of = [](Scene scene, const LawUse& integrator, double time_step) {
    scene.options.integrator = cvode(1e-10);
    Simulation reference = start(scene);
    scene.options.integrator = integrator;
    scene.options.time_step = time_step;
    Simulation simulation = start(scene);
    reference.advance_to(0.4);
    simulation.advance_to(0.4);
    return distance(simulation, reference);
  };
  double before = 0.0;
  for (const double substeps : {10.0, 20.0, 40.0}) {
    const LawUse verlet{"verlet", {{"substeps", substeps}}};
    const double error = error_of(read(changes), verlet, 0.01);
    // Second order: a quarter for half the step.
    if (before > 0.0) CHECK(error < 0.3 * before);
    before = error;
    // Each change is late by up to a step.
    CHECK(error_of(read(between), verlet, 0.01) < 2.5 * 0.01 / substeps);
  }
  CHECK(before < 1e-5);
  CHECK(error_of(read(between), {"verlet", {{"substeps", 320.0}}}, 0.01) < 1e-4);
  CHECK(error_of(read(between), testing::generalized_alpha(), 0.001) < 1e-4);
  CHECK(error_of(read(between), cvode(1e-6), 0.02) < 1e-5);
}

TEST_CASE("a scene exchanges its integrator, within a step as well") {
  Scene scene = read(R"(
[[change]]
time = 0.153
integrator = { name = "cvode", relative_tolerance = 1e-8 }
[[change]]
time = 0.3
integrator = "generalized_alpha"
)");
  Simulation own = start(scene), other = start(read(""));
  own.advance_to(0.4);
  other.advance_to(0.153);
  other.set_integrator(cvode(1e-8));
  other.advance_to(0.16);
  other.advance_to(0.3);
  other.set_integrator({"generalized_alpha", {}});
  other.advance_to(0.4);
  CHECK(distance(own, other) < 1e-7);
  CHECK(own.time() == 0.4);
  bool noted = false;
  for (const std::string& note : own.notes())
    noted = noted || note.find("0.153 s on the integrator is 'cvode'") != std::string::npos;
  CHECK(noted);
  // Saved after the exchange, it goes on with the second integrator, and to the third.
  Simulation saved = start(scene), restored = start(scene);
  saved.advance_to(0.2);
  restored.restore(saved.save());
  saved.advance_to(0.4);
  restored.advance_to(0.4);
  CHECK(distance(saved, restored) == 0.0);
}

TEST_CASE("mistakes in a change are told with their place") {
  const auto has = [](const std::string& text, std::string_view part) {
    CHECK_MESSAGE(text.find(part) != std::string::npos, text);
  };
  has(refusal("[[change]]\ntime = 0.1\n"), "changes nothing");
  has(refusal("[[change]]\nselect = { body = \"block\" }\nmass = 1.0\n"), "time");
  has(refusal("[[change]]\ntime = 0.1\nselect = { body = \"block\" }\nspring = { stifness = 1.0 }\n"), "stiffness");
  has(refusal("[[change]]\ntime = 0.1\nselect = { body = \"block\" }\nspring = { stiffness = -1.0 }\n"), "-1");
  has(refusal("[[change]]\ntime = 0.1\nspring = { stiffness = 1.0 }\n"), "select");
  has(refusal("[[change]]\ntime = 0.1\nselect = { body = \"block\" }\nrest_length = 1.0\nrest_length_scale = 2.0\n"),
      "remove one of them");
  has(refusal("[[change]]\ntime = 0.1\nselect = { body = \"block\" }\nreference = 1.0\n"), "elements");
  has(refusal("[[change]]\ntime = 0.1\nselect = { body = \"block\" }\nremove = \"faces\"\n"), "remove");
  has(refusal("[[change]]\ntime = 0.1\nintegrator = \"cvod\"\n"), "cvode");
  has(notes_of(read("[[change]]\ntime = 3.0\nselect = { body = \"block\" }\nmass = 1.0\n")).back(), "Change 0 at 3 s");
}

TEST_CASE("a change that a network cannot have is refused where it is added, and by the simulation") {
  Network net = oscillator(damped(10.0, 1.0), 1.0, 0.1);
  Change change;
  CHECK_THROWS_AS(net.add_change(change), Error);
  change.mass = 2.0;
  CHECK_THROWS_AS(net.add_change(change), Error);
  change.nodes = {9};
  CHECK_THROWS_AS(net.add_change(change), Error);
  change.nodes = {1};
  change.time = -1.0;
  CHECK_THROWS_AS(net.add_change(change), Error);
  change.time = 0.1;
  net.add_change(change);
  change.springs = {0};
  change.spring["stifness"] = 3.0;
  net.add_change(change);
  CHECK_THROWS_AS(simulate(net, single_sweep(), 0.01), Error);
}

TEST_CASE("changes within one step are made in the order of their times, whatever their order in the network") {
  for (const auto& [integrator, step] : all_integrators()) {
    CAPTURE(integrator.id);
    Network net = cube(300.0, 2.0, 0.0, 1.0);
    for (const auto& [time, stiffness] : {std::pair(0.8 * step, 500.0), std::pair(0.2 * step, 900.0)}) {
      Change change;
      change.time = time;
      change.springs = {3};
      change.spring = {{"stiffness", stiffness}};
      net.add_change(change);
    }
    Simulation simulation = simulate(net, integrator, step);
    simulation.step();
    CHECK(simulation.parameter(3, ComponentKind::spring_function, "stiffness") == 500.0);
  }
}
