// Bodies from clouds of points, and masses of whole bodies.
#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/simulation.hpp>

#include "facts.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using springnet::testing::has_facts;

namespace {

// Five points: a square of 1 m, and one 3 m above a corner.
std::string cloud(const std::string& mesh, const std::string& body = "mass = 10.0\n") {
  return simulation + "[[body]]\nname = \"toy\"\nmesh = { " + mesh + " }\n" + body +
         "neuron = { type = \"point_mass\" }\nspring = { type = \"linear\", stiffness = 1.0 }\n";
}

std::vector<std::pair<NodeIndex, NodeIndex>> springs_of(const Scene& scene) {
  std::vector<std::pair<NodeIndex, NodeIndex>> result;
  for (const Spring& each : scene.network.springs()) result.emplace_back(each.first, each.second);
  return result;
}

double mass_of(const Network& network) {
  return std::accumulate(network.nodes().begin(), network.nodes().end(), 0.0,
                         [](double sum, const Node& node) { return sum + node.mass; });
}

}  // namespace

TEST_CASE("points become nodes, near ones are joined by springs") {
  const Scene near = parse(cloud("points = \"cloud.csv\", radius = 1.1"));
  CHECK(springs_of(near) == std::vector<std::pair<NodeIndex, NodeIndex>>{{0, 1}, {0, 3}, {1, 2}, {2, 3}});
  CHECK(near.network.nodes()[4].position == Vector3(100, 0, 3));
  for (const Node& node : near.network.nodes()) CHECK(node.mass == 2.0);
  REQUIRE(near.notes.size() == 1);
  CHECK(near.notes[0] == "Body 'toy': 1 of its 5 points have no other within 1.1 m, and so no spring.");
  CHECK(springs_of(parse(cloud("points = \"cloud.csv\", radius = 4"))).size() == 10);
  CHECK(springs_of(parse(cloud("points = \"cloud.csv\", radius = 4, neighbours = 1"))) ==
        std::vector<std::pair<NodeIndex, NodeIndex>>{{0, 1}, {0, 3}, {0, 4}, {1, 2}});
}

TEST_CASE("a cloud is scaled, turned and moved as a mesh is, and the radius is that of its places then") {
  const Scene placed =
      parse(cloud("points = \"cloud.csv\", radius = 0.0015, scale = 0.001, origin = [0, 0, 1], rotation = { "
                  "axis = [0, 0, 1], angle = 3.141592653589793 }"));
  CHECK((placed.network.nodes()[2].position - Vector3(-0.101, -0.001, 1)).norm() < 1e-15);
  CHECK(springs_of(placed).size() == 6);  // with diagonals
}

TEST_CASE("the points of a mesh file make a cloud, whose cells are not used") {
  const Scene bar = parse(cloud("points = \"bar.msh\", radius = 25.0, neighbours = 6, start = \"bar.msh\""));
  const Scene mesh = parse(cloud("file = \"bar.msh\""));
  CHECK(bar.network.nodes().size() == mesh.network.nodes().size());
  CHECK(bar.network.faces().empty());
  CHECK(bar.network.springs().size() >= 3 * bar.network.nodes().size());
}

TEST_CASE("all points of a file with cells are in the cloud, in their order, and what was not read is noted") {
  const springnet::testing::TemporaryFolder folder;
  folder.write("q.ply",
               "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
               "element face 1\nproperty list uchar int vertex_indices\nend_header\n9 9 9\n0 0 0\n1 0 0\n0 1 0\n3 1 2 "
               "3\n5 5 5\n");
  folder.write("q.obj", "v 5 5 5\nv 0 0 0\nv 1 0 0\n");
  for (const auto& [name, nodes] : {std::pair("q.ply", 4U), std::pair("q.obj", 3U)}) {
    CAPTURE(name);
    const Scene scene = parse_scene(cloud("points = \"" + std::string(name) + "\", radius = 2"), "test.toml", plugins(),
                                    {}, folder.path());
    REQUIRE(scene.network.nodes().size() == nodes);
    CHECK(scene.network.nodes()[0].position == Vector3::Constant(nodes == 4 ? 9 : 5));
    CHECK(scene.network.nodes()[0].mass == 10.0 / nodes);
    const auto has_note = [&](const std::string& facts) {
      return std::any_of(scene.notes.begin(), scene.notes.end(),
                         [&](const auto& note) { return has_facts(note, facts); });
    };
    CHECK(has_note("last element is not read") == (nodes == 4));
    CHECK(has_note("1 of its | no other within 2 m"));
  }
}

TEST_CASE("the mass of a body is divided as its density would be") {
  const std::string mesh = "file = \"bar.msh\"";
  const Network by_mass = parse(cloud(mesh, "mass = 3.0\n")).network;
  const Network by_density = parse(cloud(mesh, "density = 7.0\n")).network;
  CHECK(mass_of(by_mass) == doctest::Approx(3.0).epsilon(1e-13));
  const double ratio = mass_of(by_density) / 3.0;
  for (std::size_t k = 0; k < by_mass.nodes().size(); ++k)
    CHECK(ratio * by_mass.nodes()[k].mass == doctest::Approx(by_density.nodes()[k].mass).epsilon(1e-13));
  const Network sheet = parse(cloud("lattice = [3, 3, 1], spacing = 1.0", "mass = 8.0\n")).network;
  CHECK(sheet.nodes()[4].mass == doctest::Approx(2.0));
  CHECK(sheet.nodes()[0].mass == doctest::Approx(0.5));
  const Network chain = parse(cloud("lattice = [4, 1, 1], spacing = 1.0", "mass = 8.0\n")).network;
  for (const Node& node : chain.nodes()) CHECK(node.mass == doctest::Approx(2.0));
}

TEST_CASE("clouds that do not fit are refused at the place") {
  const auto refused = [](const std::string& mesh, const std::string& body = "mass = 10.0\n") {
    return refusal(cloud(mesh, body));
  };
  CHECK(has_facts(refused("points = \"cloud.csv\""), "test.toml:6: | body.0.mesh | 'radius' | missing"));
  CHECK(has_facts(refused("points = \"cloud.csv\", radius = 0"), "body.0.mesh.radius | above 0 m"));
  CHECK(has_facts(refused("points = \"cloud.csv\", radius = 1, neighbours = 0"), "neighbours | at least 1"));
  CHECK(has_facts(refused("points = \"curve.csv\", radius = 1"), "body.0.mesh.points | 'x'"));
  CHECK(has_facts(refused("points = \"no.ply\", radius = 1"), "no such mesh file"));
  CHECK(has_facts(refused("points = \"cloud.csv\", radius = 1, file = \"bar.msh\""), "both 'points' and 'file'"));
  CHECK(has_facts(refused("points = \"cloud.csv\", radius = 1, lattice = [2, 2, 2]"), "both 'points' and 'lattice'"));
  CHECK(has_facts(refused("points = \"cloud.csv\", radius = 1, diagonals = \"all\""),
                  "no meaning with a cloud of points"));
  CHECK(has_facts(refused("file = \"bar.msh\", radius = 1"), "no meaning with a file"));
  CHECK(has_facts(refused("lattice = [2, 2, 2], spacing = 1, neighbours = 3"), "no meaning with a lattice"));
  CHECK(
      has_facts(refused("points = \"cloud.csv\", radius = 1", "density = 1000.0\n"), "points have no volume | 'mass'"));
  CHECK(has_facts(refused("file = \"bar.msh\"", "density = 1000.0\nmass = 1.0\n"), "body.0.mass | 'density'"));
  CHECK(has_facts(refused("points = \"cloud.csv\", radius = 1", ""), "has no mass"));
  CHECK(has_facts(refused("points = \"cloud.csv\", radius = 1, start = \"bar.msh\""), "the body has 5 nodes"));
}

TEST_CASE("nodes go along tracks, each its own way") {
  const std::string moved = cloud("points = \"cloud.csv\", radius = 4") +
                            "[[move]]\ntracks = \"tracks.csv\"\nbody = \"toy\"\ninterpolation = \"linear\"\n";
  const Network net = parse(moved).network;
  REQUIRE(net.moves().size() == 2);
  CHECK(net.moves()[0].nodes == std::vector<NodeIndex>{1});
  CHECK(net.moves()[0].motion.times == std::vector<double>{0, 0.5, 2});
  CHECK(net.moves()[0].motion.displacements == std::vector<Vector3>{{0, 0, 0}, {0, 0, 1}, {0, 1, 1}});
  CHECK(net.moves()[1].motion.displacements == std::vector<Vector3>{{0, 0, 0}, {0, 0, -1}});
  CHECK(net.moves()[1].motion.interpolation == Motion::Interpolation::linear);
  // A body that starts elsewhere goes along the same places; they are there when the time has come.
  const std::string elsewhere =
      cloud("points = \"cloud.csv\", radius = 4, start = \"start.csv\"") + "[[move]]\ntracks = \"tracks.csv\"\n";
  CHECK(parse(elsewhere).network.moves()[1].motion.displacements == std::vector<Vector3>{{-1, 0, 0}, {-1, 0, -1}});
  Simulation run(net, std::make_shared<const PluginHost>(PluginHost::with_default_search()));
  while (run.time() < 0.5 - 1e-9) run.step();
  CHECK((run.position(1) - Vector3(101, 0, 1)).norm() < 1e-12);
  CHECK((run.position(4) - Vector3(100, 0, 2)).norm() < 1e-12);
}

TEST_CASE("tracks that do not fit are refused at the row") {
  const auto refused = [](const std::string& keys, const std::string& points = "cloud.csv") {
    return refusal(cloud("points = \"" + points + "\", radius = 4") + "[[move]]\n" + keys);
  };
  CHECK(has_facts(refused("tracks = \"cloud.csv\""), "test.toml:11:10: | move.0.tracks | 'time'"));
  CHECK(has_facts(refused("tracks = \"tracks.csv\"\nselect = { body = \"toy\" }"), "select | 'tracks'"));
  CHECK(has_facts(refused("tracks = \"tracks.csv\"\nbody = \"ball\""), "no body 'ball'"));
  CHECK(has_facts(refused("select = { body = \"toy\" }\nbody = \"toy\""), "is for 'tracks'"));
  const springnet::testing::TemporaryFolder folder;
  const auto of = [&](const std::string& rows) {
    folder.write("t.csv", "time,node,x,y,z\n" + rows);
    const std::string text =
        simulation +
        "[[body]]\nname = \"a\"\nnodes = [[0, 0, 0], [1, 0, 0]]\nsprings = [[0, 1]]\nneuron = { type = "
        "\"point_mass\", mass = 1 }\nspring = { type = \"linear\", stiffness = 1 }\n[[move]]\ntracks = \"t.csv\"\n";
    try {
      static_cast<void>(parse_scene(text, "test.toml", plugins(), {}, folder.path()));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(has_facts(of("0,2,0,0,0\n"), "t.csv:2: | no node 2, the scene has 2, numbered from 0"));
  CHECK(has_facts(of("0,0.5,0,0,0\n"), "t.csv:2: | no node 0.5"));
  CHECK(has_facts(of("0,1,0,0,0\n1,1,0,0,0\n1,1,0,0,1\n"), "t.csv:4: | 1 s follows 1 s"));
  CHECK(has_facts(of("0,1,0,0,0\n"), "node 1 has one row"));
  CHECK(has_facts(of(""), "no rows"));
  CHECK(has_facts(of("0,1,0,0,0\n1,1,1e101,0,0\n"), "t.csv:3: | farther than 1e+100 m"));
  CHECK(has_facts(of("0,1,0,0,0\n4.9e-324,1,1,0,0\n"), "t.csv:3: | faster than 1e+100 m/s"));
  CHECK(has_facts(of("0,1,0,nan,0\n"), "t.csv:2: | finite"));
}
