#include <cmath>

#include <doctest/doctest.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

void check_output(const Answer& answer, std::initializer_list<const char*> parts) {
  CHECK(answer.status == 0);
  CHECK(answer.err.empty());
  CAPTURE(answer.out);
  for (const char* part : parts) {
    CAPTURE(part);
    CHECK(answer.out.find(part) != std::string::npos);
  }
}

}  // namespace

TEST_CASE("inspect describes a scene, and writes nothing") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  // t^2 k / m + t d / m = 1 with k / m = 2, d / m = 0.25: t = (-0.25 + sqrt(0.0625 + 8)) / 4 = 0.647.
  check_output(testing::springnet(folder, "inspect pair.toml"),
               {"A pair", "2, 1 of them fixed", "linear (1)", "4 N/m", "0.5 N s/m", "synchronous        0.64",
                "wavefront          0.64", "0.15 times", "newton             no limit", "node 1 (2 kg)", "spring 0",
                "k 4 N/m, d 0.5 N s/m", "nothing unusual", "2 motions as a rigid body"});
  CHECK_FALSE(std::filesystem::exists(folder.path() / "results"));
}

TEST_CASE("inspect lists which spring is where, for a table of values") {
  const TemporaryFolder folder;
  folder.write("chain.toml", R"(
[simulation]
duration = 1.0
time_step = 0.1
integrator = { name = "recurrent" }
[[body]]
name = "chain"
nodes = [[0, 0, 0], [1, 0, 0], [1, 0, 3]]
springs = [[0, 1], [2, 1]]
rest_lengths = [0.5, 2.0]
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 1.0 }
)");
  check_output(testing::springnet(folder, "inspect chain.toml --springs springs.csv"), {"written: springs.csv"});
  CHECK(testing::read_text(folder.path() / "springs.csv") ==
        "spring,first,second,x,y,z,rest_length\n0,0,1,0.5,0,0,0.5\n1,2,1,1,0,1.5,2\n");
  const Answer of_mesh = testing::springnet(folder, "inspect absent.msh --springs springs.csv");
  CHECK(of_mesh.status == 2);
  CHECK(of_mesh.err.find("'--springs' lists those of a scene") != std::string::npos);
  CHECK(testing::springnet(folder, "inspect chain.toml --springs absent/springs.csv").status != 0);
}

TEST_CASE("inspect reports unusual springs and nodes by the scene's numbers") {
  const TemporaryFolder folder;
  folder.write("mistakes.toml", R"(
[simulation]
duration = 1.0
time_step = 0.1
[[body]]
name = "row"
nodes = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [9, 9, 9]]
springs = [[0, 1], [1, 2], [2, 3]]
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 4.0 }
[[spring]]
select = { body = "row", springs = [2] }
spring = { type = "linear", stiffness = 4000.0 }
)");
  check_output(testing::springnet(folder, "inspect mistakes.toml"),
               {"1 spring: stiffness over 100 times the median 4 N/m", "spring 2 (nodes 2, 3): 4e+03 N/m",
                "1 node without springs: 4", "2 disconnected parts", "4 nodes from node 0, none fixed",
                "4 motions (mechanisms)"});
}

TEST_CASE("inspect --json has the same numbers, and uses --set") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const auto json =
      testing::springnet(folder,
                         "inspect pair.toml --json --set body.0.spring.stiffness=6 --set body.0.neuron.mass=0.25")
          .json();
  CHECK(json["nodes"] == 2);
  CHECK(json["springs"] == 1);
  CHECK(json["fixed_nodes"] == 1);
  CHECK(json["total_mass_kg"] == 0.5);
  CHECK(json["stiffness_n_per_m"]["largest"] == 6.0);
  CHECK(json["part_count"] == 1);
  CHECK(json["time_step_s"] == 0.1);
  // t^2 24 + t 2 = 1; the search is accurate to a thousandth.
  const double t = json["time_constants"]["wavefront"]["time_constant_s"];
  CHECK(t == doctest::Approx((-2.0 + std::sqrt(100.0)) / 48.0).epsilon(2e-3));
}

TEST_CASE("inspect reports likely mistakes for the scene's time step, duration and integrator") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  // w^2 = 4 / 2: a period of 4.44 s.
  check_output(testing::springnet(folder, "inspect pair.toml --set simulation.time_step=0.5"),
               {"slowest vibration", "4.44 s", "8.89 time steps", "damping ratio 0.088", "8.9 time steps"});
  check_output(testing::springnet(
                   folder, "inspect pair.toml --set simulation.time_step=0.5 --set 'simulation.integrator=\"cvode\"'"),
               {"nothing unusual"});
  const auto json =
      testing::springnet(folder, "inspect pair.toml --json --set fix=[] --set simulation.duration=5").json();
  REQUIRE(json["hints"].size() == 1);
  CHECK(json["hints"][0]["kind"] == "fall");
  CHECK(json["hints"][0]["text"].get<std::string>().find("14 m in 5 s") != std::string::npos);
  CHECK(testing::springnet(folder, "inspect pair.toml --json --set fix=[] --set simulation.duration=0.1")
            .json()["hints"]
            .empty());
}
