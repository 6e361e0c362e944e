// What a foreign scene must not do: read files elsewhere, or send control characters to the terminal.
#include <string>

#include <doctest/doctest.h>

#include "tool.hpp"

using springnet::testing::Answer;
using springnet::testing::pair_scene;
using springnet::testing::shell;
using springnet::testing::TemporaryFolder;

TEST_CASE("files outside a scene's folder need --allow-outside") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "scene");
  folder.write("row.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
  folder.write(
      "scene/s.toml",
      "[simulation]\nduration = 0.1\ntime_step = 0.1\n[[body]]\nname = \"b\"\nmesh = { file = \"../row.obj\" }\n"
      "neuron = { type = \"point_mass\", mass = 1 }\nspring = { type = \"linear\", stiffness = 1 }\n");
  for (const std::string command : {"inspect", "run -q -o out", "validate -q -o out"}) {
    CAPTURE(command);
    const Answer refused = springnet::testing::springnet(folder, command + " scene/s.toml");
    CHECK(refused.status == 2);
    CHECK(refused.err.find("body.0.mesh.file: ") != std::string::npos);
    CHECK(refused.err.find("--allow-outside") != std::string::npos);
    CHECK(springnet::testing::springnet(folder, command + " scene/s.toml --allow-outside").status == 0);
  }
  CHECK(shell(folder, "cat scene/s.toml | \"$SPRINGNET\" inspect /dev/stdin").err.find("this scene is in no folder") !=
        std::string::npos);
}

TEST_CASE("a node behind a plane is an error with file and line") {
  const TemporaryFolder folder;
  std::string scene = pair_scene;
  scene += "[[plane]]\npoint = [0, 0, 1]\nnormal = [0, 0, 1]\n";  // with operator+ GCC 12 warns of bounds wrongly
  folder.write("s.toml", scene);
  for (const std::string command : {"run -q -o out", "validate -q -o out"}) {
    const Answer refused = springnet::testing::springnet(folder, command + " s.toml");
    CHECK(refused.status == 2);
    CHECK(refused.err.find("s.toml:18:1: plane.0: node 1 ") != std::string::npos);
  }
  CHECK(springnet::testing::springnet(folder, "inspect s.toml").status == 0);
}

TEST_CASE("control characters of a scene do not reach the terminal") {
  const TemporaryFolder folder;
  folder.write("s.toml", "\"\\u001b[31m\" = 1\n" + std::string(pair_scene));
  const Answer refused = springnet::testing::springnet(folder, "inspect s.toml");
  CHECK(refused.status == 2);
  CHECK(refused.err.find('\x1b') == std::string::npos);
  CHECK(refused.err.find("\\u001b[31m") != std::string::npos);
}
