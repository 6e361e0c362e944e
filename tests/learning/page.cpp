// The blocks of core/docs/learning.md and sensitivity.md.

#include <doctest/doctest.h>

#include <springnet/sensitivities.hpp>

#include "learning_nets.hpp"

namespace {
#include "gradient.inl"
#include "learning.inl"
#include "reach.inl"
}  // namespace

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("the blocks of the page do what they say") {
  Network net = chain(6, {0, 0, 0}, {1, 0, 0}, damped(40.0, 0.8));
  net.fix(0);
  net.set_gravity({0, 0, -2});
  Simulation simulation(net, plugins(), to_learn_with(0.5, 0.02));
  const Observations seen = observe(simulation, 40, from_to(1, 6));
  Network other = chain(6, {0, 0, 0}, {1, 0, 0}, damped(30.0, 0.5));
  other.fix(0);
  other.set_gravity({0, 0, -2});
  const auto guess = std::make_shared<const Network>(other);
  const LearnedNet learned = identify(guess, plugins(), seen);
  CHECK(learned.variables == 6);
  // Steps of the page's options settle to 1e-6 of the force scale.
  for (const LearnedParameter& each : learned.parameters)
    CHECK(each.value == doctest::Approx(each.kind == LearnedValues::Kind::spring_parameter ? 40.0 : 0.8).epsilon(1e-3));
  MotionDerivatives motion(guess, plugins(), to_learn_with(0.5, 0.02), 0.5,
                           {{LearnedValues::Kind::mass, false, "", {5}}});
  const Eigen::VectorXd values = motion.values_of_network();
  const double own = gradient_of_height(motion, values)[0];
  const auto height = [&](double mass) {
    motion.run(Eigen::VectorXd::Constant(1, mass));
    return motion.positions(motion.step_count())(2, 5);
  };
  CHECK(own == doctest::Approx((height(1.001) - height(0.999)) / 0.002).epsilon(1e-5));
  // Of the same motion with another mass, in CVODE.
  const auto at_end = [&](double mass) {
    Network heavier = other;
    Node node = heavier.nodes()[3];
    node.mass = mass;
    heavier.set_node(3, node);
    Simulation run = simulate(heavier, cvode(1e-11), 1.5);
    run.step();
    return run.position(4);
  };
  const Vector3 difference = (at_end(1.01) - at_end(0.99)) / 0.02;  // good to 1e-4 of it
  CHECK(difference.norm() > 1e-3);
  CHECK((change_of_top(guess, plugins(), 4, 1.5) - difference).norm() < 3e-4 * difference.norm());
}
