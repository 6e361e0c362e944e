#include <string>

#include <doctest/doctest.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

// A bar that hangs and swings, of one stiffness and damping.
std::string bar(double stiffness, double damping) {
  return "title = \"a hanging bar\"\n"
         "[simulation]\nduration = 0.6\ntime_step = 0.02\n"
         "integrator = { name = \"recurrent\", theta = 0.5, force_tolerance = 1e-9 }\n"
         "[gravity]\nacceleration = [0, 0, -9.81]\n"
         "[[body]]\nname = \"bar\"\nmesh = { lattice = [2, 2, 4], spacing = 1.0, diagonals = \"face\" }\n"
         "neuron = { type = \"point_mass\", mass = 2.0 }\n"
         "spring = { type = \"linear\", stiffness = " +
         std::to_string(stiffness) + " }\nviscosity = { type = \"linear\", damping = " + std::to_string(damping) +
         " }\n"
         "[[fix]]\nselect = { body = \"bar\", box = { min = [-1, -1, 2.9], max = [2, 2, 3.1] } }\n"
         "[output]\ninterval = 0.02\n";
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("learn finds the values of a run, and writes a scene that runs with them") {
  const TemporaryFolder folder;
  folder.write("real.toml", bar(400, 3));
  folder.write("guess.toml", bar(250, 1));
  REQUIRE(testing::springnet(folder, "run real.toml -o seen --quiet").status == 0);
  const std::string learn = "learn guess.toml --observations seen/trajectory.csv --parameters ";
  const Answer answer =
      testing::springnet(folder, learn + "spring.stiffness:together,viscosity.damping@bar:together -o out");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(has(answer.out, "2 variables from "));
  CHECK(has(answer.out, "spring.stiffness of spring 0"));
  CHECK(has(answer.err, "100 % of the time"));
  const std::string page = testing::read_text(folder.path() / "out/learning.html");
  CHECK(page.starts_with("<!doctype html>"));
  CHECK(has(page, "Course of the search"));
  CHECK(has(page, "viscosity.damping"));
  const auto json = testing::read_json(folder.path() / "out/learning.json");
  CHECK(json["variables"] == 2);
  CHECK(json["undetermined_directions"] == 0);
  for (const auto& each : json["parameters"])
    CHECK(each["value"].get<double>() == doctest::Approx(each["kind"] == "spring" ? 400.0 : 3.0).epsilon(1e-6));
  REQUIRE(testing::springnet(folder, "run out/learned.toml -o again --quiet").status == 0);
  // Height of the lowest node at the end, m.
  const auto height = [&](const char* file) {
    const std::string text = testing::read_text(folder.path() / file);
    const std::size_t line = text.rfind("\n0.6,0,");
    REQUIRE(line != std::string::npos);
    std::size_t cell = line;
    for (int comma = 0; comma < 4; ++comma) cell = text.find(',', cell) + 1;
    return std::stod(text.substr(cell));
  };
  CHECK(height("again/trajectory.csv") == doctest::Approx(height("seen/trajectory.csv")).epsilon(1e-8));
  CHECK(height("seen/trajectory.csv") < -0.05);
  const Answer online =
      testing::springnet(folder, learn + "spring.stiffness:together --method online --json -o online");
  CAPTURE(online.err);
  REQUIRE(online.status == 0);
  CHECK(online.json()["cost"].get<double>() < 0.5 * online.json()["start_cost"].get<double>());
  CHECK(online.json()["parameters"][0]["upper"].is_null());
  const auto quiet = testing::springnet(folder, learn + "spring.stiffness:together --json -o one");
  CHECK(quiet.status == 0);
  CHECK(quiet.err.empty());
  CHECK(quiet.json() == testing::read_json(folder.path() / "one/learning.json"));
}

TEST_CASE("learn refuses observations and selections with what is wrong, and where") {
  const TemporaryFolder folder;
  folder.write("bar.toml", bar(250, 1));
  folder.write("seen.csv", "time,node,x,y,z\n0.1,0,0,0,-0.01\n0.2,77,0,0,0\n");
  folder.write("late.csv", "time,node,x,y,z\n-0.1,0,0,0,-0.01\n");
  folder.write("far.csv", "time,node,x,y,z\n0.1,0,0,0,-0.01\n1000000000,1,0,0,0\n");
  folder.write("odd.csv", "time,node,x,y,z\n0.1,0,0,0,red\n");
  folder.write("none.csv", "time,node,x,y,z\n0.1,0,nan,nan,\n");
  struct Wrong {
    const char* arguments;
    const char* message;
  };
  for (const Wrong& wrong :
       {Wrong{"seen.csv --parameters mass", "seen.csv:3"},
        Wrong{"late.csv --parameters mass", "late.csv: nothing is observed during the motion"},
        Wrong{"far.csv --parameters mass", "far.csv:3"}, Wrong{"odd.csv --parameters mass", "odd.csv:2"},
        Wrong{"none.csv --parameters mass", "none.csv"}, Wrong{"absent.csv --parameters mass", "absent.csv"},
        Wrong{"seen.csv --parameters spring.stifness", "did you mean 'stiffness'"},
        Wrong{"seen.csv --parameters mass@bat", "did you mean 'bar'"}, Wrong{"seen.csv", "--parameters is required"}}) {
    CAPTURE(wrong.arguments);
    const Answer answer = testing::springnet(folder, std::string("learn bar.toml --observations ") + wrong.arguments);
    CAPTURE(answer.err);
    CHECK(answer.status == 2);
    CHECK(has(answer.err, wrong.message));
    CHECK(answer.out.empty());
  }
}
