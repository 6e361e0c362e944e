// Forces that hold, move and join nodes, in the tables.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <springnet/output.hpp>

#include "csv.hpp"
#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::Csv;
using testing::plugins;
using testing::point;
using testing::TemporaryFolder;

namespace {

Scene empty_scene(double duration, double time_step) {
  Scene scene;
  scene.duration = duration;
  scene.options.time_step = time_step;
  scene.options.threads = 1;
  scene.network.set_gravity({0, 0, -10});
  return scene;
}

RunSummary run_forces(const Scene& scene, const TemporaryFolder& folder) {
  const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "forces", {}});
  CAPTURE(summary.error);
  CHECK_FALSE(summary.failure);
  return summary;
}

Vector3 vector(const Csv& csv, std::size_t row, std::size_t column) {
  return {csv.number(row, column), csv.number(row, column + 1), csv.number(row, column + 2)};
}

// Forces of a step come from a system that is solved to 1e-6 of the greatest force, unless a test says otherwise.
constexpr double settling = 1e-5;

}  // namespace

TEST_CASE(
    "reactions: the force on a moved node is its weight and mass times acceleration, with the torque about the "
    "origin") {
  const TemporaryFolder folder;
  constexpr double h = 0.001, mass = 2.0, amplitude = 0.1, rate = std::numbers::pi;  // m, rad/s
  Scene scene = empty_scene(1.0, h);
  scene.network.add_node(point({1, 2, 3}, mass));
  Motion motion;
  motion.amplitude = Vector3(amplitude, 0, 0);
  motion.frequency = rate / (2 * std::numbers::pi);
  motion.phase = std::numbers::pi / 2;
  scene.network.add_move({{0}, motion});
  scene.output.reactions = true;
  run_forces(scene, folder);

  const Csv forces = testing::read_csv(folder.path() / "reactions.csv");
  const Csv places = testing::read_csv(folder.path() / "trajectory.csv");
  CHECK(forces.header == "time,node,fx,fy,fz,tx,ty,tz,jx,jy,jz,surface");
  REQUIRE(forces.rows.size() == 1001);
  REQUIRE(places.rows.size() == 1001);
  for (std::size_t row = 0; row < forces.rows.size(); row += 50) {
    const double t = forces.number(row, 0);
    CAPTURE(t);
    const Vector3 force = vector(forces, row, 2), place = vector(places, row, 2);
    // Rounding of numbers near 1 and 20.
    CHECK((place - Vector3(1 + amplitude * (std::cos(rate * t) - 1), 2, 3)).norm() < 1e-14);
    const double acceleration = -amplitude * rate * rate * std::cos(rate * t);
    // A difference of velocities over a step would be off by half a step's change of the acceleration.
    const double tolerance = mass * amplitude * rate * rate * rate * h;
    CHECK((force - Vector3(mass * acceleration, 0, mass * 10)).norm() < tolerance);
    CHECK((vector(forces, row, 5) - place.cross(force)).norm() < 1e-12);
  }
}

TEST_CASE("surfaces: a plate's weight on the floor, its torque, and an instrument that passes by") {
  const TemporaryFolder folder;
  Scene scene = empty_scene(0.5, 0.05);
  const MaterialIndex material = scene.network.add_material(testing::damped(100.0, 5.0));
  scene.network.add_lattice("plate", {{2, 2, 1}, Vector3::Ones(), Vector3::Zero(), Diagonals::face},
                            point(Vector3::Zero(), 1.5), material);
  scene.network.add_plane({"floor", Vector3(0.25, -0.5, 0), Vector3::UnitZ()});
  Motion motion;
  motion.interpolation = Motion::Interpolation::linear;
  motion.times = {0.1, 0.3};
  motion.displacements = {Vector3::Zero(), Vector3(0, 2, 0)};
  scene.network.add_instrument({"", Vector3(0, 0, 5), Vector3(0, 0, 6), 1.0, {}, motion});
  run_forces(scene, folder);

  const Csv csv = testing::read_csv(folder.path() / "surfaces.csv");
  CHECK(csv.header == "time,surface,x,y,z,fx,fy,fz,tx,ty,tz,nodes,jx,jy,jz");
  REQUIRE(csv.rows.size() == 22);  // 11 records of two surfaces
  for (std::size_t row = 0; row < csv.rows.size(); row += 2) {
    CAPTURE(row);
    CHECK(csv.rows[row][1] == "floor");
    CHECK(vector(csv, row, 2) == Vector3(0.25, -0.5, 0));
    // Four nodes of 15 N; their arms from the plane's point add up to (1, 4, 0) m.
    CHECK((vector(csv, row, 5) - Vector3(0, 0, -60)).norm() < 60 * settling);
    CHECK((vector(csv, row, 8) - Vector3(-60, 15, 0)).norm() < 60 * settling);
    CHECK(csv.number(row, 11) == 4);

    const double t = csv.number(row + 1, 0);
    CHECK(csv.rows[row + 1][1] == "1");
    const double way = 2 * std::min(1.0, std::max(0.0, (t - 0.1) / 0.2));
    CHECK((vector(csv, row + 1, 2) - Vector3(0, way, 5)).norm() < 1e-14);  // rounding
    CHECK(vector(csv, row + 1, 5) == Vector3::Zero());
    CHECK(vector(csv, row + 1, 8) == Vector3::Zero());
    CHECK(csv.number(row + 1, 11) == 0);
  }
}

TEST_CASE("rigid connections: the tension is the weight below") {
  const TemporaryFolder folder;
  Scene scene = empty_scene(0.2, 0.05);
  scene.network.add_node(point({0, 0, 0}));
  scene.network.add_node(point({0, 0, -1}, 3.0));
  scene.network.add_node(point({0, 0, -3}, 2.0));
  scene.network.fix(0);
  scene.network.add_rigid(0, 1);
  scene.network.add_rigid(2, 1);
  const RunSummary summary = run_forces(scene, folder);
  CHECK(summary.files ==
        std::vector<std::string>{"events.csv", "trajectory.csv", "rigid.csv", "view.html", "summary.json"});
  const Csv csv = testing::read_csv(folder.path() / "rigid.csv");
  CHECK(csv.header == "time,rigid,force");
  REQUIRE(csv.rows.size() == 10);
  for (std::size_t row = 0; row < csv.rows.size(); row += 2) {
    CHECK(csv.rows[row][1] == "0");
    CHECK(csv.number(row, 2) == doctest::Approx(50).epsilon(settling));
    CHECK(csv.rows[row + 1][1] == "1");
    CHECK(csv.number(row + 1, 2) == doctest::Approx(20).epsilon(settling));
  }
}

TEST_CASE("friction: a node that is pushed slips and sticks, and the tables say so") {
  const TemporaryFolder folder;
  constexpr double h = 0.002;
  Scene scene = empty_scene(0.6, h);
  scene.network.add_node(point({0, 0, 0}));
  scene.network.add_plane({"", Vector3::Zero(), Vector3::UnitZ(), {Friction::Kind::coulomb, 0.5}});
  scene.network.add_load({{0}, Vector3(8, 0, 0), 0.1, 0.3});
  scene.output.reactions = true;
  const RunSummary summary = run_forces(scene, folder);
  CHECK(summary.events.slipped == 1);
  CHECK(summary.events.stuck >= 1);  // once more where it lay at the start, if that counts as coming to rest
  CHECK(summary.events.released == 0);

  const Csv events = testing::read_csv(folder.path() / "events.csv");
  REQUIRE(events.rows.size() >= 2);
  const std::size_t slip = events.rows.size() - 2;
  CHECK(events.rows[slip][1] == "slipped");
  CHECK(events.rows[slip][2] == "node");
  CHECK(events.rows[slip][3] == "0");
  // 8 N against 5 N of friction for 0.2 s: 0.6 m/s, which 5 N stop in 0.12 s. Each within the step that sees it.
  CHECK(std::abs(events.number(slip, 0) - 0.1) < 1.5 * h);
  CHECK(events.rows[slip + 1][1] == "stuck");
  CHECK(std::abs(events.number(slip + 1, 0) - 0.42) < 2.5 * h);

  const Csv csv = testing::read_csv(folder.path() / "reactions.csv");
  std::size_t sliding = 0;
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    const double t = csv.number(row, 0);
    if (t > 0.1 + 2 * h && t < 0.42 - 2 * h) {
      CAPTURE(t);
      CHECK((vector(csv, row, 2) - Vector3(-5, 0, 10)).norm() < 10 * settling);
      ++sliding;
    }
  }
  CHECK(sliding > 100);
}

TEST_CASE("impulses: a fall has one, even if the node has separated again before the record") {
  const TemporaryFolder folder;
  // From 0.2 m to the floor in 0.2 s, with 2 m/s; from 0.25 s to 0.28 s a force takes it up again.
  Scene scene = empty_scene(0.5, 0.001);
  scene.network.add_node(point({0, 0, 0.2}, 0.5, {1, 0, 0}));
  scene.network.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ(), {Friction::Kind::none, 0.0}});
  scene.network.add_load({{0}, Vector3(0, 0, 50), 0.25, 0.28});
  scene.output.interval = 0.15;
  scene.output.reactions = true;
  run_forces(scene, folder);
  const Csv reactions = testing::read_csv(folder.path() / "reactions.csv");
  REQUIRE(reactions.rows.size() == 1);  // not at 0.45 s: nothing has touched it since
  CHECK(reactions.number(0, 0) == doctest::Approx(0.3));
  CHECK(reactions.rows[0][11] == "");
  CHECK(vector(reactions, 0, 2) == Vector3::Zero());
  // It touches within a step: off by what the weight of 5 N does in 1 ms.
  const Vector3 impulse = vector(reactions, 0, 8);
  CHECK((impulse - Vector3(0, 0, 0.5 * 2.0)).norm() <= 5.0 * 0.001 + 1e-12);
  // The floor got the opposite, and keeps it in every record that follows.
  const Csv surfaces = testing::read_csv(folder.path() / "surfaces.csv");
  REQUIRE(surfaces.rows.size() == 5);
  for (std::size_t row = 0; row < surfaces.rows.size(); ++row) {
    CAPTURE(row);
    CHECK((vector(surfaces, row, 12) + (row < 2 ? Vector3(Vector3::Zero()) : impulse)).norm() <= 1e-12);
  }
  const Csv events = testing::read_csv(folder.path() / "events.csv");
  REQUIRE(events.rows.size() == 2);
  CHECK(events.rows[0][1] == "touched");
  CHECK(events.number(0, 0) == doctest::Approx(0.2).epsilon(0.006));
  CHECK((vector(events, 0, 5) - impulse).norm() <= 1e-12);
  CHECK(events.rows[1][1] == "released");
  CHECK(vector(events, 1, 5) == Vector3::Zero());
  for (const auto& row : events.rows) CHECK(row[4] == "floor");
}

TEST_CASE("a node in a corner has both surfaces in its row") {
  const TemporaryFolder folder;
  Scene scene = empty_scene(0.2, 0.01);
  scene.options.integrator = testing::cvode(1e-8);
  scene.network.add_node(point({0.1, 0, 0}, 0.5, {1, 0, 0}));
  const Friction smooth{Friction::Kind::none, 0.0};
  scene.network.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ(), smooth});
  scene.network.add_plane({"", Vector3(0.2, 0, 0), -Vector3::UnitX(), smooth});
  scene.network.add_load({{0}, Vector3(3, 0, 0)});
  scene.output.reactions = true;
  run_forces(scene, folder);
  const Csv reactions = testing::read_csv(folder.path() / "reactions.csv");
  REQUIRE_FALSE(reactions.rows.empty());
  CHECK(reactions.rows.front()[11] == "floor");
  const std::string both = reactions.rows.back()[11];
  CHECK((both == "floor;1" || both == "1;floor"));
}

TEST_CASE("tables of forces are left out on request, and old ones are removed") {
  const TemporaryFolder folder;
  Scene scene = empty_scene(0.1, 0.05);
  scene.network.add_node(point({0, 0, 1}));
  scene.network.add_node(point({1, 0, 1}));
  scene.network.add_rigid(0, 1);
  scene.network.add_plane({});
  run_forces(scene, folder);
  CHECK(std::filesystem::exists(folder.path() / "surfaces.csv"));
  CHECK(std::filesystem::exists(folder.path() / "rigid.csv"));
  scene.output.surfaces = false;
  scene.output.rigid = false;
  scene.output.view = false;
  CHECK(run_forces(scene, folder).files == std::vector<std::string>{"events.csv", "trajectory.csv", "summary.json"});
  CHECK_FALSE(std::filesystem::exists(folder.path() / "surfaces.csv"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "rigid.csv"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "view.html"));
}

TEST_CASE("the summary has the notes of the program, of the scene and of the simulation") {
  const TemporaryFolder folder;
  Scene scene = empty_scene(0.1, 0.05);
  scene.network.add_node(point({0, 0, 1}));
  scene.network.add_load({{0}, Vector3::UnitX(), 7.0, 8.0});
  const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "notes", {}, {"From outside."}});
  REQUIRE(summary.notes.size() >= 2);
  CHECK(summary.notes[0] == "From outside.");
  CHECK(summary.notes[1] == "Force 0, which starts at 7 s, is outside of the simulated time, 0 to 0.1 s.");
  const Simulation simulation(scene.network, plugins(), scene.options);
  for (const std::string& note : simulation.notes()) {
    CHECK(std::find(summary.notes.begin() + 2, summary.notes.end(), note) != summary.notes.end());
  }
  const auto json = nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"));
  CHECK(json["notes"] == summary.notes);
  CHECK(json["divided_steps"] == 0);
  CHECK(json["substeps"] == 0);
  CHECK(json["stages"] == 0);
}
