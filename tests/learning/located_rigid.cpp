// Derivatives of motions whose located events are those of rigidly connected nodes: the impact moves all of them, and
// what they weigh decides when one leaves.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/motion_derivatives.hpp>

#include "derivative_check.hpp"
#include "motion_loss.hpp"
#include "touching_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

const Vector3 up = Vector3::UnitZ();

// A tetrahedron of six connections at this height that carries a node on springs.
Network carried_at(double height, const Vector3& velocity, const Plane& plane) {
  Network net;
  Dice dice(4);
  for (const Vector3& at : {Vector3(0, 0, 0), Vector3(0.3, 0, 0.06), Vector3(0, 0.4, 0.11), Vector3(0.1, 0.1, 0.5)})
    net.add_node(point(at + dice.in_box(0.02) + height * up, dice.between(0.5, 2.0), velocity));
  for (NodeIndex a = 0; a < 4; ++a)
    for (NodeIndex b = a + 1; b < 4; ++b) net.add_rigid(a, b);
  const MaterialIndex soft = net.add_material(damped(50.0, 0.5));
  net.add_node(point({0.15, 0.12, 0.9 + height}, 1.5, velocity));
  net.add_spring(3, 4, soft);
  net.add_spring(1, 4, soft);
  net.add_spring(2, 4, soft);
  net.set_gravity({0, 0, -9.81});
  net.add_plane(plane);
  return net;
}

SimulationOptions rigid_steps(double theta, double step) {
  SimulationOptions options = located(theta, step, wavefront);
  options.integrator.parameters["force_tolerance"] = 3e-10;
  return options;
}

}  // namespace

TEST_CASE("rigid bodies that touch, bounce, slide and leave have the motion of their events in the derivatives") {
  Differences differences;
  differences.same_steps = false;
  for (const Friction& friction : {smooth, rough, held})
    for (const double theta : {1.0, 0.5})
      for (const double restitution : {0.0, 0.5}) {
        CAPTURE(static_cast<int>(friction.kind));
        CAPTURE(theta);
        CAPTURE(restitution);
        const Network net = carried_at(0.04, {0.5, 0.1, -0.6}, floor_with(friction, {0.1, -0.05, 1.0}, restitution));
        std::vector<LearnedValues> learned = values_of(net);
        learned.back().members = {4};
        std::size_t n = check_derivatives(net, rigid_steps(theta, 0.005), 0.12, learned, differences);
        MESSAGE(n);
      }
}
