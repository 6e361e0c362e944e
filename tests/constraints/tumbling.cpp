// A braced box that is solved over its nodes, against the motion of one rigid body.

#include <doctest/doctest.h>

#include <array>

#include <Eigen/Geometry>
#include <Eigen/QR>

#include "schemes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

const Vector3 spin(0.9, -0.5, 1.3), drift(0.3, 0.2, -0.1);  // rad/s, m/s

// 12 nodes, all joined to each other: 66 connections for 36 directions, of which 30 would do.
Network braced_box() {
  Network net;
  double mass = 0.4;
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 2; ++y)
      for (int z = 0; z < 3; ++z) {
        const Vector3 p(0.7 * x, 0.9 * y, 0.5 * z);
        net.add_node(point(p, mass += 0.15, drift + spin.cross(p)));
      }
  for (NodeIndex i = 0; i < 12; ++i)
    for (NodeIndex j = 0; j < i; ++j) net.add_rigid(j, i);
  return net;
}

// Where the nodes are at a time: Euler's equations for the spin in the body's frame, and the frame's rotation.
std::vector<Vector3> as_one_body(const Network& net, double time) {
  double mass = 0.0;
  Vector3 centre = Vector3::Zero(), velocity = Vector3::Zero();
  for (const Node& node : net.nodes()) {
    mass += node.mass;
    centre += node.mass * node.position;
    velocity += node.mass * node.velocity;
  }
  centre /= mass;
  velocity /= mass;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (const Node& node : net.nodes()) {
    const Vector3 r = node.position - centre;
    inertia += node.mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Matrix3d inverse = inertia.inverse();
  struct Body {
    Eigen::Matrix3d rotation;
    Vector3 spin;  // in the body's frame
  };
  const auto rate = [&](const Body& body) -> Body {
    Eigen::Matrix3d cross;
    cross << 0.0, -body.spin[2], body.spin[1], body.spin[2], 0.0, -body.spin[0], -body.spin[1], body.spin[0], 0.0;
    return {body.rotation * cross, inverse * (inertia * body.spin).cross(body.spin)};
  };
  const auto moved = [](const Body& body, double h, const Body& by) -> Body {
    return {body.rotation + h * by.rotation, body.spin + h * by.spin};
  };
  Body body{Eigen::Matrix3d::Identity(), spin};
  constexpr int steps = 4000;
  const double h = time / steps;
  for (int i = 0; i < steps; ++i) {  // Runge and Kutta's method of fourth order: (1.6 rad/s h)^4 is below 1e-13
    const Body k1 = rate(body), k2 = rate(moved(body, h / 2, k1)), k3 = rate(moved(body, h / 2, k2)),
               k4 = rate(moved(body, h, k3));
    body = moved(moved(moved(moved(body, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
  }
  std::vector<Vector3> result;
  for (const Node& node : net.nodes())
    result.push_back(centre + time * velocity + body.rotation * (node.position - centre));
  return result;
}

}  // namespace

TEST_CASE("a braced box tumbles as one rigid body, to the order of its integrator") {
  const Network net = braced_box();
  constexpr double time = 1.0;
  const std::vector<Vector3> truth = as_one_body(net, time);
  for (const Scheme& scheme : {Scheme{"verlet", {"verlet", {}}, 2.0},
                               Scheme{"newton, theta 1/2", recurrent(newton, 1e-10, {{"theta", 0.5}}), 2.0},
                               Scheme{"newton", recurrent(newton, 1e-10), 1.0}, Scheme{"bdf", cvode(1e-9), 0.0}}) {
    INFO(scheme.name);
    std::array<double, 2> error{};
    for (const int halving : {0, 1}) {
      const double h = halving == 0 ? 0.02 : 0.01;
      Simulation simulation = simulate(net, scheme.integrator, h);
      const Vector3 momentum = simulation.momentum(), angular = simulation.angular_momentum();
      const double energy = simulation.kinetic_energy();
      double worst = 0.0;
      for (int i = 0; i < (halving == 0 ? 50 : 100); ++i) {
        simulation.step();
        worst = std::max(worst, worst_length(net, simulation));
      }
      CHECK(worst <= 1e-8);
      CHECK((simulation.momentum() - momentum).norm() <= (scheme.order > 0.0 ? 1e-11 : 1e-7) * momentum.norm());
      // First order loses w h / 2 a rad of 1.7 rad; second order its square; the reference its tolerance.
      const double turn = 1.7 * h, share = scheme.order == 1.0   ? 1.7 * turn
                                           : scheme.order == 2.0 ? 1.7 * turn * turn
                                                                 : 1e-6;
      CHECK(std::abs(simulation.kinetic_energy() - energy) <= share * energy);
      CHECK((simulation.angular_momentum() - angular).norm() <= share * angular.norm());
      auto& greatest = error[static_cast<std::size_t>(halving)];
      for (NodeIndex k = 0; k < 12; ++k) greatest = std::max(greatest, (simulation.position(k) - truth[k]).norm());
      CHECK(greatest <= 2.0 * share);  // of a box of 1 m
    }
    if (scheme.order > 0.0) CHECK(error[0] / error[1] == doctest::Approx(std::pow(2.0, scheme.order)).epsilon(0.1));
  }
}

TEST_CASE("forces in a braced box are the smallest that turn its nodes") {
  const Network net = braced_box();
  Simulation simulation = simulate(net, {"verlet", {}}, 0.01);
  for (int i = 0; i < 20; ++i) simulation.step();
  // n (a_1 - a_2) + |v_1 - v_2|^2 / l = 0 along every connection, a = W G^T (-T): least squares without squaring G W
  // G^T.
  const auto count = static_cast<Eigen::Index>(net.rigids().size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(count, 36);
  Eigen::VectorXd turning(count);
  for (Eigen::Index r = 0; r < count; ++r) {
    const Rigid& rigid = net.rigids()[static_cast<std::size_t>(r)];
    const Vector3 d = simulation.position(rigid.first) - simulation.position(rigid.second);
    const Vector3 v = simulation.velocity(rigid.first) - simulation.velocity(rigid.second);
    turning[r] = v.squaredNorm() / d.norm();
    for (const auto& [node, sign] : {std::pair{rigid.first, 1.0}, std::pair{rigid.second, -1.0}})
      a.block<1, 3>(r, 3 * node) = sign / std::sqrt(net.nodes()[node].mass) * d.normalized().transpose();
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> system(a * a.transpose());
  system.setThreshold(1e-10);
  REQUIRE(system.rank() == 30);
  const Eigen::VectorXd tension = system.solve(turning);
  for (Eigen::Index r = 0; r < count; ++r)
    CHECK(std::abs(simulation.rigid_force(static_cast<RigidIndex>(r)) - tension[r]) <=
          1e-6 * tension.cwiseAbs().maxCoeff());  // rounding over the shift
}
