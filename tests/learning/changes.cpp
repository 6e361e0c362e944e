// Derivatives of motions of nets that change while they run.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/learn.hpp>
#include <springnet/motion_derivatives.hpp>

#include "derivative_check.hpp"
#include "generator.hpp"
#include "motion_loss.hpp"
#include "nets.hpp"
#include "refusal.hpp"
#include "uneven.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// A block that hardens, shrinks, gets heavier and loses springs, and meanwhile may fall on a floor.
Network changing(bool falls) {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 2, 2};
  lattice.diagonals = Diagonals::face;
  const std::uint32_t dragged = net.add_neuron(LawUse{"dragged", {{"drag", 0.2}}});
  net.add_lattice("block", lattice, {},
                  net.add_material({LawUse{"linear", {{"stiffness", 60.0}}}, LawUse{"linear", {{"damping", 0.4}}}}));
  make_uneven(net, 5, 0.04, 0.5, [](const Vector3&) { return Vector3(0, 0, -0.3); });
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.neuron = dragged;
    net.set_node(k, own);
  }
  net.fix(3);
  const MaterialIndex bending =
      net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, LawUse{"linear", {{"damping", 0.2}}}});
  net.add_element(Invariant::angle, {1, 2, 7}, bending, 1.6);
  Plane floor;
  floor.point = {0, 0, -0.12};
  floor.friction = {Friction::Kind::none, 0.0};
  if (falls) net.add_plane(floor);

  Change hard;
  hard.time = 0.205;  // within a step
  hard.springs = {0, 1, 2, 3};
  hard.spring = {{"stiffness", 90.0}};
  hard.viscosity = {{"damping", 0.1}};
  net.add_change(hard);
  Change small;
  small.time = 0.205;  // of the same step
  small.springs = {2, 3, 4, 5};
  small.reference_scale = 0.9;
  net.add_change(small);
  Change heavy;
  heavy.time = 0.4;
  heavy.nodes = {1, 6};
  heavy.mass = 2.5;
  heavy.neuron = {{"drag", 0.5}};
  net.add_change(heavy);
  Change bent;
  bent.time = 0.5;
  bent.elements = {0};
  bent.reference = 1.4;
  bent.spring = {{"stiffness", 5.0}};
  net.add_change(bent);
  Change small_again = small;
  small_again.time = 0.6;
  small_again.springs = {4, 9};
  net.add_change(small_again);
  Change cut;
  cut.time = 0.7;
  cut.springs = {0, 7, 8};
  cut.remove = true;
  net.add_change(cut);
  Change before;  // as if the net had been so
  before.springs = {10};
  before.spring = {{"stiffness", 20.0}};
  net.add_change(before);
  return net;
}

std::vector<LearnedValues> everything(std::size_t springs) {
  return {{Kind::spring_parameter, false, "stiffness", all(springs)},
          {Kind::viscosity_parameter, false, "damping", all(springs)},
          {Kind::spring_parameter, true, "stiffness", {0}},
          {Kind::rest_length, true, "", {0}},
          {Kind::rest_length, false, "", all(springs)},
          {Kind::neuron_parameter, false, "drag", {1, 2, 6}},
          {Kind::mass, false, "", {1, 4, 6, 7}},
          {Kind::initial_velocity, false, "", {1, 2, 6}}};
}

}  // namespace

// With theta 1/2 a node that touches the floor at the time of a change is free again before the next step.
TEST_CASE("the gradient of a motion of a net that changes is that of differences") {
  const auto net = std::make_shared<const Network>(changing(true));
  const std::size_t springs = net->springs().size();
  for (const double theta : {1.0, 0.5})
    for (const std::size_t memory : {std::size_t{1} << 30, std::size_t{60'000}}) {
      CAPTURE(theta);
      CAPTURE(memory);
      MotionDerivatives motion(net, plugins(), method(theta, newton, 0.01), 1.0, everything(springs));
      motion.set_memory(memory);
      const VectorXd values = motion.values_of_network();
      CHECK(values[10] == 20.0);
      motion.run(values);
      const auto touches = [&] {
        const std::vector<Event> events = motion.events();
        return std::count_if(events.begin(), events.end(),
                             [](const Event& each) { return each.kind == Event::Kind::touched; });
      };
      const auto touched = touches();
      REQUIRE(touched > 0);
      const Loss loss(101, net->nodes().size());
      const VectorXd gradient = loss.gradient(motion);
      Dice dice(3);
      Eigen::MatrixXd changes(values.size(), 3);
      for (Eigen::Index i = 0; i < changes.size(); ++i)
        changes.data()[i] = dice.between(-1, 1) * std::max(0.1, std::abs(values[i % values.size()]));
      const VectorXd along = loss.along(motion, changes);
      CHECK(loss.gradient(motion).isApprox(gradient, 1e-9));
      CHECK((motion.kept().steps_again > 0) == (memory < 100'000));
      for (Eigen::Index j = 0; j < 3; ++j) {
        CHECK(gradient.dot(changes.col(j)) == doctest::Approx(along[j]).epsilon(1e-8));
        const auto at = [&](double h) {
          motion.run(values + h * changes.col(j));
          REQUIRE(touches() == touched);
          return loss.of(motion);
        };
        constexpr double h = 1e-5;
        const double difference = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
        CHECK(along[j] == doctest::Approx(difference).epsilon(1e-6));
        motion.run(values);
      }
    }
}

// Each value is set, scaled and set again, so that going back has to undo one change after another.
TEST_CASE("the gradient of a motion with a hundred changes is that of differences") {
  Network net = changing(false);
  const std::size_t springs = net.springs().size();
  Dice dice(8);
  for (int i = 0; i < 100; ++i) {
    Change next;
    next.time = 0.01 * i + 0.005;
    for (int k = 0; k < 3; ++k) next.springs.push_back(dice.below(static_cast<std::uint32_t>(springs)));
    std::sort(next.springs.begin(), next.springs.end());
    next.springs.erase(std::unique(next.springs.begin(), next.springs.end()), next.springs.end());
    if (i % 5 == 0)
      next.spring = {{"stiffness", dice.between(40.0, 80.0)}};
    else
      next.reference_scale = dice.between(0.98, 1.02);
    net.add_change(next);
  }
  check_derivatives(net, method(0.5, newton, 0.01), 1.0, everything(springs), {1e-5, 1e-6});
  check_derivatives(net, method(0.5, newton, 0.01), 1.0, everything(springs), {1e-5, 1e-6, 60'000});
}

TEST_CASE("values that changes replace count in the memory that a motion is given") {
  Network net = changing(false);
  Change all_of_them;
  all_of_them.springs = all(net.springs().size());
  all_of_them.spring = {{"stiffness", 50.0}};
  for (int i = 1; i <= 1000; ++i) {
    all_of_them.time = 0.0009 * i;
    net.add_change(all_of_them);
  }
  MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), method(1.0, newton, 0.01), 1.0,
                           {{Kind::mass, false, "", {1}}});
  const std::size_t values = 1000 * net.springs().size() * sizeof(double);
  motion.run(motion.values_of_network());
  CHECK(motion.kept().bytes > values);
  motion.set_memory(values);
  const std::string said = refusal_of([&] { motion.run(motion.values_of_network()); });
  CAPTURE(said);
  CHECK(said.find("of memory are too few for the states of 64 steps in a row, with what changes of the net have "
                  "replaced, and") != std::string::npos);
}

TEST_CASE("what a change sets does not depend on what was learned before") {
  Network net = changing(false);
  Change all_of_them;
  all_of_them.springs = all(net.springs().size());
  all_of_them.spring = {{"stiffness", 50.0}};
  all_of_them.time = 0.02;
  net.add_change(all_of_them);
  const auto shared = std::make_shared<const Network>(net);
  MotionDerivatives motion(shared, plugins(), method(1.0, newton, 0.01), 0.04,
                           {{Kind::spring_parameter, false, "stiffness", {12}}});
  motion.run(motion.values_of_network());
  std::vector<double> velocity;
  motion.tangent(Eigen::MatrixXd::Ones(1, 1),
                 [&](std::size_t, const Eigen::MatrixXd&, const Eigen::MatrixXd& v) { velocity.push_back(v.norm()); });
  REQUIRE(velocity.size() == 5);
  CHECK(velocity[2] > velocity[1]);
  // Of the springs nothing is added any more; damping alone changes what was there.
  CHECK(velocity[4] < velocity[2]);
}

TEST_CASE("a net that changes while it learns keeps what the changes have set") {
  const auto net = std::make_shared<const Network>(changing(false));
  const std::vector<LearnedValues> learned = everything(net->springs().size());
  MotionDerivatives whole(net, plugins(), method(0.5, newton, 0.01), 1.0, learned);
  MotionDerivatives steps(net, plugins(), method(0.5, newton, 0.01), 1.0, learned);
  const VectorXd values = whole.values_of_network();
  whole.run(values);
  const Eigen::MatrixXd changes = values.cwiseAbs().cwiseMax(0.1);
  std::vector<Eigen::MatrixXd> positions;
  whole.tangent(changes,
                [&](std::size_t, const Eigen::MatrixXd& p, const Eigen::MatrixXd&) { positions.push_back(p); });
  steps.begin_steps(values, changes);
  for (std::size_t k = 1; k <= whole.step_count(); ++k) {
    steps.make_step(values, changes);
    Eigen::MatrixXd p, v;
    steps.step_tangents(1, p, v);
    CAPTURE(k);
    CHECK(steps.positions(1).isApprox(whole.positions(k), 1e-12));
    CHECK(p.isApprox(positions[k], 1e-7));
  }
}

TEST_CASE("changes that are not differentiated are refused with what they are") {
  const auto refused = [](const Change& change) {
    Network net = changing(false);
    net.add_change(change);
    const auto shared = std::make_shared<const Network>(net);
    return refusal_of([&] {
      const MotionDerivatives motion(shared, plugins(), method(1.0, newton, 0.01), 1.0,
                                     {{Kind::spring_parameter, false, "stiffness", {0}}});
    });
  };
  Change integrator;
  integrator.time = 0.3;
  integrator.integrator = LawUse{"cvode", {}};
  CHECK(
      refused(integrator) ==
      "learning: change 7 at 0.3 s is to another integrator, which is not differentiated; leave it out, or learn from "
      "the time before alone");
  Change nodes;
  nodes.time = 0.3;
  nodes.nodes = {1};
  nodes.remove = true;
  CHECK(refused(nodes).find("change 7 at 0.3 s removes nodes") != std::string::npos);
}
