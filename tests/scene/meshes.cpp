// Bodies from mesh files, and groups of them in selections.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <Eigen/Geometry>
#include <springnet/mesh.hpp>

#include "facts.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using springnet::testing::has_facts;

namespace {

const std::string springs =
    "neuron = { type = \"point_mass\", mass = 1.0 }\nspring = { type = \"linear\", stiffness = 1.0 }\n";

std::string bar(const std::string& mesh_keys = "") {
  return simulation + "[[body]]\nname = \"bar\"\nmesh = { file = \"bar.msh\"" + mesh_keys + " }\n" + springs;
}

Mesh file() { return read_mesh(std::filesystem::path(SCENE_FOLDER) / "bar.msh"); }

}  // namespace

TEST_CASE("points become nodes, edges springs, groups groups, the surface faces") {
  const Mesh mesh = file();
  const Network network = parse(bar()).network;
  REQUIRE(network.nodes().size() == mesh.points.size());
  for (std::size_t k = 0; k < mesh.points.size(); ++k) CHECK(network.nodes()[k].position == mesh.points[k]);
  const std::vector<Edge> edges = edges_of(mesh);
  REQUIRE(network.springs().size() == edges.size());
  for (std::size_t k = 0; k < edges.size(); ++k) {
    CHECK(Edge{network.springs()[k].first, network.springs()[k].second} == edges[k]);
  }
  const Body& body = network.bodies()[0];
  std::set<std::string> names;
  for (const NodeGroup& group : body.groups) names.insert(group.name);
  CHECK(names == std::set<std::string>{"left", "right", "skin", "tissue"});
  // Euler: V - E + F = 2 with E = 3 F / 2 on a closed surface of the sphere's kind.
  const auto skin =
      std::find_if(body.groups.begin(), body.groups.end(), [](const auto& g) { return g.name == "skin"; });
  CHECK(network.faces().size() == 2 * skin->nodes.size() - 4);
  CHECK(body.face_count == network.faces().size());
}

TEST_CASE("a mesh is scaled, then turned, then moved") {
  const Mesh mesh = file();
  const Network network =
      parse(bar(", scale = 0.01, rotation = { axis = [0, 0, 3], angle = 1.5707963267948966 }, origin = [5, 0, 1]"))
          .network;
  for (std::size_t k = 0; k < mesh.points.size(); ++k) {
    const Vector3 p = 0.01 * mesh.points[k];
    // A quarter turn about z; 1e-15 is rounding at the size of the numbers, 5.
    CHECK((network.nodes()[k].position - Vector3(5 - p.y(), p.x(), 1 + p.z())).norm() < 1e-14);
  }
}

TEST_CASE("a second body's groups and faces have the numbers of the network") {
  const std::string second =
      "[[body]]\nname = \"other\"\nmesh = { file = \"bar.msh\", origin = [0, 0, 50] }\n" + springs;
  const Network network = parse(bar() + second + "[[fix]]\nselect = { body = \"other\", group = \"left\" }\n").network;
  std::size_t fixed = 0;
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    const Node& node = network.nodes()[k];
    CHECK(node.fixed == (node.position.z() >= 50 && node.position.x() == 0));
    fixed += node.fixed ? 1 : 0;
  }
  CHECK(fixed >= 4);
  const Body& other = network.bodies()[1];
  for (std::size_t k = other.first_face; k < other.first_face + other.face_count; ++k) {
    for (const NodeIndex node : network.faces()[k]) CHECK(node >= other.first_node);
  }
}

TEST_CASE("selections by group") {
  const auto fixed = [](const std::string& selection) {
    const Network network =
        parse(bar() + small.substr(simulation.size()) + "[[fix]]\nselect = " + selection + "\n").network;
    std::set<double> places;  // x
    for (const Node& node : network.nodes()) {
      if (node.fixed) places.insert(node.position.x());
    }
    return places;
  };
  CHECK(fixed("{ group = \"left\" }") == std::set<double>{0.0});
  CHECK(fixed("{ group = [\"left\", \"right\"] }") == std::set<double>{0.0, 100.0});
  CHECK(fixed("{ group = [\"left\", \"right\"], box = { min = [50, -inf, -inf] } }") == std::set<double>{100.0});
  CHECK(fixed("{ body = \"bar\", group = \"skin\", nodes = [0] }").size() == 1);

  const Network network = parse(bar() + "[[cut]]\ntime = 0\nselect = { group = \"left\" }\n").network;
  for (const SpringIndex spring : network.cuts()[0].springs) {
    CHECK(network.nodes()[network.springs()[spring].first].position.x() == 0);
    CHECK(network.nodes()[network.springs()[spring].second].position.x() == 0);
  }
  CHECK(network.cuts()[0].springs.size() >= 5);

  const std::string wrong = refusal(bar() + "[[fix]]\nselect = { group = \"lefd\" }\n");
  CHECK(has_facts(wrong, "test.toml:10:20: fix.0.select.group: | 'lefd'"));
  CHECK(has_facts(wrong, "did you mean 'left'?"));
  CHECK(has_facts(wrong, "known: left, right, skin, tissue"));
  CHECK(has_facts(refusal(small + "[[fix]]\nselect = { group = \"left\" }\n"), "'left' | body 'a' | no groups"));
  CHECK(has_facts(refusal(bar() + "[[fix]]\nselect = { group = [] }\n"), "names no group"));
  CHECK(has_facts(
      refusal(bar() + small.substr(simulation.size()) + "[[fix]]\nselect = { body = \"a\", group = \"left\" }\n"),
      "body 'a' has no groups"));
}

TEST_CASE("a mesh is looked for beside the scene, wherever the program runs") {
  const testing::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "parts");
  std::filesystem::copy(std::filesystem::path(SCENE_FOLDER) / "bar.msh", folder.path() / "parts" / "moved.msh");
  folder.write("scene.toml",
               simulation + "[[body]]\nname = \"bar\"\nmesh = { file = \"parts/moved.msh\" }\n" + springs);
  CHECK(load_scene(folder.path() / "scene.toml", plugins()).network.nodes().size() == file().points.size());
}

TEST_CASE("a body may begin where another mesh has its nodes, with the rest lengths of its own") {
  const testing::TemporaryFolder folder;
  folder.write("rest.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  folder.write("start.obj", "v 0 0 0\nv 3 0 0\nv 0 2 0\nf 1 2 3\n");
  folder.write("other.obj", "v 0 0 0\nv 3 0 0\nv 0 2 0\nv 1 1 1\nf 1 2 3\nf 2 3 4\n");
  const auto scene = [&](const std::string& mesh) {
    return parse_scene(simulation + "[[body]]\nname = \"b\"\nmesh = { " + mesh + " }\n" + springs +
                           "[[element]]\ninvariant = \"area\"\nselect = {}\nspring = { type = \"linear\", "
                           "stiffness = 1.0 }\n[[fix]]\nselect = { box = { min = [0.5, 0, 0], max = [1.5, 1, 9] } }\n",
                       "test.toml", plugins(), {}, folder.path());
  };
  const Scene begun = scene("file = \"rest.obj\", start = \"start.obj\", origin = [0, 0, 5]");
  CHECK(begun.network.nodes()[1].position == Vector3(3, 0, 5));
  CHECK(begun.network.nodes()[2].position == Vector3(0, 2, 5));
  CHECK(begun.network.springs()[0].rest_length == 1.0);
  CHECK(begun.network.elements()[0].reference == 0.5);
  const Scene rests = scene("file = \"rest.obj\", start = \"start.obj\"");
  CHECK(rests.network.nodes()[1].fixed);  // the box sees it at [1, 0, 0]
  std::string message;
  try {
    static_cast<void>(scene("file = \"rest.obj\", start = \"other.obj\""));
  } catch (const Error& error) {
    message = error.what();
  }
  CHECK(has_facts(message, "body.0.mesh.start: | 4 points | 3 nodes"));
}

TEST_CASE("parts of a file that a body does not use become notes of the scene") {
  const testing::TemporaryFolder folder;
  const auto notes = [&](const std::string& obj) {
    folder.write("sheet.obj", obj);
    const Scene scene = parse_scene(simulation + "[[body]]\nname = \"b\"\nmesh = { file = \"sheet.obj\" }\n" + springs,
                                    "test.toml", plugins(), {}, folder.path());
    std::string all;
    for (const std::string& note : notes_of(scene)) all += note + "\n";
    return all;
  };
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\n";
  CHECK(notes(points + "f 1 2 3\nf 1 2 4\nf 1 2 5\n").starts_with("Body 'b': "));
  CHECK(notes(points + "f 1 2 3\nf 2 1 4\nf 1 5 3\n") == "");
  // Point 4 is of no cell.
  const std::string unused = notes(points + "f 1 2 3\nf 2 1 4\n");
  CHECK(unused.starts_with("Body 'b': "));
  CHECK(has_facts(unused, "point"));
}

TEST_CASE("errors of a mesh name the place in the scene") {
  const auto refused = [](const std::string& mesh) {
    return refusal(simulation + "[[body]]\nname = \"bar\"\nmesh = " + mesh + "\n" + springs);
  };
  const std::string missing = refused("{ file = \"none.msh\" }");
  CHECK(has_facts(missing, "test.toml:6:17: body.0.mesh.file: "));
  CHECK(has_facts(missing, "none.msh"));
  CHECK(has_facts(refused("{ file = \"scenes.hpp\" }"), "test.toml:6:17: body.0.mesh.file: "));
  CHECK(has_facts(refused("{ file = \"bar.msh\", lattice = [2, 2, 2] }"), "both 'file' and 'lattice'"));
  CHECK(has_facts(refused("{ file = \"bar.msh\", spacing = 1.0 }"), "body.0.mesh.spacing: | file"));
  CHECK(has_facts(refused("{ lattice = [2, 2, 2], spacing = 1.0, scale = 2.0 }"), "body.0.mesh.scale: | lattice"));
  CHECK(has_facts(refused("{ file = \"bar.msh\", scale = 0.0 }"), "must be above 0"));
  CHECK(has_facts(refused("{ file = \"bar.msh\", rotation = { axis = [0, 0, 0], angle = 1.0 } }"), "has length zero"));
  CHECK(has_facts(refused("{ file = \"bar.msh\", rotation = { axis = [0, 0, 1] } }"), "'angle' | missing"));

  try {
    static_cast<void>(parse_scene(bar(), "test.toml", plugins()));
    FAIL("a relative path without a folder is taken");
  } catch (const Error& error) {
    CHECK(has_facts(error.what(), "test.toml:6:17: body.0.mesh.file: | folder"));
  }
}

TEST_CASE("a lattice has its boundary as faces, outward") {
  const auto volume = [](const Network& net) {
    double sum = 0;
    for (const Face& f : net.faces()) {
      const Vector3 &a = net.nodes()[f[0]].position, &b = net.nodes()[f[1]].position, &c = net.nodes()[f[2]].position;
      sum += a.dot(b.cross(c)) / 6;
    }
    return sum;
  };
  const auto lattice = [](const std::string& mesh) { return parse(small, {{"body.0.mesh", mesh}}).network; };
  const Network box = lattice("{ lattice = [3, 4, 5], spacing = [1, 2, 0.5], origin = [1, 2, 3] }");
  CHECK(volume(box) == doctest::Approx(2.0 * 6.0 * 2.0).epsilon(1e-14));  // sums of whole numbers
  CHECK(is_closed(box.faces()));
  CHECK(box.faces().size() == 4 * (2 * 3 + 3 * 4 + 4 * 2));
  CHECK(lattice("{ lattice = [3, 4, 1], spacing = 1.0 }").faces().size() == 2 * 2 * 3);
  CHECK(lattice("{ lattice = [1, 4, 3], spacing = 1.0 }").faces().size() == 2 * 3 * 2);
  CHECK(lattice("{ lattice = [5, 1, 1], spacing = 1.0 }").faces().empty());
}
