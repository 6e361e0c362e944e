// A net identified from points on its surface whose nodes are not known, as a scanner or a depth camera sees them.

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "learning_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// A sheet that is held at two corners and falls.
Network sheet(double stiffness, double damping) {
  Network net;
  Lattice lattice;
  lattice.nodes = {7, 7, 1};
  lattice.spacing = Vector3::Constant(0.1);
  lattice.diagonals = Diagonals::face;
  Node node;
  node.mass = 0.01;
  net.add_lattice("sheet", lattice, node, net.add_material(damped(stiffness, damping)));
  net.fix(0);
  net.fix(6);
  net.set_gravity({0, 0, -9.81});
  return net;
}

// Points at random on faces, after each step, with noise, m.
Observations scan(const Network& net, const SimulationOptions& options, int steps, int points, double noise) {
  Simulation simulation(net, plugins(), options);
  Observations result;
  Dice dice(21);
  for (int i = 0; i < steps; ++i) {
    simulation.step();
    for (int k = 0; k < points; ++k) {
      const Face& face = net.faces()[dice.below(static_cast<std::uint32_t>(net.faces().size()))];
      double a = dice.between(0, 1), b = dice.between(0, 1);
      if (a + b > 1.0) {
        a = 1.0 - a;
        b = 1.0 - b;
      }
      Observations::SurfacePoint point;
      point.time = simulation.time();
      point.point = (1.0 - a - b) * simulation.position(face[0]) + a * simulation.position(face[1]) +
                    b * simulation.position(face[2]) + noise * normal(dice);
      point.weight = 1.0;
      result.surface_points.push_back(point);
    }
  }
  return result;
}

}  // namespace

TEST_CASE("stiffness and damping of a sheet are found from points on it, without knowing where on it they are") {
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  const Network real = sheet(30.0, 0.05), guess = sheet(20.0, 0.02);
  const std::vector<Learnable> both{select_learnable(guess, *plugins(), "spring.stiffness:together"),
                                    select_learnable(guess, *plugins(), "viscosity.damping:together")};
  const Observations exact = scan(real, options, 20, 60, 0.0);
  const LearnedNet learned = learn({experiment(guess, options, exact)}, plugins(), both);
  CAPTURE(learned.reason);
  CHECK(learned.observed == 20 * 60);
  CHECK(learned.rms < 1e-9);  // m
  for (const LearnedParameter& each : learned.parameters)
    CHECK(each.value == doctest::Approx(each.kind == Kind::spring_parameter ? 30.0 : 0.05).epsilon(1e-6));

  const LearnedNet noisy = learn({experiment(guess, options, scan(real, options, 20, 60, 1e-3))}, plugins(), both);
  CAPTURE(noisy.reason);
  // Of the noise of a point, 1 mm along each axis, one component is left.
  CHECK(noisy.rms == doctest::Approx(1e-3).epsilon(0.15));
  CHECK(noisy.parameters.front().value == doctest::Approx(30.0).epsilon(0.03));
  CHECK(noisy.parameters.front().upper > noisy.parameters.front().lower);
  CHECK(noisy.parameters.front().upper - noisy.parameters.front().lower < 3.0);
}

TEST_CASE("points that are wrong do not outweigh the others") {
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  const Network real = sheet(30.0, 0.05), guess = sheet(25.0, 0.05);
  const std::vector<Learnable> stiffness{select_learnable(guess, *plugins(), "spring.stiffness:together")};
  Observations seen = scan(real, options, 20, 60, 1e-3);
  for (std::size_t k = 0; k < seen.surface_points.size(); k += 10) seen.surface_points[k].point += Vector3(0, 0, 0.1);
  const double plain = learn({experiment(guess, options, seen)}, plugins(), stiffness).parameters.front().value;
  seen.outlier_distance = 2e-3;  // m
  const double robust = learn({experiment(guess, options, seen)}, plugins(), stiffness).parameters.front().value;
  CHECK(robust == doctest::Approx(30.0).epsilon(0.03));
  CHECK(std::abs(robust - 30.0) < 0.2 * std::abs(plain - 30.0));
}

TEST_CASE("points are seen between steps, too, and while the net moves") {
  const SimulationOptions fine = to_learn_with(0.5, 0.005), coarse = to_learn_with(0.5, 0.02);
  const Network real = sheet(30.0, 0.05), guess = sheet(25.0, 0.05);
  const std::vector<Learnable> stiffness{select_learnable(guess, *plugins(), "spring.stiffness:together")};
  const Experiment seen = experiment(guess, coarse, scan(real, fine, 60, 20, 0.0));
  const LearnedNet learned = learn({seen}, plugins(), stiffness);
  CAPTURE(learned.reason);
  CHECK(learned.parameters.front().value == doctest::Approx(30.0).epsilon(0.03));  // the error of the coarse step
  // One gradient step after each time step takes errors of the time step for those of the stiffness: without them.
  const Experiment same = experiment(guess, coarse, scan(real, coarse, 20, 60, 0.0));
  const LearnedNet online = learn_online(same, plugins(), stiffness);
  CHECK(online.cost < 0.5 * online.start_cost);
}
