// Impacts where several parts of a body are near each other, and with friction, in every integrator.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "rigid_bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// A fixed block of 0.4 m below z = 0, with walls of 10 mm, and a ball of 5 mm at this gap above it.
Network above_block(double x, double y, double gap, double fall, double restitution) {
  Network net;
  const std::size_t block = add_box(net, "block", {0, 0, -0.4}, {0.4, 0.4, 0.4}, 1.0, 0.005);
  for (NodeIndex k = 0; k < 8; ++k) net.fix(k);
  add_ball(net, "ball", {x, y, 0.01 + gap}, {0, 0, -fall}, 1.0, 0.005);
  touch(net, block, block + 1, frictionless, restitution);
  return net;
}

// Impulse of a ball of unit mass on a body, both free: Newton's law along n, Coulomb's across it, by a search for the
// impulse whose slip is against it. response: 1/kg, of the rate of the pair.
Vector3 struck(const Eigen::Matrix3d& response, const Vector3& rate, const Vector3& n, double restitution,
               double friction) {
  Vector3 impulse = Vector3::Zero();
  const double wanted = -restitution * n.dot(rate);
  for (int i = 0; i < 20000; ++i) {
    Vector3 after = rate + response * impulse;
    double along = n.dot(impulse) + 0.3 * (wanted - n.dot(after)) / n.dot(response * n);
    along = std::max(0.0, along);
    after = rate + response * (along * n + (impulse - n * n.dot(impulse)));
    Vector3 across = impulse - n * n.dot(impulse) - 0.3 * (after - n * n.dot(after)) / response.norm();
    if (const double size = across.norm(); size > friction * along) across *= friction * along / size;
    impulse = along * n + across;
  }
  return impulse;
}

}  // namespace

// Wherever it falls, also where it comes near the sides and edges of other faces within the step.
TEST_CASE("a ball that falls onto a block beside an edge stops, or rebounds as fast as it came") {
  constexpr double fall = 3.0;
  for (const auto& [x, y] :
       {std::pair(0.395, 0.2), std::pair(0.2, 0.195), std::pair(0.397, 0.396), std::pair(0.1, 0.3)})
    for (const double e : {0.0, 1.0})
      for (const double h : {1e-3, 5e-4})
        for (const Method& method : methods(1e-9)) {
          CAPTURE(x);
          CAPTURE(y);
          CAPTURE(e);
          CAPTURE(h);
          CAPTURE(method.name);
          const Network net = above_block(x, y, 1.5e-4, fall, e);
          Simulation s = simulate(net, method.integrator, h);
          advance(s, 4);
          CHECK((s.velocity(8) - Vector3(0, 0, e * fall)).norm() <= 1e-6);
          CHECK(s.position(8)[2] >= 0.01 - 1e-7);
          CHECK(s.position(8)[2] <= 0.01 + e * fall * 4 * h + 1e-7);
        }
}

// The same of a rigid body: its lowest corner is below its centre, so that the blow does not turn it.
TEST_CASE("a rigid tetrahedron that falls onto a face beside its edge does not gain energy") {
  constexpr double fall = 3.0;
  for (const double e : {0.0, 1.0})
    for (const double h : {1e-3, 5e-4, 2e-4})
      for (const Method& method : methods(1e-9)) {
        CAPTURE(e);
        CAPTURE(h);
        CAPTURE(method.name);
        Network net;
        net.begin_body("plate");
        for (const Vector3& p : {Vector3(0, 0, 0), Vector3(0.4, 0, 0), Vector3(0.4, 0.4, 0)}) {
          Node node = point(p, 1.0);
          node.fixed = true;
          net.add_node(node);
        }
        net.add_face({0, 1, 2});
        net.end_body();
        net.set_extent(0, 0.01, 0.0);
        net.begin_body("tetrahedron");
        for (const Vector3& p : {Vector3(0.395, 0.2, 0.0106), Vector3(0.595, 0.2, 0.2106), Vector3(0.295, 0.4, 0.2106),
                                 Vector3(0.295, 0, 0.2106)})
          net.add_node(point(p, 1.0, {0, 0, -fall}));
        for (const auto& face : {std::array<NodeIndex, 3>{3, 5, 4}, {3, 4, 6}, {3, 6, 5}, {4, 5, 6}})
          net.add_face(face);
        net.end_body();
        net.set_extent(1, 0.01, 0.0);
        join(net, 3, 4);
        touch(net, 0, 1, frictionless, e);
        Simulation s = simulate(net, method.integrator, h);
        advance(s, 8);
        for (NodeIndex k = 3; k < 7; ++k) CHECK((s.velocity(k) - Vector3(0, 0, e * fall)).norm() <= 1e-5);
      }
}

// More points carry than are needed, and which do changes: nothing may begin to move.
TEST_CASE("rigid boxes that begin on each other stay where they are") {
  constexpr double mass = 0.4, side = 0.2;
  for (const double mu : {0.0, 0.4})
    for (const double h : {0.005, 0.002}) {
      std::vector<Method> all = methods(1e-8);
      std::erase_if(all, [](const Method& method) { return method.network && method.theta < 1.0; });
      for (const Method& method : all) {
        CAPTURE(mu);
        CAPTURE(h);
        CAPTURE(method.name);
        Network net;
        const Friction friction = mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless;
        add_box(net, "lower", {0, 0, 0}, {side, side, side}, mass, 0.003);
        add_box(net, "upper", {0.01, 0.01, side + 0.006}, {side, side, side}, mass, 0.003);
        touch(net, 0, 1, friction);
        Plane floor;
        floor.friction = friction;
        net.add_plane(floor);
        net.set_gravity({0, 0, -g});
        Simulation s = simulate(net, method.integrator, h);
        const double weight = 2.0 * mass * g;
        for (int i = 0; i < 40; ++i) {
          s.step();
          for (NodeIndex k = 0; k < 16; ++k) REQUIRE(s.velocity(k).norm() <= 1e-3);
        }
        for (NodeIndex k = 0; k < 16; ++k) CHECK((s.position(k) - net.nodes()[k].position).norm() <= 1e-5);
        CHECK(-s.surface_force(0)[2] == doctest::Approx(weight).epsilon(1e-3));
      }
    }
}

// Whatever the share of the step at which they meet.
TEST_CASE("friction in an impact on a rigid body sticks, or slips at its limit") {
  constexpr double speed = 2.0, ball_mass = 0.4;
  const Vector3 n = Vector3(1.0, 0.4, -0.3).normalized();  // from the ball to the body
  const Vector3 flight = speed * (n + 0.4 * n.unitOrthogonal()).normalized();
  for (const double mu : {0.03, 0.8})
    for (const double e : {0.0, 0.7})
      for (const double h : {1e-4, 7.3e-5, 2e-5})
        for (const Method& method : methods(1e-6)) {
          CAPTURE(mu);
          CAPTURE(e);
          CAPTURE(h);
          CAPTURE(method.name);
          Network net;
          net.begin_body("rigid");
          const std::array<Vector3, 4> places{Vector3(0, 0, 0), Vector3(0.3, 0.1, 0), Vector3(0.1, 0.4, 0.05),
                                              Vector3(0.05, 0.1, 0.35)};
          Vector3 centre = Vector3::Zero();
          double mass = 0.0;
          for (std::size_t k = 0; k < 4; ++k) {
            const double m = 0.2 + 0.15 * static_cast<double>(k);
            net.add_node(point(places[k], m));
            centre += m * places[k];
            mass += m;
          }
          centre /= mass;
          Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
          for (std::size_t k = 0; k < 4; ++k) {
            const Vector3 r = places[k] - centre;
            inertia += net.nodes()[k].mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
          }
          net.end_body();
          net.set_extent(0, 0.0, 0.02);
          join(net, 0, 4);
          const NodeIndex ball = add_ball(net, "ball", -0.05 * n - 5.3 * h * flight, flight, ball_mass, 0.03);
          touch(net, 0, 1, {Friction::Kind::coulomb, mu}, e);
          const Vector3 arm = -centre;
          Eigen::Matrix3d cross;
          cross << 0, -arm[2], arm[1], arm[2], 0, -arm[0], -arm[1], arm[0], 0;
          const Eigen::Matrix3d response =
              Eigen::Matrix3d::Identity() * (1.0 / mass + 1.0 / ball_mass) - cross * inertia.inverse() * cross;
          const Vector3 impulse = struck(response, -flight, n, e, mu);
          Simulation s = simulate(net, method.integrator, h);
          advance(s, 8);
          CHECK((s.velocity(ball) - (flight - impulse / ball_mass)).norm() <= 3e-3 * speed);
        }
}
