// Exactly what a scene requests is recorded.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>
#include <springnet/output.hpp>
#include <springnet/records.hpp>

#include "csv.hpp"
#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::Csv;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

Scene chain_scene() {
  Scene scene;
  scene.network = testing::chain(4, {0, 0, 0}, {1, 0, 0}, testing::damped(40.0, 0.5));
  scene.network.fix(0);
  scene.network.fix(3);
  scene.network.set_gravity({0, 0, -10});
  scene.duration = 0.5;
  scene.options.time_step = 0.05;
  scene.options.threads = 1;
  return scene;
}

RunSummary run(const Scene& scene, const TemporaryFolder& folder) {
  const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "chain", {}});
  CHECK_MESSAGE(!summary.failure, summary.error);
  return summary;
}

}  // namespace

TEST_CASE("trajectory and reactions have the requested nodes and quantities") {
  const TemporaryFolder folder;
  Scene scene = chain_scene();
  run(scene, folder);
  const Csv all = testing::read_csv(folder.path() / "trajectory.csv");
  scene.output.nodes = {1, 3};
  scene.output.velocity = false;
  scene.output.force = true;
  scene.output.reactions = true;
  run(scene, folder);
  const Csv some = testing::read_csv(folder.path() / "trajectory.csv");
  CHECK(some.header == "time,node,x,y,z,fx,fy,fz");
  REQUIRE(all.rows.size() == 44);
  REQUIRE(some.rows.size() == 22);
  Simulation simulation(scene.network, plugins(), scene.options);
  for (std::size_t record = 0; record < 10; ++record) {  // the last one ends at the duration, a rounding beside a step
    if (record > 0) simulation.step();
    for (std::size_t k = 0; k < 2; ++k) {
      const NodeIndex node = k == 0 ? 1 : 3;
      const std::size_t row = 2 * record + k;
      // Time, node and place are those of the whole trajectory, to the letter.
      for (std::size_t column = 0; column < 5; ++column) {
        CHECK(some.rows[row][column] == all.rows[4 * record + node][column]);
      }
      for (int axis = 0; axis < 3; ++axis) {
        CHECK(some.number(row, 5 + static_cast<std::size_t>(axis)) == simulation.force(node)[axis]);
      }
    }
  }
  const Csv reactions = testing::read_csv(folder.path() / "reactions.csv");
  REQUIRE(reactions.rows.size() == 11);  // only node 3: 1 is free, 0 is not requested
  for (const auto& row : reactions.rows) CHECK(row[1] == "3");
}

TEST_CASE("springs.csv has lengths, tensions and energies by the law, and zeros once a spring is removed") {
  const TemporaryFolder folder;
  Scene scene = chain_scene();
  Network& net = scene.network;
  net.add_spring(0, 2, net.add_material({std::nullopt, LawUse{"linear", {{"damping", 0.25}}}}));  // spring 3
  net.add_cut({0.22, {2}, {}});
  scene.output.springs = {1, 2, 3};
  run(scene, folder);
  const Csv table = testing::read_csv(folder.path() / "springs.csv");
  CHECK(table.header == "time,spring,length,tension,energy,alive");
  REQUIRE(table.rows.size() == 33);
  const Csv states = testing::read_csv(folder.path() / "trajectory.csv");
  bool stretched = false;
  for (std::size_t record = 0; record < 11; ++record) {
    const auto state = [&](NodeIndex node, std::size_t column) {
      const std::size_t row = 4 * record + node;
      return Vector3(states.number(row, column), states.number(row, column + 1), states.number(row, column + 2));
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t row = 3 * record + k;
      const NodeIndex first = k == 0 ? 1 : k == 1 ? 2 : 0, second = k == 0 ? 2 : k == 1 ? 3 : 2;
      CAPTURE(row);
      CHECK(table.rows[row][0] == states.rows[4 * record][0]);
      CHECK(table.number(row, 1) == static_cast<double>(k + 1));
      const Vector3 reach = state(second, 2) - state(first, 2);
      // The same numbers in another order of operations: a few roundings.
      CHECK(table.number(row, 2) == doctest::Approx(reach.norm()).epsilon(1e-14));
      const bool alive = k != 1 || table.number(row, 0) < 0.22;
      CHECK(table.number(row, 5) == (alive ? 1.0 : 0.0));
      if (!alive) {
        CHECK(table.number(row, 3) == 0.0);
        CHECK(table.number(row, 4) == 0.0);
        continue;
      }
      const double extension = reach.norm() - 1.0;
      const double rate = (state(second, 5) - state(first, 5)).dot(reach) / reach.norm();
      const double tension = k < 2 ? 40.0 * extension + 0.5 * rate : 0.25 * rate;
      CHECK(table.number(row, 3) == doctest::Approx(tension).epsilon(1e-9));
      stretched = stretched || std::abs(tension) > 1e-3;
      // Potential energy of the linear spring; a damper stores none.
      if (k < 2) CHECK(table.number(row, 4) == doctest::Approx(20.0 * extension * extension).epsilon(1e-9));
    }
  }
  CHECK(stretched);
}

TEST_CASE("elements.csv has each element's invariant and force") {
  const TemporaryFolder folder;
  Scene scene = chain_scene();
  Node bent = scene.network.nodes()[2];  // a straight angle has no gradient
  bent.position.y() = 0.5;
  scene.network.set_node(2, bent);
  const MaterialIndex bending = scene.network.add_material({LawUse{"linear", {{"stiffness", 2.0}}}, std::nullopt});
  scene.network.add_element(Invariant::angle, {0, 1, 2}, bending);
  scene.network.add_element(Invariant::angle, {1, 2, 3}, bending);
  const RunSummary summary = run(scene, folder);
  CHECK(std::count(summary.files.begin(), summary.files.end(), "elements.csv") == 1);
  const Csv table = testing::read_csv(folder.path() / "elements.csv");
  CHECK(table.header == "time,element,value,force,alive");
  REQUIRE(table.rows.size() == 22);
  Simulation simulation(scene.network, plugins(), scene.options);
  for (std::size_t record = 0; record < 10; ++record) {
    if (record > 0) simulation.step();
    for (ElementIndex element = 0; element < 2; ++element) {
      const std::size_t row = 2 * record + element;
      CHECK(table.number(row, 1) == element);
      CHECK(table.number(row, 2) == simulation.element_value(element));
      CHECK(table.number(row, 3) == simulation.element_force(element));
      CHECK(table.number(row, 4) == 1.0);
    }
  }
  scene.output.elements = false;
  run(scene, folder);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "elements.csv"));
}

TEST_CASE("elements.csv has the elements of the requested names, in the binary form too") {
  const std::string text = R"(
[simulation]
duration = 0.2
time_step = 0.05
[[body]]
name = "chain"
nodes = [[0, 0, 0], [1, 0, 0], [2, 0.5, 0], [3, 0, 0], [4, 0.5, 0]]
springs = [[0, 1], [1, 2], [2, 3], [3, 4]]
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 40.0 }
[[element]]
name = "left"
invariant = "angle"
nodes = [[0, 1, 2]]
spring = { type = "linear", stiffness = 0.1 }
[[element]]
invariant = "angle"
nodes = [[1, 2, 3]]
spring = { type = "linear", stiffness = 0.2 }
[[element]]
name = "right"
invariant = "angle"
nodes = [[2, 3, 4], [1, 3, 4]]
spring = { type = "linear", stiffness = 0.3 }
[gravity]
acceleration = [0, -1, 0]
[output]
view = false
elements = )";
  const auto refusal = [&](const std::string& value) -> std::string {
    try {
      static_cast<void>(parse_scene(text + value, "chain.toml", *plugins()));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  CHECK(parse_scene(text + "true", "chain.toml", *plugins()).output.elements);
  CHECK_FALSE(parse_scene(text + "false", "chain.toml", *plugins()).output.elements);
  CHECK(refusal("\"left\"").find("must be true, false or a list of names of [[element]], is a text") !=
        std::string::npos);
  CHECK(refusal("[\"left\", \"rihgt\"]") ==
        "chain.toml:29:21: output.elements.1: there is no [[element]] 'rihgt'; did you mean 'right'?; known: left, "
        "right");
  CHECK(refusal("[]").find("output.elements = false") != std::string::npos);

  const TemporaryFolder folder;
  Scene scene = parse_scene(text + "true", "chain.toml", *plugins());
  run(scene, folder);
  const Csv all = testing::read_csv(folder.path() / "elements.csv");
  scene = parse_scene(text + "[\"right\", \"left\"]", "chain.toml", *plugins());
  CHECK(scene.output.element_numbers == std::vector<ElementIndex>{0, 2, 3});
  run(scene, folder);
  const Csv some = testing::read_csv(folder.path() / "elements.csv");
  REQUIRE(all.rows.size() == 5 * 4);
  REQUIRE(some.rows.size() == 5 * 3);
  for (std::size_t record = 0; record < 5; ++record) {
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(some.rows[3 * record + k] == all.rows[4 * record + scene.output.element_numbers[k]]);
    }
  }
  scene.output.format = OutputOptions::Format::binary;
  run(scene, folder);
  RecordReader reader(folder.path() / "elements.bin");
  CHECK(reader.rows() == std::vector<std::uint32_t>{0, 2, 3});
  write_csv(reader, folder.path() / "read.csv");
  CHECK(testing::read_csv(folder.path() / "read.csv").rows == some.rows);
}

TEST_CASE("a table of another form from an earlier run is removed") {
  const TemporaryFolder folder;
  Scene scene = chain_scene();
  scene.output.springs = {0};
  scene.output.view = false;
  run(scene, folder);
  scene.output.format = OutputOptions::Format::binary;
  const RunSummary summary = run(scene, folder);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "trajectory.csv"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "springs.csv"));
  CHECK(summary.files == std::vector<std::string>{"events.csv", "trajectory.bin", "springs.bin", "summary.json"});
  std::uintmax_t bytes = 0;
  for (const char* name : {"events.csv", "trajectory.bin", "springs.bin"}) {
    bytes += std::filesystem::file_size(folder.path() / name);
  }
  CHECK(summary.bytes == bytes);
}
