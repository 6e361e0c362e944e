// [[contact]] of a scene: what it reads, writes, refuses and shows.

#include <doctest/doctest.h>

#include <string>

#include <springnet/inspection.hpp>
#include <springnet/run.hpp>
#include <springnet/scene.hpp>
#include <springnet/scene_writer.hpp>

#include "bodies.hpp"
#include "csv.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

const std::string bodies = R"(
[simulation]
duration = 1
time_step = 0.01
integrator = "verlet"
[[body]]
name = "ball"
nodes = [[0, 0, 0.5]]
neuron = { type = "point_mass", mass = 1 }
radius = 0.1
[[body]]
name = "sheet"
nodes = [[-1, -1, 0], [1, -1, 0], [0, 1, 0]]
faces = [[0, 1, 2]]
neuron = { type = "point_mass", mass = 1 }
surface_thickness = 0.02
)";

Scene read(const std::string& more) { return parse_scene(bodies + more, "scene.toml", *plugins()); }

}  // namespace

TEST_CASE("a scene says what is in contact, and is written and read again the same") {
  const Scene scene = read(R"(
[[contact]]
name = "ball on sheet"
between = [{ body = "ball" }, { body = "sheet" }]
friction = 0.3
restitution = 0.5
[[contact]]
between = [{ body = "sheet" }]
friction = "none"
)");
  const auto check = [](const Network& net) {
    CHECK(net.bodies()[0].radius == 0.1);
    CHECK(net.bodies()[1].thickness == 0.02);
    REQUIRE(net.contacts().size() == 2);
    const BodyContact& first = net.contacts()[0];
    CHECK(first.name == "ball on sheet");
    CHECK(first.first == std::vector<NodeIndex>{0});
    CHECK(first.second == std::vector<NodeIndex>{1, 2, 3});
    CHECK(first.friction.kind == Friction::Kind::coulomb);
    CHECK(first.friction.coefficient == 0.3);
    CHECK(first.restitution == 0.5);
    CHECK(net.contacts()[1].second.empty());
    CHECK(net.contacts()[1].friction.kind == Friction::Kind::none);
  };
  check(scene.network);
  check(parse_scene(to_scene(scene, *plugins()), "written.toml", *plugins()).network);
  check(Simulation(scene.network, plugins(), scene.options).present_network());
}

TEST_CASE("contacts that make no sense are refused with what to do") {
  const auto refused = [](const std::string& more, const std::string& why) {
    CAPTURE(more);
    CHECK_THROWS_WITH_AS(static_cast<void>(read(more)), doctest::Contains(why.c_str()), Error);
  };
  refused("[[contact]]\nfriction = 0.2\n", "between");
  refused("[[contact]]\nbetween = []\n", "must have one or two selections");
  refused("[[contact]]\nbetween = [{ body = \"ball\" }, { body = \"bal\" }]\n", "ball");
  refused("[[contact]]\nbetween = [{ body = \"ball\" }]\nrestitution = 2\n", "must be at most 1");
  refused("[[contact]]\nbetween = [{ body = \"ball\" }]\nfriction = -1\n", "friction");
  refused(
      "[[contact]]\nname = \"a\"\nbetween = [{ body = \"ball\" }]\n[[contact]]\nname = \"a\"\nbetween = [{ body = "
      "\"sheet\" }]\n",
      "there are two contacts 'a'");
}

TEST_CASE("bodies without any thickness, and other integrators, are refused") {
  Network net;
  add_ball(net, "a", {0, 0, 0}, at_rest, 1.0, 0.0);
  add_ball(net, "b", {1, 0, 0}, at_rest, 1.0, 0.0);
  touch_all(net, frictionless);
  CHECK_THROWS_WITH_AS(simulate(net, verlet, 0.01), doctest::Contains("surface_thickness"), Error);
  net.set_extent(0, 0.0, 0.1);
  net.set_extent(1, 0.0, 0.1);
  CHECK_NOTHROW(simulate(net, verlet, 0.01));
  CHECK_THROWS_WITH_AS(simulate(net, generalized_alpha(), 0.01), doctest::Contains("contact of bodies"), Error);
}

TEST_CASE("bodies that begin in each other are refused, and inspect names the pairs with their depth") {
  const std::string contact = "[[contact]]\nbetween = [{ body = \"ball\" }, { body = \"sheet\" }]\n";
  Scene scene = read(contact);
  CHECK_NOTHROW(check_starts(scene));
  Node node = scene.network.nodes()[0];
  node.position = {0, 0, 0.08};  // 0.03 m in
  scene.network.set_node(0, node);
  CHECK_THROWS_WITH_AS(check_starts(scene),
                       doctest::Contains("contact.0: node 0 and the face of nodes 1, 2, 3 are 0.03 m"), Error);
  CHECK_THROWS_AS(simulate(scene.network, verlet, 0.01), Error);
}

TEST_CASE("edges and corners of faces on different sides are on all of them, whatever the order of the faces") {
  for (const bool swapped : {false, true}) {
    CAPTURE(swapped);
    Network net;
    net.begin_body("roof");
    for (const Vector3& place : {Vector3(-1, 0, 0), Vector3(1, 0, 0), Vector3(0, 0, 1), Vector3(0, 1, 0.5)}) {
      Node node = point(place);
      node.fixed = true;
      net.add_node(node);
    }
    net.add_face(swapped ? Face{0, 1, 2} : Face{0, 2, 3});
    net.add_face(swapped ? Face{0, 2, 3} : Face{0, 1, 2});
    net.end_body();
    net.set_extent(0, 0.02, 0.0);
    const NodeIndex ball = add_ball(net, "ball", {0, 0, 1.5}, {0, 0, -2}, 1.0, 0.1);
    // One contact has one face, and one the other, which meet in the corner below the ball.
    BodyContact one, other;
    one.first = {0, 1, 2};
    other.first = {0, 2, 3};
    one.second = {ball};
    other.second = {3};
    other.first = {0, 2, 3};
    net.add_contact(one);
    BodyContact itself = other;
    itself.second = {ball};
    net.add_contact(itself);
    Simulation s = simulate(net, verlet, 0.01);
    advance(s, 40);
    CHECK(s.position(ball)[2] >= 1.1);
  }
}

TEST_CASE("what rests on another can be run anew from where it is") {
  Network net;
  add_ball(net, "ground", {0, 0, 0}, at_rest, 1.0, 0.1, true);
  add_ball(net, "ball", {0, 0, 0.23}, at_rest, 1.0, 0.1);
  touch_all(net, frictionless);
  net.set_gravity({0, 0, -9.81});
  Simulation s = simulate(net, verlet, 0.01);
  advance(s, 100);
  REQUIRE(s.body_touches().size() == 1);
  CHECK(s.reaction(0)[2] == doctest::Approx(2.0 * 9.81).epsilon(1e-4));
  Simulation again = simulate(s.present_network(), verlet, 0.01);
  advance(again, 10);
  CHECK(again.body_touches().size() == 1);
  Simulation copy = s.clone();
  advance(copy, 10);
  advance(s, 10);
  CHECK(copy.positions() == s.positions());
}

TEST_CASE("a run writes where bodies touch, with which force, and when they met") {
  Network net;
  add_ball(net, "ground", {0, 0, 0}, at_rest, 1.0, 0.1, true);
  add_ball(net, "ball", {0, 0, 0.2}, at_rest, 0.5, 0.1);
  touch_all(net, frictionless);
  net.set_gravity({0, 0, -10});
  Scene scene;
  scene.network = net;
  scene.duration = 0.5;
  scene.options.time_step = 0.0625;
  scene.options.integrator = verlet;
  scene.output.view = false;
  const TemporaryFolder folder;
  CHECK_FALSE(run_scene(scene, plugins(), {folder.path() / "run", "balls", {}}).failure);
  const std::string contacts = read_text(folder.path() / "run" / "contacts.csv");
  CHECK(contacts.starts_with("time,pair,x,y,z,nx,ny,nz,fx,fy,fz\n"));
  CHECK(contacts.find("\n0.5,0; 1,0,0,0.1") != std::string::npos);
  CHECK(std::count(contacts.begin(), contacts.end(), '\n') == 9);  // after each step; none is known at the start
  const std::string events = read_text(folder.path() / "run" / "events.csv");
  CHECK(events.find(",met,node,0,") != std::string::npos);
  CHECK(events.find(",0; 1\n") != std::string::npos);
  scene.output.contacts = false;
  CHECK_FALSE(run_scene(scene, plugins(), {folder.path() / "less", "balls", {}}).failure);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "less" / "contacts.csv"));
}

TEST_CASE(
    "inspect tells the largest steps of integrators that take bodies in contact, and the pairs that begin in each "
    "other") {
  Network net;
  add_ball(net, "a", {0, 0, 0}, at_rest, 1.0, 0.1);
  add_ball(net, "b", {0.15, 0, 0}, at_rest, 1.0, 0.1);
  const auto others = inspect(net, *plugins(), {}).limits.size();
  touch_all(net, frictionless);
  const Inspection found = inspect(net, *plugins(), {});
  CHECK(others > found.limits.size());
  for (const TimeConstantLimit& each : found.limits)
    CHECK((each.integrator == "verlet" || each.integrator == "recurrent" || each.integrator == "cvode"));
  const auto names = [](const Hint& hint) { return hint.text.find("nodes 0 and 1 by 0.05 m") != std::string::npos; };
  CHECK(std::count_if(found.hints.begin(), found.hints.end(), names) == 1);
}
