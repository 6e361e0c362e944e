// Contact, friction, rupture and cuts in the integrator generalized_alpha.
#include <doctest/doctest.h>

#include <cmath>

#include <Eigen/Geometry>

#include <springnet/error.hpp>

#include "chung_hulbert.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

double greatest_distance(const Simulation& a, const Simulation& b) {
  double worst = 0.0;
  for (NodeIndex k = 0; k < a.node_count(); ++k) worst = std::max(worst, (a.position(k) - b.position(k)).norm());
  return worst;
}

}  // namespace

TEST_CASE("a node that a moving floor catches within a step is carried from there, not from the start of the step") {
  constexpr double rises = 0.4, ahead = 0.3, height = 0.0137, h = 0.01;
  Network net;
  net.add_node(point({0, 0, height}, 0.5, {ahead, 0, 0}));
  Plane floor;
  floor.friction.kind = Friction::Kind::held;
  floor.motion.emplace();
  floor.motion->interpolation = Motion::Interpolation::linear;
  floor.motion->times = {0.0, 1.0};
  floor.motion->displacements = {Vector3::Zero(), {0.2, 0, rises}};
  net.add_plane(floor);
  Simulation s = simulate(net, generalized_alpha(0.8), h);
  s.advance_to(0.1);
  const double touches = height / rises;
  CHECK((s.position(0) - Vector3(ahead * touches + 0.2 * (0.1 - touches), 0, 0.1 * rises)).norm() <= 1e-9);
}

TEST_CASE("slips end in a net that was at rest until an obstacle moved: the speed of its motion sets what is slow") {
  // With tolerances from the forces of rounding at rest, slips of 1e-8 m/s ended and began for 160,000 sweeps.
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 2};
  lattice.spacing = Vector3::Constant(0.1);
  lattice.diagonals = Diagonals::all;
  net.add_lattice("block", lattice, point(Vector3::Zero(), 0.02), net.add_material(damped(60.0, 0.1)));
  for (NodeIndex k = 0; k < 9; ++k) net.fix(k);
  Instrument ball;
  ball.first = ball.second = {0.06, 0.05, 0.2};
  ball.radius = 0.08;
  ball.friction = {Friction::Kind::coulomb, 0.3};
  ball.motion.emplace();
  ball.motion->times = {0.0, 0.3};
  ball.motion->displacements = {Vector3::Zero(), {0.01, 0, -0.06}};
  net.add_instrument(ball);
  Simulation reference = simulate(net, cvode(1e-8), 0.01);
  reference.advance_to(0.4);
  double worst[2];
  for (int i = 0; i < 2; ++i) {
    Simulation s = simulate(net, generalized_alpha(0.8), i == 0 ? 0.0025 : 0.00125);
    s.advance_to(0.4);
    CHECK(s.sweeps() <= 5000);
    worst[i] = greatest_distance(s, reference);
  }
  CHECK(worst[0] <= 1e-4);
  CHECK(worst[1] <= 0.4 * worst[0]);
}

TEST_CASE("a pair of nodes slides over the sharp edge of a box as in the reference, at second order") {
  Network pair;
  const Eigen::Matrix3d axes =
      (Eigen::AngleAxisd(0.8, Vector3::UnitZ()) * Eigen::AngleAxisd(0.35, Vector3::UnitY())).toRotationMatrix();
  const Vector3 first = 0.3 * axes.col(2) + 0.595 * axes.col(0);
  pair.add_node(point(first, 0.6));
  pair.add_node(point(first - 0.2 * axes.col(0) + 0.05 * axes.col(1), 0.6));
  pair.set_gravity({0, 0, -9.81});
  Instrument box;
  box.friction = {Friction::Kind::coulomb, 0.01};
  box.box.emplace();
  box.box->size = {1.2, 0.8, 0.6};
  box.box->axes = axes;
  box.box->radius = 0.0;
  pair.add_instrument(box);
  for (const bool rigid : {false, true}) {
    INFO((rigid ? "rigid" : "elastic"));
    Network net = pair;
    if (rigid)
      net.add_rigid(0, 1);
    else
      net.add_spring(0, 1, net.add_material(damped(500.0, 1.0)), 0.2);
    Simulation reference = simulate(net, cvode(1e-9), 0.01);
    reference.advance_to(0.5);
    double worst[2];
    for (int i = 0; i < 2; ++i) {
      Simulation s = simulate(net, generalized_alpha(0.8), i == 0 ? 0.008 : 0.002);
      s.advance_to(0.5);
      CHECK(s.events().size() == reference.events().size());
      worst[i] = greatest_distance(s, reference);
    }
    CHECK(worst[0] <= 3e-3);
    CHECK(worst[1] <= worst[0] / 8.0);
  }
}

TEST_CASE("cuts, ruptures and contacts happen as in the reference, at their times") {
  Network net = cube(30.0, 1.0, 2.0, 0.05);
  net.add_cut({0.4, {0, 1, 2}, {}});
  const MaterialIndex weak =
      net.add_material({LawUse{"rupturing", {{"stiffness", 5.0}, {"strength", 0.1}}}, std::nullopt});
  for (const SpringIndex s : {50u, 90u, 130u}) net.set_spring_material(s, weak);
  Simulation reference = simulate(net, cvode(1e-10), 0.004);
  reference.advance_to(0.8);
  double worst[2];
  for (int i = 0; i < 2; ++i) {
    Simulation s = simulate(net, generalized_alpha(0.8), i == 0 ? 0.004 : 0.002);
    s.advance_to(0.8);
    CHECK(s.live_spring_count() == reference.live_spring_count());
    worst[i] = greatest_distance(s, reference);
  }
  CHECK(std::log2(worst[0] / worst[1]) >= 1.7);
  CHECK(worst[1] <= 1e-4);
}

// At a velocity that the program sets a node slips at once: an event at the very start of a step.
TEST_CASE("internal states of laws go on from where they are at an event that takes no time") {
  Network net;
  net.add_node(point({4, 0, 0}, 0.5));
  net.add_node(point({5, 0, 0}, 1.0));
  const NodeIndex pulled = net.add_node(point({4.5, 0.8, 0.3}, 1.0));
  net.add_rigid(0, 1);
  net.add_rigid(1, pulled);
  Node post = point({2, 1, 1});
  post.fixed = true;
  const SpringIndex spring = net.add_spring(
      pulled, net.add_node(post),
      net.add_material({LawUse{"maxwell", {{"stiffness", 30.0}, {"relaxation_time", 0.2}}}, std::nullopt}),
      2.3136225765370844);
  Plane floor{"floor", {0, 0, 0}, {0, 0, 1}};
  floor.friction = {Friction::Kind::coulomb, 0.58958293777810755};
  net.add_plane(floor);
  net.set_gravity({-2.1195361677907032, 0, -8});
  const auto make = [&](const LawUse& integrator) { return simulate(net, integrator, 0.02); };
  Simulation own = make(generalized_alpha(0.8)), restored = make(generalized_alpha(0.8)), reference = make(cvode(1e-9));
  for (int i = 0; i < 8; ++i) {
    own.step();
    reference.step();
  }
  restored.restore(own.save());
  for (Simulation* const each : {&own, &restored, &reference}) {
    each->set_velocity(pulled, {-0.45583758417958103, 0.36511928119092874, 0.090026630572938915});
    each->step();
  }
  CHECK(own.internal_states(spring) == restored.internal_states(spring));
  CHECK(own.tension(spring) == restored.tension(spring));
  // Steps of 0.02 s: the order of the method, of states that change by a hundredth.
  CHECK(own.internal_states(spring)[0] == doctest::Approx(reference.internal_states(spring)[0]).epsilon(2e-3));
  CHECK(own.tension(spring) == doctest::Approx(reference.tension(spring)).epsilon(5e-3));
}

// The muscle shortens to some 1e-5 m, and the nodes slip and stick without end.
TEST_CASE("a step whose parts have no end is an error that tells how far it has come") {
  Network net;
  const auto dragged = net.add_neuron({"dragged", {{"drag", 1e-3}}});
  for (const double x : {0.06, 0.07}) {
    Node node = point({x, 0.02, 0.03}, 1e-3);
    node.neuron = dragged;
    net.add_node(node);
  }
  const SpringIndex muscle =
      net.add_spring(0, 1, net.add_material({LawUse{"muscle", {{"strength", 0.5}}}, std::nullopt}));
  Input activation;
  activation.input = "activation";
  activation.springs = {muscle};
  activation.signal.times = {0, 1, 2, 4};
  activation.signal.values = {0, 1, 0.2, 0.8};
  net.add_input(activation);
  Plane floor{"floor", {0, 0, 0}, {0, 0, 1}};
  floor.friction = {Friction::Kind::coulomb, 0.4};
  net.add_plane(floor);
  net.set_gravity({0, 0, -9.81});
  Simulation s = simulate(net, {"generalized_alpha", {}}, 0.005);
  CHECK_THROWS_WITH_AS(s.advance_to(0.5), doctest::Contains("parts the step has come to"), Error);
  CHECK(s.time() > 0.4);
}
