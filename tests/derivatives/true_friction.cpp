// Coulomb friction that follows the normal reaction: derivatives of the constrained motion against differences of it.

#include <doctest/doctest.h>

#include "sliding.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

std::size_t sliding_nodes(HostAt& at, Contact::Slip phase) {
  const Contact& contact = at.engine.model().contact;
  std::size_t count = 0;
  for (std::uint32_t k = 0; k < at.node_count(); ++k)
    if (contact.now(k).slides && contact.slip_phase(k) == phase) ++count;
  return count;
}

// Whether enough nodes slide, with friction in the phase that is meant.
std::size_t sliding_nodes(HostAt& at, const Friction& friction) {
  if (friction.kind == Friction::Kind::coulomb) return sliding_nodes(at, Contact::Slip::ongoing);
  const Contact& contact = at.engine.model().contact;
  std::size_t count = 0;
  for (std::uint32_t k = 0; k < at.node_count(); ++k) count += contact.now(k).slides ? 1 : 0;
  return count;
}

// da/dp dp + da/dv dv against differences; dp and dv random.
void check_jacobian(HostAt& at, std::uint32_t kind, bool agrees) {
  const auto size = static_cast<std::size_t>(at.position.size());
  at.host.linearise(at.evaluation());
  const Eigen::VectorXd dp = random_vector(size, 21), dv = random_vector(size, 22);
  Eigen::VectorXd out(dp.size());
  at.host.jacobian_times(dp.data(), dv.data(), out.data(), kind);
  const Eigen::VectorXd p = at.position, v = at.velocity;
  const Eigen::VectorXd expected = difference([&](double h) {
    at.position = p + h * dp;
    at.velocity = v + h * dv;
    return at.evaluate().acceleration;
  });
  at.position = p;
  at.velocity = v;
  const double error = (out - expected).norm();
  if (agrees)
    CHECK(error <= of_differences * (10.0 + expected.norm()));
  else
    CHECK(error > 1e-3 * expected.norm());
}

}  // namespace

TEST_CASE("accelerations of nodes that slide on a floor, by positions and velocities") {
  HostAt at(on_floor({}).net());
  REQUIRE(sliding_nodes(at, Contact::Slip::ongoing) == 6);
  REQUIRE(at.engine.model().contact.held()[at.engine.model().layout.ordering().engine[6]] != 0);
  check_jacobian(at, SPRINGNET_TRUE_FRICTION, true);
  check_jacobian(at, 0, false);  // constant normal reactions: not the derivative of the motion
  HostAt smooth(on_floor({{Friction::Kind::none, 0.0}}).net());
  check_jacobian(smooth, SPRINGNET_TRUE_FRICTION, true);
  check_jacobian(smooth, 0, true);
}

TEST_CASE("accelerations of nodes with rigid connections, some of which slide") {
  for (const Friction& friction : {Friction{Friction::Kind::none, 0.0}, Friction{Friction::Kind::coulomb, 0.3}}) {
    HostAt at(on_floor({friction, true}).net());
    REQUIRE(sliding_nodes(at, friction) >= 4);
    check_jacobian(at, SPRINGNET_TRUE_FRICTION, true);
    check_jacobian(at, 0, false);  // without changes of the directions of connections in the constraints
  }
}

TEST_CASE("accelerations of nodes that slide on a sphere that turns, a capsule, and a turntable") {
  Network net;
  net.set_gravity({0.2, -0.1, -9.81});
  Instrument sphere, capsule;
  sphere.name = "sphere";
  sphere.first = sphere.second = {0, 0, -2};
  sphere.radius = 2.0;
  sphere.friction = {Friction::Kind::coulomb, 0.2};
  sphere.turn = Turn{};
  sphere.turn->axis = {0.1, 0.2, 1.0};
  sphere.turn->rate = 0.5;
  capsule.name = "capsule";
  capsule.first = {10, -3, -1};
  capsule.second = {10, 3, -1};
  capsule.radius = 1.0;
  capsule.friction = {Friction::Kind::coulomb, 0.1};
  net.add_instrument(sphere);
  net.add_instrument(capsule);
  Plane table{"turntable", {0, 0, -5}, Vector3::UnitZ()};
  table.friction = {Friction::Kind::coulomb, 0.15};
  table.turn = Turn{};
  table.turn->rate = 0.7;
  net.add_plane(table);
  const Vector3 on_sphere = Vector3(0.3, 0.2, 1.0).normalized(), on_capsule = Vector3(0.2, 0.0, 1.0).normalized();
  net.add_node(point(sphere.first + 2.0 * on_sphere, 1.0, on_sphere.cross(Vector3(0.4, -1.0, 0.3))));
  net.add_node(point({10 + on_capsule[0], 0.5, -1 + on_capsule[2]}, 1.2, on_capsule.cross(Vector3(0.5, 0.7, 0.2))));
  net.add_node(point({4, 3, -5}, 0.9, {0.5, 0.3, 0.0}));
  const MaterialIndex material = net.add_material(damped(3.0, 0.2));
  for (NodeIndex k = 0; k < 3; ++k) {
    const Vector3 up = net.nodes()[k].position + Vector3(0.4, -0.3, 1.0);
    net.add_spring(k, net.add_node(point(up, 1.0, {0.1, 0.2, -0.1})), material, 0.9);
  }
  HostAt at(net);
  REQUIRE(sliding_nodes(at, Contact::Slip::ongoing) == 3);
  check_jacobian(at, SPRINGNET_TRUE_FRICTION, true);
  check_jacobian(at, 0, false);
}

TEST_CASE("accelerations of nodes that begin to slide") {
  HostAt at(on_floor({{Friction::Kind::coulomb, 0.3}, false, true}).net());
  REQUIRE(sliding_nodes(at, Contact::Slip::starting) >= 3);
  // By positions alone: with a velocity the slip has begun.
  const auto size = static_cast<std::size_t>(at.position.size());
  at.host.linearise(at.evaluation());
  const Eigen::VectorXd dp = random_vector(size, 21), none = Eigen::VectorXd::Zero(dp.size()), p = at.position;
  Eigen::VectorXd out(dp.size());
  at.host.jacobian_times(dp.data(), none.data(), out.data(), SPRINGNET_TRUE_FRICTION);
  const Eigen::VectorXd expected = difference([&](double h) {
    at.position = p + h * dp;
    return at.evaluate().acceleration;
  });
  CHECK((out - expected).norm() <= of_differences * (10.0 + expected.norm()));
}

TEST_CASE("constrained accelerations by stiffnesses and masses") {
  for (const Friction& friction : {Friction{Friction::Kind::none, 0.0}, Friction{Friction::Kind::coulomb, 0.3}}) {
    for (const bool rigid : {false, true}) {
      CAPTURE(rigid);
      const Parametrised given = on_floor({friction, rigid, false});
      HostAt at(given.net());
      REQUIRE(sliding_nodes(at, friction) >= 4);
      check_parameters(given);
    }
  }
  check_parameters(on_floor({{Friction::Kind::coulomb, 0.3}, false, true}));
}

TEST_CASE("a node that slides along the edge of two planes") {
  Parametrised given;
  given.sets.resize(2);
  given.sets[0].set.kind = SPRINGNET_BY_SPRING_PARAMETER;
  given.sets[0].set.parameter = "stiffness";
  given.sets[0].values = {3.0, 4.0};
  given.sets[1].set.kind = SPRINGNET_BY_MASS;
  given.sets[1].values = {1.0, 1.2, 0.8};
  given.sets[1].of_nodes = true;
  given.make = [](const std::vector<Parametrised::Set>& sets) {
    Network net;
    net.set_gravity({0.5, -3.0, -9.81});
    Plane floor{"floor", Vector3::Zero(), Vector3::UnitZ()}, wall{"wall", Vector3::Zero(), Vector3::UnitY()};
    floor.friction = {Friction::Kind::coulomb, 0.3};
    wall.friction = {Friction::Kind::coulomb, 0.2};
    net.add_plane(floor);
    net.add_plane(wall);
    net.add_node(point({0, 0, 0}, sets[1].values[0], {1.0, 0, 0}));
    net.add_node(point({0.5, 0.7, 0.4}, sets[1].values[1]));
    net.add_node(point({-0.6, 0.5, 0.9}, sets[1].values[2]));
    for (NodeIndex k = 0; k < 2; ++k) net.add_spring(0, k + 1, net.add_material(damped(sets[0].values[k], 0.2)), 0.9);
    return net;
  };
  HostAt at(given.net());
  REQUIRE(at.engine.model().contact.now(at.engine.model().layout.ordering().engine[0]).count() == 2);
  REQUIRE(sliding_nodes(at, Contact::Slip::ongoing) == 1);
  check_parameters(given);
  check_jacobian(at, SPRINGNET_TRUE_FRICTION, true);
}
