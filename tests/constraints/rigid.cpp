// Chains, loops and redundant rigid connections, free and beside springs: lengths, conservation laws, closed forms.

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include <springnet/error.hpp>

#include "schemes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// A free body of nodes that all are joined to each other: one rigid body, most of its connections redundant.
Network tumbling_body(bool flat) {
  Network net;
  const Vector3 spin(0.7, -0.4, 1.1), drift(0.3, 0.2, -0.1);  // rad/s, m/s
  const Vector3 corners[] = {
      {0, 0, 0}, {1, 0, 0}, {1.2, 1, 0}, {0, 0.8, 0}, {0.5, 0.4, flat ? 0.0 : 1.0}, {0.3, 0.1, flat ? 0.0 : -0.7}};
  double mass = 0.5;
  for (const Vector3& corner : corners) net.add_node(point(corner, mass += 0.25, drift + spin.cross(corner)));
  for (NodeIndex i = 0; i < 6; ++i)
    for (NodeIndex j = 0; j < i; ++j) net.add_rigid(j, i);
  return net;
}

Network hanging_chain(NodeIndex links) {
  Network net;
  Node top = point(Vector3::Zero());
  top.fixed = true;
  net.add_node(top);
  for (NodeIndex k = 1; k <= links; ++k) {
    net.add_node(point({0.2 * k, 0.05 * (k % 2), 0.0}, 0.3));
    net.add_rigid(k - 1, k);
  }
  net.set_gravity({0, 0, -9.81});
  return net;
}

}  // namespace

TEST_CASE("a free rigid body of redundant connections keeps its shape, momentum and, to the order, its energy") {
  for (const bool flat : {false, true}) {
    for (const Scheme& scheme : all_schemes(1e-9)) {
      INFO(scheme.name << (flat ? ", flat" : ""));
      const Network net = tumbling_body(flat);
      Simulation simulation = simulate(net, scheme.integrator, 0.01);
      const Vector3 momentum = simulation.momentum(), spin = simulation.angular_momentum();
      const double energy = simulation.kinetic_energy();
      double worst = 0.0;
      for (int i = 1; i <= 100; ++i) {
        simulation.step();
        worst = std::max(worst, worst_length(net, simulation));
      }
      CHECK(worst <= 1e-8);  // what rigid connections promise
      // Internal forces only: exact but for rounding in steps, and for the tolerance in the reference.
      CHECK((simulation.momentum() - momentum).norm() <= (scheme.order > 0.0 ? 1e-11 : 1e-7));
      // Backward Euler loses a share of (1.4 rad/s x 0.01 s) / 2 a rad; second order methods its square.
      const double share = scheme.order == 1.0 ? 3e-2 : scheme.order == 2.0 ? 2e-4 : 1e-6;
      CHECK(std::abs(simulation.kinetic_energy() - energy) <= share * energy);
      CHECK((simulation.angular_momentum() - spin).norm() <= share * spin.norm());
    }
  }
}

TEST_CASE("rigid chains and loops keep their lengths while they whirl") {
  for (const Scheme& scheme : all_schemes(1e-8)) {
    INFO(scheme.name);
    Network chain = hanging_chain(20);
    Simulation simulation = simulate(chain, scheme.integrator, 0.005);
    double worst = 0.0;
    for (int i = 0; i < 60; ++i) {
      simulation.step();
      worst = std::max(worst, worst_length(chain, simulation));
    }
    CHECK(worst <= 1e-8);

    // The chain's end tied back to the middle with a strut that is as long as that takes: a closed loop.
    chain.add_rigid(20, 10);
    Simulation loop = simulate(chain, scheme.integrator, 0.005);
    worst = 0.0;
    for (int i = 0; i < 60; ++i) {
      loop.step();
      worst = std::max(worst, worst_length(chain, loop));
    }
    CHECK(worst <= 1e-8);
  }
}

TEST_CASE("forces in a rigid chain at rest are the weights that hang on them, redundant ones share") {
  Network net;
  Node top = point({0, 0, 0});
  top.fixed = true;
  net.add_node(top);
  for (NodeIndex k = 1; k <= 5; ++k) {
    net.add_node(point({0, 0, -0.4 * k}, 0.5));
    net.add_rigid(k - 1, k);
  }
  net.set_gravity({0, 0, -10.0});
  for (const Scheme& scheme : all_schemes(1e-9)) {
    INFO(scheme.name);
    Simulation simulation = simulate(net, scheme.integrator, 0.01);
    simulation.advance_to(0.1);
    // Rounding of a sum of five weights of 5 N.
    for (RigidIndex r = 0; r < 5; ++r) CHECK(simulation.rigid_force(r) == doctest::Approx(5.0 * (5 - r)).epsilon(1e-9));
    for (NodeIndex k = 1; k <= 5; ++k) CHECK(std::abs(simulation.position(k)[2] + 0.4 * k) <= 1e-9);
  }

  // A weight on two struts of a triangle whose base, between fixed nodes, is redundant: the base bears nothing.
  Network truss;
  for (const double x : {-1.0, 1.0}) {
    Node foot = point({x, 0, 0});
    foot.fixed = true;
    truss.add_node(foot);
  }
  truss.add_node(point({0, 0, -1.0}, 2.0));
  truss.add_rigid(0, 2);
  truss.add_rigid(1, 2);
  truss.add_rigid(0, 1);
  truss.set_gravity({0, 0, -10.0});
  Simulation simulation = simulate(truss, recurrent(newton, 1e-9), 0.01);
  simulation.step();
  CHECK(simulation.rigid_force(0) == doctest::Approx(20.0 / std::sqrt(2.0)).epsilon(1e-9));
  CHECK(simulation.rigid_force(1) == doctest::Approx(20.0 / std::sqrt(2.0)).epsilon(1e-9));
  CHECK(std::abs(simulation.rigid_force(2)) <= 1e-9);
}

TEST_CASE("a spring between two rigid dumbbells: the frequency of the reduced mass") {
  // Two dumbbells in a line, joined by one spring: each moves as a whole along the line, with both of its masses.
  Network net;
  net.add_node(point({0, 0, 0}, 0.4));
  net.add_node(point({1, 0, 0}, 0.6));
  net.add_node(point({2.2, 0, 0}, 0.7));
  net.add_node(point({3.2, 0, 0}, 1.3));
  net.add_rigid(0, 1);
  net.add_rigid(2, 3);
  net.add_spring(1, 2, net.add_material(damped(30.0, 0.0)), 1.0);
  const double reduced = 1.0 * 2.0 / 3.0, omega = std::sqrt(30.0 / reduced), time = 0.8;
  for (const Scheme& scheme : all_schemes(1e-9)) {
    INFO(scheme.name);
    Simulation simulation = simulate(net, scheme.integrator, 0.001);
    simulation.advance_to(time);
    const double stretch = simulation.position(2)[0] - simulation.position(1)[0] - 1.0;
    // (omega h) ^ order / 12 a radian for second order, omega h / 2 for first; the reference to its tolerance.
    const double share = scheme.order == 1.0   ? omega * 1e-3 / 2.0 * omega * time * 1.1
                         : scheme.order == 2.0 ? 2.0 * omega * omega * 1e-6 / 12.0 * omega * time
                                               : 1e-6;
    CHECK(std::abs(stretch - 0.2 * std::cos(omega * time)) <= 0.2 * share);
    CHECK(worst_length(net, simulation) <= 1e-8);
  }
}

TEST_CASE("errors name what rigid connections cannot do") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}));
  CHECK_THROWS_WITH_AS(net.add_rigid(0, 1, 1.1), doctest::Contains("1.1"), Error);
  CHECK_THROWS_AS(net.add_rigid(0, 0), Error);
  CHECK_THROWS_AS(net.add_rigid(0, 2), Error);
  net.add_rigid(0, 1);
  CHECK_THROWS_AS(net.add_rigid(1, 0), Error);

  SUBCASE("ends that are moved apart") {
    Move apart;
    apart.nodes = {1};
    apart.motion.times = {0.0, 1.0};
    apart.motion.displacements = {Vector3::Zero(), Vector3(0.5, 0, 0)};
    net.add_move(apart);
    net.fix(0);
    for (const Scheme& scheme : all_schemes(1e-9)) {
      INFO(scheme.name);
      Simulation simulation = simulate(net, scheme.integrator, 0.1);
      try {
        simulation.advance_to(0.5);
        FAIL("no error");
      } catch (const Error& error) {
        CHECK(std::string(error.what()).find("rigid connection") != std::string::npos);
      }
    }
  }
  SUBCASE("Adams methods, for which CVODE has no projection") {
    Simulation simulation = simulate(net, cvode(1e-8, {{"method", 1}}), 0.1);
    CHECK_THROWS_WITH_AS(simulation.step(), doctest::Contains("bdf"), Error);
  }
  SUBCASE("initial velocities that stretch one are projected, and a note says so") {
    Node moving = net.nodes()[1];
    moving.velocity = {1.0, 0.5, 0.0};
    net.set_node(1, moving);
    const Simulation simulation = simulate(net, cvode(1e-8), 0.1);
    REQUIRE(simulation.notes().size() == 1);
    CHECK(simulation.notes()[0].find("rigid connections") != std::string::npos);
    // Momentum is that of the two nodes together: both move with half of it along the rod.
    CHECK((simulation.velocity(0) - Vector3(0.5, 0, 0)).norm() <= 1e-12);
    CHECK((simulation.velocity(1) - Vector3(0.5, 0.5, 0)).norm() <= 1e-12);
  }
}

TEST_CASE("a rigid body lands on a plane that holds it, one corner after the other, and keeps its shape") {
  Network net;
  for (const Vector3& corner :
       {Vector3(0, 0, 0.1), Vector3(1, 0, 0.25), Vector3(0.1, 0.9, 0.3), Vector3(0.4, 0.3, 0.9)})
    net.add_node(point(corner, 0.5));
  for (NodeIndex i = 0; i < 4; ++i)
    for (NodeIndex j = 0; j < i; ++j) net.add_rigid(j, i);
  net.set_gravity({0, 0, -9.81});
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  for (const Scheme& scheme : all_schemes(1e-8)) {
    INFO(scheme.name);
    Simulation simulation = simulate(net, scheme.integrator, 0.005);
    double worst = 0.0;
    for (int i = 0; i < 160; ++i) {
      simulation.step();
      worst = std::max(worst, worst_length(net, simulation));
    }
    CHECK(worst <= 1e-8);
    // It rests on three corners, which bear its weight; each is on the floor.
    double borne = 0.0;
    for (NodeIndex k = 0; k < 3; ++k) {
      CHECK(simulation.held(k));
      CHECK(std::abs(simulation.position(k)[2]) <= 1e-9);
      borne += simulation.reaction(k)[2];
    }
    CHECK(borne == doctest::Approx(2.0 * 9.81).epsilon(1e-9));
  }
}

TEST_CASE("a rod that is pulled up leaves the floor as a whole") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({0, 0, 1}));
  net.add_rigid(0, 1);
  net.set_gravity({0, 0, -9.81});
  net.add_load({{1}, {0, 0, 100.0}, 0.1, 0.6});
  for (const Friction::Kind kind : {Friction::Kind::held, Friction::Kind::none, Friction::Kind::coulomb}) {
    Network on_floor = net;
    Plane floor;
    floor.friction = {kind, 0.3};
    on_floor.add_plane(floor);
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name);
      Simulation simulation = simulate(on_floor, scheme.integrator, 0.001);
      simulation.advance_to(0.6);
      const double height = 0.5 * (50.0 - 9.81) * 0.25;  // steps release it in up to two of them: 0.04 m/s
      CHECK(simulation.position(0).z() == doctest::Approx(height).epsilon(scheme.order > 0.0 ? 6e-3 : 1e-6));
      CHECK(worst_length(net, simulation) <= 1e-8);
    }
  }
}

TEST_CASE("a connection that is pulled apart ends the run at once, with the reason") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}));
  net.fix(0);
  net.add_rigid(0, 1);
  Move move;
  move.nodes = {1};
  move.motion.times = {0.2, 1.0};
  move.motion.displacements = {Vector3::Zero(), Vector3(0.1, 0, 0)};
  net.add_move(move);
  for (const LawUse& integrator : {cvode(1e-8), recurrent(newton, 1e-9)}) {
    Simulation simulation = simulate(net, integrator, 0.01);
    CHECK_THROWS_WITH_AS(simulation.advance_to(1.0), doctest::Contains("rigid connections"), Error);
    CHECK(simulation.time() < 0.22);
    // The reference sees that the time does not go on, long before its greatest number of steps, 100,000.
    if (integrator.id == "cvode") CHECK(simulation.statistics().at("internal_steps") < 3000);
  }
}
