// Keys that a command line or a host replaces before the scene is read.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "scenes.hpp"

using springnet::parse_override;
using springnet::Scene;
using springnet::SceneOverride;
using springnet::Vector3;

TEST_CASE("parse_override: key, equals, value") {
  const SceneOverride simple = parse_override("simulation.time_step=0.01");
  CHECK(simple.key == "simulation.time_step");
  CHECK(simple.value == "0.01");
  const SceneOverride spaced = parse_override(" title = \"a = b\" ");
  CHECK(spaced.key == "title");
  CHECK(spaced.value == "\"a = b\"");
  for (const char* wrong : {"", "simulation.time_step", "=3", "title=", " = "}) {
    CAPTURE(wrong);
    CHECK_THROWS_AS(static_cast<void>(parse_override(wrong)), springnet::Error);
  }
  try {
    static_cast<void>(parse_override("abc"));
  } catch (const springnet::Error& error) {
    CHECK(error.kind() == springnet::ErrorKind::input);
    CHECK(springnet::testing::has_facts(error.what(), "'abc' | key=value"));
  }
}

TEST_CASE("overrides replace and add keys, of tables and of elements") {
  const Scene scene = parse(small, {{"simulation.time_step", "0.025"},
                                    {"simulation.integrator", "\"cvode\""},
                                    {"gravity.acceleration", "[0, 0, -1]"},
                                    {"body.0.mesh.spacing", "2"},
                                    {"body.0.mesh.origin", "[1, 1, 1]"},
                                    {"body.0.mesh.lattice.2", "2"},
                                    {"body.0.spring.stiffness", "8"},
                                    {"fix", "[{ select = { nodes = [0] } }]"}});
  CHECK(scene.options.time_step == 0.025);
  CHECK(scene.options.integrator.id == "cvode");
  CHECK(scene.network.gravity() == Vector3(0, 0, -1));
  CHECK(scene.network.nodes().size() == 18);
  CHECK(scene.network.nodes()[17].position == Vector3(5, 5, 3));
  CHECK(scene.network.materials()[0].spring->parameters.at("stiffness") == 8);
  CHECK(scene.network.nodes()[0].fixed);
  CHECK_FALSE(scene.network.nodes()[1].fixed);
}

TEST_CASE("of two overrides of a key the later one counts, and may reach into the earlier") {
  const Scene scene = parse(small, {{"simulation.integrator", "{ name = \"recurrent\" }"},
                                    {"simulation.integrator.max_sweeps", "5"},
                                    {"simulation.integrator.max_sweeps", "9"}});
  CHECK(scene.options.integrator.parameters.at("max_sweeps") == 9);
}

TEST_CASE("an override can supply a key that the scene lacks") {
  const std::string without = small.substr(0, 13) + small.substr(28);  // without the line of the duration
  CHECK(refusal(without) != "");
  CHECK(parse(without, {{"simulation.duration", "4"}}).duration == 4);
}

TEST_CASE("errors of overrides name the override") {
  struct Case {
    SceneOverride given;
    std::string words;
  };
  const std::vector<Case> cases{
      {{"simulation.time_step", "-1"}, "--set simulation.time_step=-1: simulation.time_step: | 0 s | -1"},
      {{"simulation.time_stop", "1"},
       "--set simulation.time_stop=1: simulation.time_stop: | 'time_stop' | 'time_step'"},
      {{"body.0.spring.type", "\"linaer\""}, "body.0.spring.type: | 'linaer' | 'linear'"},
      {{"body.0.mesh.origin", "[0, 0, nan]"}, "body.0.mesh.origin.2: | nan"},
      {{"gravity", "{}"}, "--set gravity={}: gravity: | 'acceleration'"},
      {{"gravity.up", "1"}, "--set gravity.up=1: gravity.up: | 'up'"},
      {{"simulation.integrator", "cvode"}, "not TOML"},
      {{"title", "1\nduration = 2"}, "one key"},
      {{"simulation..time_step", "1"}, "empty"},
      {{"body.1.name", "\"b\""}, "'body' | list of 1 | '1'"},
      {{"body.name", "\"b\""}, "'body' | list of 1 | 'name'"},
      {{"body.0.name.first", "1"}, "'body.0.name' | not a table | 'first'"},
      {{"body.0.name.first.second", "1"}, "'body.0.name' | not a table | 'first'"},
  };
  for (const Case& c : cases) {
    const std::string message = refusal(small, {c.given});
    CAPTURE(message);
    CAPTURE(c.words);
    CHECK(message.starts_with("--set " + c.given.key + "="));
    CHECK(springnet::testing::has_facts(message, c.words));
  }
}
