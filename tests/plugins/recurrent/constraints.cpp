// Rigid connections, moved nodes, sliding contact and friction under every rule: the same motion, and a residual that
// includes the forces of constraints.
#include <algorithm>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

constexpr double force_tolerance = 1e-9, t_c = 0.02;

// Elastic and rigid connections in turn, hanging from a wall.
Network mixed_chain() {
  Network net;
  const MaterialIndex material = net.add_material(damped(50, 1));
  net.add_node(point(Vector3::Zero()));
  net.fix(0);
  for (NodeIndex k = 1; k < 6; ++k) {
    net.add_node(point({1.0 * k, 0, 0}));
    if (k % 2 == 1)
      net.add_rigid(k - 1, k);
    else
      net.add_spring(k - 1, k, material);
  }
  net.set_gravity({0, 0, -9.81});
  return net;
}

// A tetrahedron with one rigid edge that slides along a slope, from contact: in an impact several decisions fit a step.
Network sliding_tetrahedron(Friction::Kind kind) {
  Network net;
  const MaterialIndex material = net.add_material(damped(200, 5));
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, -0.2), Vector3(0, 1, 0), Vector3(0, 0, 1)})
    net.add_node(point(p, 1.0, {1, 0.3, -0.2}));
  net.add_rigid(0, 1);
  for (NodeIndex a = 0; a < 4; ++a)
    for (NodeIndex b = a + 1; b < 4; ++b)
      if (b != 1) net.add_spring(a, b, material);
  net.set_gravity({0, 0, -9.81});
  Plane plane;
  plane.name = "slope";
  plane.normal = {0.2, 0, 1};
  plane.friction = {kind, 0.1};
  net.add_plane(plane);
  return net;
}

// A block whose floor shakes, under a ball that presses it.
Network shaken_block() {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 3};
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(200, 5)));
  Move move;
  for (NodeIndex k = 0; k < 9; ++k) move.nodes.push_back(k);
  move.motion.amplitude = {0.1, 0, 0};
  move.motion.frequency = 2;
  net.add_move(move);
  Instrument ball;
  ball.name = "ball";
  ball.first = ball.second = {1.3, 1.3, 3.1};
  Motion motion;
  motion.amplitude = {0, 0, -0.4};
  motion.frequency = 0.5;
  ball.motion = motion;
  ball.friction = {Friction::Kind::none, 0.0};
  net.add_instrument(ball);
  return net;
}

}  // namespace

TEST_CASE("with constraints all rules give the same motion, order 1 and 2") {
  const std::vector<std::pair<std::string, Network>> nets = {{"mixed chain", mixed_chain()},
                                                             {"sliding", sliding_tetrahedron(Friction::Kind::none)},
                                                             {"rubbing", sliding_tetrahedron(Friction::Kind::coulomb)},
                                                             {"shaken", shaken_block()}};
  for (const auto& each : nets) {
    const std::string& name = each.first;  // Clang 14 captures no structured binding
    const Network& net = each.second;
    for (const double theta : {1.0, 0.5}) {
      CAPTURE(name);
      CAPTURE(theta);
      const ParameterValues order{{"theta", theta}};
      Simulation reference = simulate(net, recurrent(wavefront, force_tolerance, order), t_c);
      for (int i = 0; i < 40; ++i) CHECK(reference.step().residual <= 2 * force_tolerance);
      const std::pair<double, double> accelerated[] = {{synchronous, 0}, {block, 0},     {coloured, 0}, {newton, 0},
                                                       {synchronous, 5}, {wavefront, 5}, {block, 5},    {coloured, 5}};
      for (const auto& rule : accelerated) {
        const double update = rule.first;
        CAPTURE(update);
        ParameterValues options = order;
        options["acceleration"] = rule.second;
        Simulation simulation = simulate(net, recurrent(update, force_tolerance, options), t_c);
        for (int i = 0; i < 40; ++i) {
          const StepReport report = simulation.step();
          CHECK(report.outcome == Outcome::settled);
          CHECK(report.residual <= 2 * force_tolerance);
        }
        for (const Rigid& rigid : net.rigids()) {
          const double length = (simulation.position(rigid.first) - simulation.position(rigid.second)).norm();
          CHECK(std::abs(length / rigid.length - 1.0) < 1e-8);  // the tolerance of rigid lengths
        }
        double greatest = 0.0;
        for (NodeIndex k = 0; k < net.nodes().size(); ++k)
          greatest = std::max(greatest, (simulation.position(k) - reference.position(k)).norm());
        // Residuals of both, times t_c^2 / m and the number of steps squared over two; chains stretch differences.
        CHECK(greatest < 10 * 4 * force_tolerance * t_c * t_c * 800);
      }
    }
  }
}
