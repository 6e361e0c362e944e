// What steps leave unbalanced moves nodes, too: differences as small as that say nothing of values.

#include <cmath>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/learn.hpp>
#include <springnet/motion_derivatives.hpp>

#include "learning_nets.hpp"
#include "motion_loss.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// Falls without being strained.
Network falling(double stiffness) {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 4};
  lattice.spacing = Vector3::Constant(0.1);
  lattice.diagonals = Diagonals::space;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(stiffness, 5.0)));
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.mass = 0.1;
    net.set_node(k, own);
  }
  net.set_gravity({0, 0, -9.81});
  return net;
}

// Forces to the default tolerance.
SimulationOptions as_run() {
  SimulationOptions options;
  options.integrator = {"recurrent", {{"theta", 0.5}}};
  options.time_step = 0.02;
  options.threads = 1;
  return options;
}

}  // namespace

TEST_CASE("a value that only what steps leave unbalanced depends on is not determined, and stays") {
  const Network real = falling(600.0), guess = falling(300.0);
  Simulation motion(real, plugins(), as_run());
  const Observations seen = observe(motion, 12, from_to(0, real.nodes().size()));
  for (const bool together : {true, false}) {
    CAPTURE(together);
    const LearnedNet learned =
        learn({experiment(guess, as_run(), seen)}, plugins(),
              {{{Kind::spring_parameter, false, "stiffness", all(real.springs().size())}, together}});
    CHECK(learned.undetermined == learned.variables);
    for (const LearnedParameter& each : learned.parameters) {
      CHECK(each.value == 300.0);
      CHECK(each.determined < 1e-6);
      CHECK(std::isinf(each.upper));
    }
  }
}

TEST_CASE("how far steps are settled bounds how far they are from those of a smaller tolerance") {
  const auto net = std::make_shared<const Network>([] {
    Network result = falling(600.0);
    for (const NodeIndex k : {0U, 5U}) {
      Node own = result.nodes()[k];
      own.velocity = {0.3, -0.2, 0.1};
      result.set_node(k, own);
    }
    return result;
  }());
  SimulationOptions coarse = as_run(), fine = as_run();
  coarse.integrator.parameters["force_tolerance"] = 1e-4;
  fine.integrator.parameters["force_tolerance"] = 1e-11;
  const std::vector<LearnedValues> values{{Kind::mass, false, "", {0}}};
  MotionDerivatives one(net, plugins(), coarse, 0.4, values), other(net, plugins(), fine, 0.4, values);
  one.run(one.values_of_network());
  other.run(other.values_of_network());
  double greatest = 0.0;
  for (std::size_t k = 0; k <= one.step_count(); ++k) {
    CAPTURE(k);
    const double apart = (one.positions(k) - other.positions(k)).colwise().norm().maxCoeff();
    CHECK(apart <= one.settled_to(k).position + other.settled_to(k).position + 1e-14);
    greatest = std::max(greatest, apart);
  }
  CHECK(greatest > 0.0);
  CHECK(one.settled_to(0).position == 0.0);
  CHECK(one.settled_to(20).position < 1e-2);  // and is not just anything
}
