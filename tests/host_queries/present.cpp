// The network as it is in the course of a simulation.

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Springs of several materials, elements, faces, an input, loads, motions, obstacles, a cut to come.
Network much() {
  Network net;
  const MaterialIndex soft = net.add_material(damped(30.0, 1.0));
  const MaterialIndex muscle = net.add_material({LawUse{"muscle", {{"strength", 5.0}}}, std::nullopt});
  net.add_node(point({-3, 0, 5}, 0.5));  // of no body
  Lattice lattice;
  lattice.nodes = {3, 3, 3};
  lattice.origin = {0, 0, 5};
  net.add_lattice("block", lattice, point({0, 0, 0}, 0.5), soft);
  net.begin_body("pair");
  net.add_node(point({-3, 2, 5}));
  net.add_node(point({-3, 3, 5}));
  net.add_spring(28, 29, soft);
  net.add_group("end", {29});
  net.end_body();
  net.add_spring(0, 1, muscle, 2.5);
  net.add_element(Invariant::area, {1, 2, 4}, soft, 0.4);
  net.add_element(Invariant::angle, {0, 1, 4}, soft);
  net.fix(19);
  net.add_input({"activation",
                 "arm",
                 {net.springs().size() == 0 ? 0u : static_cast<SpringIndex>(net.springs().size() - 1)},
                 {},
                 {.times = {0, 4}, .values = {0, 1}}});
  net.set_gravity({0, 0, -1});
  Load shaken{.nodes = {5, 6}, .force = {1, 0, 0}, .until = 3.0};
  shaken.course.frequency = 0.7;
  shaken.course.phase = 0.3;
  net.add_load(shaken);
  Load slow{.nodes = {7}, .force = {0, 1, 0}};
  slow.course.ramp = 4.0;
  net.add_load(slow);
  Load pressed;
  pressed.pressure = 2.0;
  pressed.follow = true;
  for (std::size_t f = 0; f < 4; ++f) pressed.faces.push_back(net.faces()[f]);
  net.add_load(pressed);
  Load drag;
  drag.traction = {0.5, 0, 0};
  for (std::size_t f = 4; f < 10; ++f) drag.faces.push_back(net.faces()[f]);
  net.add_load(drag);
  Motion swing;
  swing.amplitude = {0.2, 0, 0.1};
  swing.frequency = 0.5;
  swing.phase = 0.4;
  net.add_move({{25, 26}, swing});
  Motion table;
  table.times = {0, 2, 4};
  table.displacements = {{0, 0, 0}, {0.1, 0, 0}, {0.3, 0.2, 0}};
  net.add_move({{27}, table});
  net.add_plane({.name = "floor", .point = {0, 0, 4.2}, .friction = {Friction::Kind::coulomb, 0.3}, .motion = table});
  Instrument box{.name = "paddle", .first = {1, 1, 9}};
  box.box = BoxShape{{1, 1, 0.5}};
  box.turn.emplace().through = Vector3(2, 1, 9);
  box.turn->rate = 0.5;
  box.motion.emplace().amplitude = {0, 0, 0.3};
  box.motion->frequency = 0.2;
  net.add_instrument(box);
  net.add_cut({4.5, {3, 4}, {}});
  net.add_cut({1.0, {10}, {}});
  return net;
}

}  // namespace

TEST_CASE("a simulation of the present network starts where this one is") {
  const Network given = much();
  Simulation simulation = simulate(given, recurrent(newton, 1e-10), 0.01);
  simulation.advance_to(2.0);
  simulation.set_force(9, {0, 0, 0.5});
  simulation.set_gravity({0, 0.1, -1});
  simulation.cut({20, 21});
  const Network present = simulation.present_network();
  Simulation next = simulate(present, recurrent(newton, 1e-10), 0.01);
  CHECK(next.time() == 0.0);
  CHECK(next.node_count() == simulation.node_count());
  CHECK(next.spring_count() == simulation.live_spring_count());
  REQUIRE(present.bodies().size() == 2);
  CHECK(present.bodies()[0].name == "block");
  CHECK(present.bodies()[0].first_node == 1);
  CHECK(present.bodies()[0].node_count == 27);
  CHECK(present.bodies()[0].spring_count == given.bodies()[0].spring_count - 3);
  CHECK(present.bodies()[1].first_node == 28);
  CHECK(present.bodies()[1].spring_count == 1);
  CHECK(present.bodies()[1].groups[0].nodes == std::vector<NodeIndex>{29});
  CHECK(present.faces().size() < given.faces().size());
  CHECK(present.cuts().size() == 1);
  CHECK(present.cuts()[0].time == doctest::Approx(2.5));
  const auto near = [](const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b, double tolerance) {
    CHECK((a - b).cwiseAbs().maxCoeff() < tolerance);
  };
  const auto same = [&](double tolerance) {
    near(simulation.in_user_order(simulation.positions()), next.in_user_order(next.positions()), tolerance);
    near(simulation.in_user_order(simulation.velocities()), next.in_user_order(next.velocities()), 10 * tolerance);
    // Forces have the mean of the loads over the step before, which the new one has not made.
    near(simulation.in_user_order(simulation.forces()), next.in_user_order(next.forces()), 0.03);
    for (std::size_t j = 0; j < simulation.surface_count(); ++j) {
      CHECK((simulation.surface_position(j) - next.surface_position(j)).norm() < tolerance);
      CHECK((simulation.surface_velocity(j) - next.surface_velocity(j)).norm() < tolerance);
      CHECK((simulation.surface_spin(j) - next.surface_spin(j)).norm() < tolerance);
    }
  };
  for (const NodeIndex k : {25u, 26u, 27u}) CHECK(present.nodes()[k].position == simulation.position(k));
  CHECK(next.input_value(0) == doctest::Approx(simulation.input_value(0)));
  same(1e-9);
  // And goes on as this one does, with all that is given over time.
  simulation.advance_to(5.0);
  next.advance_to(3.0);
  CHECK(next.live_spring_count() == simulation.live_spring_count());
  same(1e-6);
}

TEST_CASE("a network that nothing has changed is present as it was given") {
  const Network given = much();
  const Simulation simulation = simulate(given, recurrent(newton, 1e-12), 0.01);
  const Network present = simulation.present_network();
  REQUIRE(present.springs().size() == given.springs().size());
  for (SpringIndex s = 0; s < given.springs().size(); ++s) {
    const Spring a = given.springs()[s], b = present.springs()[s];
    CHECK((a.first == b.first && a.second == b.second && a.rest_length == b.rest_length));
    CHECK(given.materials()[a.material] == present.materials()[b.material]);
  }
  REQUIRE(present.elements().size() == given.elements().size());
  for (ElementIndex e = 0; e < given.elements().size(); ++e) {
    CHECK(given.elements()[e].nodes == present.elements()[e].nodes);
    CHECK(given.elements()[e].reference == present.elements()[e].reference);
  }
  CHECK(present.faces() == given.faces());
  for (NodeIndex k = 0; k < 25; ++k) {
    CHECK(present.nodes()[k].position == given.nodes()[k].position);
    CHECK(present.nodes()[k].mass == given.nodes()[k].mass);
    CHECK(present.nodes()[k].fixed == given.nodes()[k].fixed);
  }
}

TEST_CASE("motions that the program told, and inputs that it set, go on") {
  Network net = much();
  Simulation simulation = simulate(net, recurrent(newton, 1e-12), 0.01);
  simulation.advance_to(0.5);
  simulation.move_node(3, simulation.position(3) + Vector3(0.1, 0, 0), 1.5);
  simulation.move_surface(0, {0, 0, 4.0}, 1.0);
  simulation.set_input("arm", 0.75);
  simulation.advance_to(0.7);
  Simulation next = simulate(simulation.present_network(), recurrent(newton, 1e-12), 0.01);
  CHECK(next.input_value(0) == 0.75);
  simulation.advance_to(1.4);
  next.advance_to(0.7);
  CHECK((simulation.position(3) - next.position(3)).norm() < 1e-9);
  CHECK((simulation.surface_position(0) - next.surface_position(0)).norm() < 1e-12);
}
