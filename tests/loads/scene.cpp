// [[force]] in scenes.
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "../scene/scenes.hpp"

using namespace springnet;

namespace {

// The top of the lattice of 3 x 3 x 3 nodes: 9 nodes, 8 triangles, 4 m^2.
const std::string top = "[[force]]\nselect = { box = { min = [-inf, -inf, 2] } }\n";

Load load_of(const std::string& keys, const std::string& head = top) {
  return parse(small + head + keys).network.loads().at(0);
}

bool says(const std::string& text, const std::string& part) {
  CAPTURE(text);
  return text.find(part) != std::string::npos;
}

Vector3 area_of(const Load& load) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& area : load.areas) sum += area;
  return sum;
}

}  // namespace

TEST_CASE("force acts on each node, traction and pressure on the faces between selected nodes") {
  const Load each = load_of("force = [1, 2, 3]\n");
  CHECK(each.nodes.size() == 9);
  CHECK(each.force == Vector3(1, 2, 3));
  CHECK(each.faces.empty());
  const Load pulled = load_of("traction = [1, 2, 3]\n");
  CHECK(pulled.nodes.empty());
  CHECK(pulled.faces.size() == 8);
  CHECK(pulled.traction == Vector3(1, 2, 3));
  CHECK((area_of(pulled) - Vector3(0, 0, 4)).norm() <= 1e-15);  // outward
  const Load pressed = load_of("pressure = 100\nfollow = true\n");
  CHECK(pressed.faces.size() == 8);
  CHECK(pressed.pressure == 100.0);
  CHECK(pressed.follow);
  CHECK_FALSE(load_of("pressure = 100\n").follow);
}

TEST_CASE("a total is shared by area on a surface, equally elsewhere, or as `share` says") {
  const Load by_area = load_of("total = [0, 0, -8]\n");
  CHECK(by_area.nodes.empty());
  CHECK((by_area.traction - Vector3(0, 0, -2)).norm() <= 1e-15);
  const Load shared = load_of("total = [0, 0, -9]\nshare = 'nodes'\n");
  CHECK(shared.nodes.size() == 9);
  CHECK(shared.force == Vector3(0, 0, -1));
  const std::string all = "[[force]]\nselect = {}\n";
  CHECK(load_of("total = [27, 0, 0]\n", all).force == Vector3(1, 0, 0));  // one node is within
  CHECK(load_of("total = [24, 0, 0]\nshare = 'area'\n", all).traction == Vector3(1, 0, 0));
}

TEST_CASE("of a group the triangles that belong to it") {
  const std::string bar = simulation + R"([[body]]
name = "bar"
mesh = { file = "bar.msh", scale = 0.001 }
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 3.0 }
)";
  const Load load = parse(bar + "[[force]]\nselect = { group = 'right' }\npressure = 1\n").network.loads().at(0);
  CHECK((area_of(load) - Vector3(4e-4, 0, 0)).norm() <= 1e-12);  // 20 x 20 mm
}

TEST_CASE("a load changes over time by a table, a sinusoid or a ramp") {
  const Course table =
      load_of("force = [1, 0, 0]\ntable = [[0, 0], [0.5, 1], [1, 0.25]]\ninterpolation = 'linear'\n").course;
  CHECK(table.times == std::vector<double>{0, 0.5, 1});
  CHECK(table.factors == std::vector<double>{0, 1, 0.25});
  CHECK(table.interpolation == Motion::Interpolation::linear);
  const Course wave =
      load_of("pressure = 1\nsinusoid = { frequency = 2, phase = 0.1, amplitude = 3, mean = 4 }\n").course;
  CHECK(wave.frequency == 2.0);
  CHECK(wave.phase == 0.1);
  CHECK(wave.amplitude == 3.0);
  CHECK(wave.mean == 4.0);
  CHECK(load_of("pressure = 1\nsinusoid = { frequency = 2 }\n").course.amplitude == 1.0);
  const Load ramp = load_of("total = [1, 0, 0]\nramp = 0.2\nfrom = 0.1\nuntil = 0.9\n");
  CHECK(ramp.course.ramp == 0.2);
  CHECK(ramp.from == 0.1);
  CHECK(ramp.until == 0.9);
}

TEST_CASE("contradictory keys are refused with their position in the file") {
  const auto refused = [](const std::string& keys, const std::string& head = top) {
    return refusal(small + head + keys);
  };
  CHECK(says(refused("from = 0\n"), "force.0: does not say what acts"));
  CHECK(says(refused("force = [1, 0, 0]\npressure = 1\n"), "test.toml:12"));
  CHECK(says(refused("force = [1, 0, 0]\npressure = 1\n"), "cannot be combined with 'force'"));
  CHECK(says(refused("force = [1, 0, 0]\nfollow = true\n"), "requires 'pressure'"));
  CHECK(says(refused("pressure = 1\nshare = 'area'\n"), "requires 'total'"));
  CHECK(
      says(refused("pressure = 1\n", "[[force]]\nselect = { nodes = [0, 13] }\n"), "force.0.select: has no triangle"));
  CHECK(says(refused("total = [1, 0, 0]\nshare = 'area'\n", "[[force]]\nselect = { nodes = [13] }\n"),
             "has no triangle"));
  CHECK(says(refused("pressure = 1\nramp = 1\nsinusoid = { frequency = 1 }\n"), "cannot be combined with 'sinusoid'"));
  CHECK(says(refused("pressure = 1\nramp = 1\ntable = [[0, 0], [1, 1]]\n"), "cannot be combined with 'table'"));
  CHECK(says(refused("pressure = 1\ninterpolation = 'linear'\n"), "requires 'table'"));
  CHECK(says(refused("pressure = 1\ntable = [[0, 0], [0, 1]]\n"), "times must increase"));
  CHECK(says(refused("pressure = 1\ntable = [[0, 0], [1, 0]]\n"), "nothing would act"));
  CHECK(says(refused("pressure = 1\ntable = [[0, 0]]\n"), "two rows [t, factor]"));
  CHECK(says(refused("pressure = 1\nramp = 0\n"), "force.0.ramp"));
  CHECK(says(refused("pressure = 1\nsinusoid = { frequency = 0 }\n"), "force.0.sinusoid.frequency"));
}

TEST_CASE("loads that act on nothing, or never, are noted") {
  const auto notes = [](const std::string& keys) { return notes_of(parse(small + keys)); };
  const std::string fixed = "[[fix]]\nselect = { box = { min = [-inf, -inf, 2] } }\n";
  CHECK(notes(top + "pressure = 1\n").empty());
  REQUIRE(notes(fixed + top + "pressure = 1\n").size() == 1);
  CHECK(says(notes(fixed + top + "pressure = 1\n")[0], "Force 0 acts on fixed or moved nodes only"));
  REQUIRE(notes(top + "pressure = 1\ntable = [[2, 0], [3, 1]]\n").size() == 1);
  CHECK(says(notes(top + "pressure = 1\ntable = [[2, 0], [3, 1]]\n")[0], "The table of force 0, which starts at 2 s,"));
}
