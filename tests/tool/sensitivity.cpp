#include <string>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "tool.hpp"

using namespace springnet;
using springnet::testing::has;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

// A weight on a spring, at rest at the start, for a twentieth of its period.
std::string weight(const std::string& more) {
  return "[simulation]\nduration = 0.1\ntime_step = 0.05\n" + more +
         "[gravity]\nacceleration = [0, 0, -9.81]\n"
         "[[body]]\nname = \"weight\"\nnodes = [[0, 0, 0], [0, 0, -1]]\nsprings = [[0, 1]]\n"
         "neuron = { type = \"point_mass\", mass = 2.0 }\nspring = { type = \"linear\", stiffness = 20.0 }\n"
         "[[fix]]\nselect = { nodes = [0] }\n[output]\nnodes = { nodes = [1] }\ninterval = 0.05\n";
}

}  // namespace

TEST_CASE("sensitivity writes derivatives of the reference, whatever the scene's integrator") {
  const TemporaryFolder folder;
  folder.write("weight.toml", weight("integrator = { name = \"recurrent\", theta = 0.5 }\n"));
  const Answer answer =
      testing::springnet(folder, "sensitivity weight.toml --parameters spring.stiffness,velocity -o out");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(has(answer.out, "4 derivatives of 3 records, until 0.1 s"));
  CHECK(has(answer.out, "node 1 at 0.1 s"));
  const std::string table = testing::read_text(folder.path() / "out/sensitivity.csv");
  CHECK(table.starts_with("time,parameter,member,node,dx,dy,dz,dvx,dvy,dvz\n0,spring.stiffness,0,1,0,0,0,0,0,0\n"));
  CHECK(has(table, "\n0.05,velocity.x,1,1,"));
  // z'' = -g + k (-1 - z)/m: dz/dk = g t^4 / (24 m) + ..., whose next term is 1/300 of it.
  const std::size_t line = table.rfind("0.1,spring.stiffness,0,1,0,0,");
  REQUIRE(line != std::string::npos);
  CHECK(std::stod(table.substr(line + 29)) == doctest::Approx(9.81 * 1e-4 / (24.0 * 2.0)).epsilon(0.005));

  const Answer json =
      testing::springnet(folder, "sensitivity weight.toml --parameters mass:together --json -o out --duration 0.05");
  REQUIRE(json.status == 0);
  CHECK(json.json()["columns"][0]["parameter"] == "mass");
  CHECK(json.json()["records"] == 2);
}

TEST_CASE("sensitivity refuses what it cannot differentiate, with a status") {
  const TemporaryFolder folder;
  folder.write("weight.toml", weight(""));
  folder.write("falling.toml", weight("") + "[[plane]]\npoint = [0, 0, -1.02]\nnormal = [0, 0, 1]\n");
  const struct {
    const char* arguments;
    int status;
    const char* message;
  } wrong[] = {{"weight.toml --parameters stifness", 2, "what is learned, 'stifness'"},
               {"weight.toml --parameters mass --integrator verlet", 2, "integrator 'verlet' has none; use cvode"},
               {"falling.toml --parameters mass", 1, "contact or ruptures, which there is at 0.06"},
               {"weight.toml", 2, "--parameters"}};
  for (const auto& each : wrong) {
    const Answer answer = testing::springnet(folder, std::string("sensitivity ") + each.arguments + " -o out");
    CAPTURE(answer.err);
    CHECK(answer.status == each.status);
    CHECK(has(answer.err, each.message));
  }
}
