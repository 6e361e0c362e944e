// Scenes to start from: examples, and scenes for meshes. They run as they are.
#include <algorithm>
#include <filesystem>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "tool.hpp"

using namespace springnet;
using springnet::testing::has;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

// A tetrahedron with two groups, as a mesh of Gmsh whose coordinates are millimetres.
constexpr const char* tetrahedron = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
2 1 "left side"
3 2 "all"
$EndPhysicalNames
$Entities
0 0 1 1
1 0 0 0 30 40 50 1 1 0
1 0 0 0 30 40 50 1 2 0
$EndEntities
$Nodes
1 4 1 4
3 1 0 4
1
2
3
4
0 0 0
30 0 0
0 40 0
0 0 50
$EndNodes
$Elements
2 2 1 2
2 1 2 1
1 1 2 3
3 1 4 1
2 1 2 3 4
$EndElements
)";

// A closed surface of triangles, 40 mm wide.
constexpr const char* closed_surface = R"(v 0 0 0
v 0.04 0 0
v 0 0.04 0
v 0 0 0.04
g wall
f 1 3 2
f 1 2 4
f 2 3 4
g side
f 1 4 3
)";

}  // namespace

TEST_CASE("examples are listed and copied, and the copies run") {
  const TemporaryFolder folder;
  const Answer list = testing::springnet(folder, "new --example");
  CHECK(list.status == 0);
  CHECK(list.err.empty());
  for (const char* name : {"bladder", "cube", "host", "instruments", "plugin", "sheet", "tube", "worm"}) {
    CAPTURE(name);
    CHECK(has(list.out, std::string("\n  ") + name + " "));
  }
  const Answer copied = testing::springnet(folder, "new --example tube -o mine/first");
  CAPTURE(copied.err);
  REQUIRE(copied.status == 0);
  CHECK(has(copied.out, "Next: springnet run mine/first/tube.toml"));
  CHECK(std::filesystem::exists(folder.path() / "mine/first/tube.msh"));
  CHECK(testing::springnet(folder, "run mine/first/tube.toml -q --duration 0.1").status == 0);
}

TEST_CASE("nothing is overwritten, and then nothing is written at all") {
  const TemporaryFolder folder;
  REQUIRE(testing::springnet(folder, "new --example cube").status == 0);
  std::filesystem::remove(folder.path() / "cube/cube.toml");
  const std::string readme = testing::read_text(folder.path() / "cube/README.md");
  const Answer again = testing::springnet(folder, "new --example cube");
  CHECK(again.status == 2);
  CHECK(has(again.err, "already exists"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "cube/cube.toml"));
  CHECK(testing::read_text(folder.path() / "cube/README.md") == readme);
  // Not even through a dangling link.
  folder.write("box.msh", tetrahedron);
  std::filesystem::create_directory(folder.path() / "box");
  std::filesystem::create_symlink("../elsewhere.toml", folder.path() / "box/box.toml");
  CHECK(testing::springnet(folder, "new box.msh").status == 2);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "elsewhere.toml"));
}

TEST_CASE("what cannot be written completely leaves nothing behind") {
  const TemporaryFolder folder;
  const Answer full = testing::shell(folder, "ulimit -f 4; \"$SPRINGNET\" new --example tube -o mine");
  CHECK(full.status == 1);
  CHECK(has(full.err, "cannot be written"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "mine"));
  CHECK(testing::springnet(folder, "new --example tube -o mine").status == 0);
}

TEST_CASE("what 'new' cannot do is a usage error") {
  const TemporaryFolder folder;
  folder.write("point.obj", "v 1 2 3\np 1\n");
  struct Wrong {
    const char* arguments;
    const char* message;
  };
  for (const Wrong& wrong : {Wrong{"new", "a mesh file or '--example' is missing"},
                             Wrong{"new --example cub", "there is no example 'cub'; did you mean 'cube'"},
                             Wrong{"new cube", "is not a mesh file"}, Wrong{"new nowhere.msh", "nowhere.msh"},
                             Wrong{"new point.obj", "all points coincide"},
                             Wrong{"new nowhere.msh --example cube", "takes only one of them"}}) {
    CAPTURE(wrong.arguments);
    const Answer answer = testing::springnet(folder, wrong.arguments);
    CAPTURE(answer.err);
    CHECK(answer.status == 2);
    CHECK(has(answer.err, wrong.message));
    CHECK(answer.out.empty());
  }
}

TEST_CASE("a scene for a solid mesh guesses its unit, offers its groups, and runs") {
  const TemporaryFolder folder;
  folder.write("liver \"A\".msh", tetrahedron);
  const Answer answer = testing::springnet(folder, "new 'liver \"A\".msh' -o out");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(has(answer.out, "in millimetres"));
  const std::string scene = testing::read_text(folder.path() / "out/liver \"A\".toml");
  CHECK(has(scene, "scale = 0.001"));
  CHECK(has(scene, "# select = { body = \"liver \\\"A\\\"\", group = \"left side\" }"));
  CHECK_FALSE(has(scene, "group = \"all\""));  // nothing would move
  CHECK_FALSE(has(scene, "thickness"));
  const Answer run = testing::springnet(folder, "run 'out/liver \"A\".toml' --json -o r");
  CAPTURE(run.err);
  REQUIRE(run.status == 0);
  CHECK(run.json()["outcome"] == "settled");
  const auto inspection = testing::springnet(folder, "inspect 'out/liver \"A\".toml' --json").json();
  CHECK(inspection["hints"].empty());
  CHECK(inspection["fixed_nodes"].get<int>() > 0);
  CHECK(inspection["upper_m"][2] == 0.05);
}

TEST_CASE("a scene for a closed surface has a thickness, and proposes a filling that works") {
  const TemporaryFolder folder;
  folder.write("bag.obj", closed_surface);
  const Answer answer = testing::springnet(folder, "new bag.obj");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(has(answer.out, "bag/bag.obj"));
  const std::string scene = testing::read_text(folder.path() / "bag/bag.toml");
  CHECK(has(scene, "thickness = "));
  CHECK(has(scene, "scale = 1,") + has(scene, "scale = 1 }") == 1);
  CHECK(testing::springnet(folder, "run bag/bag.toml -q -o r").status == 0);
  // With everything that is offered in comments: it still runs.
  std::string all;
  std::string line;
  for (const char c : scene) {
    line += c;
    if (c != '\n') continue;
    const bool offered = line.starts_with("# [") || (line.starts_with("# ") && has(line, " = ") && !has(line, ":"));
    all += offered || line.starts_with("# spring") ? line.substr(2) : line;
    line.clear();
  }
  CHECK(has(all, "\n[[plane]]"));
  CHECK(has(all, "\n[[element]]"));
  folder.write("bag/all.toml", all);
  const Answer everything = testing::springnet(folder, "run bag/all.toml -q -o r2");
  CAPTURE(everything.err);
  CHECK(everything.status == 0);
}

TEST_CASE("inspect reports the groups and the unit of a mesh file, and how to use it") {
  const TemporaryFolder folder;
  folder.write("liver.msh", tetrahedron);
  const Answer answer = testing::springnet(folder, "inspect liver.msh");
  CAPTURE(answer.out);
  CHECK(answer.status == 0);
  CHECK(answer.err.empty());
  for (const char* part :
       {"1 tetrahedron", "1 triangle", "30 x 40 x 50 (0.03 x 0.04 x 0.05 m)", "millimetres, very likely",
        "mesh.scale = 0.001", "left side", "[[body]]", "scale = 0.001", "springnet new liver.msh"}) {
    CAPTURE(part);
    CHECK(has(answer.out, part));
  }
  const auto json = testing::springnet(folder, "inspect liver.msh --json").json();
  CHECK(json["groups"].size() == 2);
  CHECK(json["unit"]["scale"] == 0.001);
  CHECK(testing::springnet(folder, "inspect liver.msh --set a=1").status == 2);
  CHECK(testing::springnet(folder, "inspect nowhere.stl").status == 2);
}
