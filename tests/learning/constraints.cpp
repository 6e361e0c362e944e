// Derivatives of motions with contact and rigid connections, against differences of the motions themselves.

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/learn.hpp>
#include <springnet/motion_derivatives.hpp>

#include "derivative_check.hpp"
#include "learning_nets.hpp"
#include "motion_loss.hpp"
#include "refusal.hpp"
#include "touching_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// Steps of nodes in contact settle to less than others where forces are great.
void check_derivatives(const Network& net, double theta, double rule, double duration,
                       const std::vector<LearnedValues>& learned, double step = 0.02, double force_tolerance = 0.0,
                       bool same_steps = true) {
  SimulationOptions options = method(theta, rule, step);
  Differences how;
  how.same_steps = same_steps;
  if (force_tolerance > 0.0) {
    options.integrator.parameters["force_tolerance"] = force_tolerance;
    how.accuracy = 1e-6;
  }
  testing::check_derivatives(net, options, duration, learned, how);
}

// So large that the host's systems have no matrix: they know of the contacts, which would else take iterations each.
Network large_body(const Friction& friction) {
  Network net;
  Lattice lattice;
  lattice.nodes = {7, 7, 7};
  lattice.spacing = {0.1, 0.1, 0.1};
  lattice.origin = {0, 0, 0.09};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(2e4, 20.0)));
  make_uneven(net, 4, 0.005, 0.1, [](const Vector3&) { return Vector3(0.4, 0.2, -0.5); });
  net.set_gravity({0, 0, -9.81});
  net.add_plane(floor_with(friction, {0.2, -0.1, 1.0}));
  return net;
}

}  // namespace

TEST_CASE("derivatives of a body that falls on a plane, with every friction, theta and rule") {
  for (const Friction& friction : {held, smooth, rough})
    for (const double theta : {1.0, 0.5})
      for (const double rule : {newton, wavefront}) {
        CAPTURE(static_cast<int>(friction.kind));
        CAPTURE(theta);
        CAPTURE(rule);
        Network net = block_at({0, 0, 0.1}, {0.4, 0.2, -0.5}, 6);
        net.add_plane(floor_with(friction, {0.2, -0.1, 1.0}));
        check_derivatives(net, theta, rule, 0.5, values_of(net));
        // With forces that decide whether nodes slide.
        Load load;
        load.nodes = {0, 3};
        load.force = {1.0, -2.0, -3.0};
        net.add_load(load);
        check_derivatives(net, theta, rule, 0.5, {{Kind::gravity, false, "", {0, 1, 2}}, {Kind::load, false, "", {0}}});
      }
}

TEST_CASE("derivatives of a large body that falls on a plane, with every friction") {
  for (const Friction& friction : {held, smooth, rough}) {
    CAPTURE(static_cast<int>(friction.kind));
    const Network net = large_body(friction);
    check_derivatives(net, 1.0, newton, 0.16, {{Kind::spring_parameter, false, "stiffness", all(net.springs().size())}},
                      0.02, 1e-9);
  }
}

TEST_CASE("derivatives of a large body with rigid connections beside its contacts") {
  Network net = large_body(smooth);
  const auto first = static_cast<NodeIndex>(net.nodes().size());
  for (int k = 0; k < 3; ++k) net.add_node(point({0.2 + 0.2 * k, 0.3, 0.9 + 0.05 * k}, 1.0, {0.1 * k, 0.0, 0.0}));
  net.add_rigid(first, first + 1);
  net.add_rigid(first + 1, first + 2);
  const MaterialIndex soft = net.add_material(damped(300.0, 1.0));
  for (NodeIndex k = 0; k < 3; ++k) net.add_spring(first - 1 - 7 * k, first + k, soft);
  check_derivatives(net, 1.0, newton, 0.16, {{Kind::spring_parameter, false, "stiffness", all(net.springs().size())}},
                    0.02, 1e-8);
}

// Velocities of nodes in contact are then off by more than 1e-4 of themselves.
TEST_CASE("steps that leave much unbalanced have derivatives that are off by as much") {
  const auto net = std::make_shared<const Network>(large_body(rough));
  const auto gradient = [&](double force_tolerance) {
    SimulationOptions options = method(1.0, newton, 0.02);
    options.integrator.parameters["force_tolerance"] = force_tolerance;
    MotionDerivatives motion(net, plugins(), options, 0.2,
                             {{Kind::spring_parameter, false, "stiffness", all(net->springs().size())}});
    motion.run(motion.values_of_network());
    return Loss(motion.step_count() + 1, net->nodes().size()).gradient(motion);
  };
  const VectorXd exact = gradient(1e-9);
  for (const double tolerance : {0.1, 0.5, 1.0, 2.0, 4.0, 8.0}) {
    CAPTURE(tolerance);
    CHECK((gradient(tolerance) - exact).norm() <= 0.1 * exact.norm());
  }
}

TEST_CASE("derivatives of contact with surfaces that move, turn, are curved and let nodes bounce") {
  for (const Friction& friction : {held, smooth, rough})
    for (const double theta : {1.0, 0.7})
      for (const double restitution : {0.0, 0.6}) {
        CAPTURE(static_cast<int>(friction.kind));
        CAPTURE(theta);
        CAPTURE(restitution);
        Network net = block_at({-0.1, -0.1, 0.6}, {0.1, 0.0, -1.0}, 6);
        Instrument ball;
        ball.name = "ball";
        ball.radius = 0.5;
        ball.friction = friction;
        ball.restitution = restitution;
        ball.motion = Motion{};
        ball.motion->times = {0.0, 1.0};
        ball.motion->displacements = {{0, 0, 0}, {0.1, 0, 0.2}};
        ball.turn = Turn{};
        ball.turn->axis = {0.2, 1.0, 0.0};
        ball.turn->rate = 0.7;
        net.add_instrument(ball);
        check_derivatives(net, theta, friction.kind == Friction::Kind::coulomb ? wavefront : newton, 0.3,
                          values_of(net), 0.01);
      }
}

TEST_CASE("derivatives of nodes that slide along the edge of two surfaces, and are stuck there") {
  for (const double coefficient : {0.0, 0.1, 0.5})
    for (const double theta : {1.0, 0.5}) {
      CAPTURE(coefficient);
      CAPTURE(theta);
      Network net;
      net.add_node(point({0.0, 0.05, 0.05}, 1.0, {0.5, -1.0, -1.0}));
      net.add_node(point({0.3, 0.4, 0.4}, 2.0));
      net.add_spring(0, 1, net.add_material(damped(20.0, 1.0)));
      net.set_gravity({0, -6, -7});
      net.add_spring(1, net.add_node(point({0.7, 0, 0}, 1.0)), 0);  // lies on the edge
      const Friction friction = coefficient > 0.0 ? Friction{Friction::Kind::coulomb, coefficient} : smooth;
      net.add_plane(floor_with(friction));
      Plane wall = floor_with(friction, {0, 1, 0.2});
      wall.name = "wall";
      net.add_plane(wall);
      std::vector<LearnedValues> learned = values_of(net);
      learned.back().members = {0, 1};
      // The node that lies on the edge slips at the start, or in the first step, as rounding decides.
      check_derivatives(net, theta, newton, 0.2, learned, 0.01, 0.0, false);
    }
}

TEST_CASE("derivatives of nets with rigid connections, with masses among the values") {
  for (const double theta : {1.0, 0.5, 0.7}) {
    CAPTURE(theta);
    // A tetrahedron with all of its six edges, one of which is told twice, that hangs on springs; and a pendulum.
    Network net = block_at({0, 0, 0}, {0.5, 0, 0.3}, 7);
    const NodeIndex first = static_cast<NodeIndex>(net.nodes().size());
    Dice dice(2);
    for (const Vector3& at : {Vector3(1, 0, 0), Vector3(1.3, 0, 0), Vector3(1, 0.4, 0), Vector3(1, 0, 0.5)})
      net.add_node(point(at + dice.in_box(0.05), dice.between(0.5, 2.0)));
    for (NodeIndex a = first; a < first + 4; ++a)
      for (NodeIndex b = a + 1; b < first + 4; ++b) net.add_rigid(a, b);
    const MaterialIndex soft = net.add_material(damped(50.0, 0.5));
    net.add_spring(1, first, soft);
    net.add_spring(3, first + 2, soft);
    net.fix(0);
    const NodeIndex end = net.add_node(point({0.2, -0.7, 0.1}, 1.5));
    const NodeIndex last = net.add_node(point({0.6, -0.9, 0.4}, 0.8));
    net.add_rigid(0, end);
    net.add_rigid(end, last);
    std::vector<LearnedValues> learned = values_of(net);
    learned.pop_back();
    check_derivatives(net, theta, newton, 0.3, learned, 0.02);
  }
}

TEST_CASE("derivatives of rigid bodies that touch a plane, with every friction and theta") {
  for (const Friction& friction : {held, smooth, rough})
    for (const double theta : {1.0, 0.6})
      for (const double restitution : {0.0, 0.5}) {
        CAPTURE(static_cast<int>(friction.kind));
        CAPTURE(theta);
        CAPTURE(restitution);
        // A rigid tetrahedron that carries a load on springs, and beside it a rod that falls flat. What holds three
        // nodes of a rigid body, however it turns, has no steps that settle: there it stays above.
        Network net;
        Dice dice(1);
        const Vector3 above(0, 0, friction.kind == Friction::Kind::held ? 2.0 : 0.0);
        for (const Vector3& at :
             {Vector3(0, 0, 0.05), Vector3(0.3, 0, 0.08), Vector3(0, 0.4, 0.12), Vector3(0, 0, 0.5)})
          net.add_node(point(at + dice.in_box(0.02) + above, dice.between(0.5, 2.0), {0.5, 0.1, -0.6}));
        for (NodeIndex a = 0; a < 4; ++a)
          for (NodeIndex b = a + 1; b < 4; ++b) net.add_rigid(a, b);
        const MaterialIndex soft = net.add_material(damped(50.0, 0.5));
        const NodeIndex carried = net.add_node(point(Vector3(0.1, 0.1, 0.9) + above, 1.5, {0.5, 0.1, -0.6}));
        net.add_spring(3, carried, soft);
        net.add_spring(1, carried, soft);
        net.add_rigid(net.add_node(point(dice.in_box(0.02) + Vector3(1, 0, 0.03), 1.0, {0, 0, -0.3})),
                      net.add_node(point({1, 0.5, 0.06}, 1.0, {0.2, 0, -0.3})));
        net.add_spring(carried + 1, carried, soft);
        net.set_gravity({0, 0, -9.81});
        net.add_plane(floor_with(friction, {0.1, -0.05, 1.0}, restitution));
        std::vector<LearnedValues> learned = values_of(net);
        learned.back().members = {carried};
        // Forces of some 1000 N are not known to less.
        check_derivatives(net, theta, wavefront, 0.25, learned, 0.005, 3e-10);
      }
}

TEST_CASE("derivatives of contact and rigid connections in a net whose laws have internal states") {
  for (const Friction& friction : {smooth, rough})
    for (const double theta : {1.0, 0.6}) {
      CAPTURE(static_cast<int>(friction.kind));
      CAPTURE(theta);
      Network net = block_at({0, 0, 0.1}, {0.4, 0.2, -0.5}, 6);
      const MaterialIndex relaxing =
          net.add_material({LawUse{"maxwell", {{"stiffness", 80.0}, {"relaxation_time", 0.1}}}, std::nullopt});
      const std::size_t before = net.springs().size();
      net.add_spring(0, 7, relaxing);
      net.add_spring(2, 5, relaxing);
      const NodeIndex first = net.add_node(point({0.5, 0, 0.5}, 0.7));
      const NodeIndex second = net.add_node(point({0.5, 0.3, 0.6}, 1.2));
      net.add_rigid(first, second);
      net.add_spring(1, first, relaxing);
      net.add_plane(floor_with(friction, {0.2, -0.1, 1.0}));
      check_derivatives(net, theta, newton, 0.3,
                        {{Kind::spring_parameter, false, "relaxation_time", from_to(before, net.springs().size())},
                         {Kind::spring_parameter, false, "stiffness", from_to(0, net.springs().size())},
                         {Kind::mass, false, "", from_to(0, net.nodes().size())},
                         {Kind::initial_velocity, false, "", from_to(0, 8)}});
    }
}

namespace {

// Pushed over a rough floor while a spring in it breaks; a node above is held.
Network pushed() {
  Network net = block_at({0, 0, 0.1}, {0.4, 0.2, -0.5}, 6);
  Load push;
  push.nodes = {6, 7};
  push.force = {3.0, -1.0, -2.0};
  net.add_load(push);
  const MaterialIndex weak = net.add_material(
      {LawUse{"rupturing", {{"stiffness", 30.0}, {"strength", 0.05}}}, LawUse{"linear", {{"damping", 0.5}}}});
  net.add_spring(0, 7, weak);
  const NodeIndex hook = net.add_node(point({0.1, 0.1, 1.0}, 1.0));
  net.fix(hook);
  net.add_spring(7, hook, net.add_material(damped(20.0, 0.3)));
  net.add_plane(floor_with(rough, {0.2, -0.1, 1.0}));
  return net;
}

std::vector<LearnedValues> values_of_pushed(const Network& net) {
  return {{Kind::load, false, "", {0}},
          {Kind::spring_parameter, false, "stiffness", from_to(0, net.springs().size())},
          {Kind::mass, false, "", from_to(0, 8)}};
}

}  // namespace

TEST_CASE("derivatives of contact while a spring breaks, with a load among the values") {
  const Network net = pushed();
  for (const double theta : {1.0, 0.6}) {
    CAPTURE(theta);
    MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), method(theta, newton), 0.4,
                             values_of_pushed(net));
    motion.run(motion.values_of_network());
    const std::vector<Event> events = motion.events();
    const auto count = [&](Event::Kind kind) {
      return std::count_if(events.begin(), events.end(), [&](const Event& each) { return each.kind == kind; });
    };
    REQUIRE(count(Event::Kind::ruptured) == 1);
    REQUIRE(count(Event::Kind::touched) > 2);
    check_derivatives(net, theta, newton, 0.4, values_of_pushed(net));
  }
}

TEST_CASE("contact is differentiated with the same bits in little memory, and step by step") {
  const auto net = std::make_shared<const Network>(pushed());
  MotionDerivatives motion(net, plugins(), method(0.6, newton, 0.005), 0.9, values_of_pushed(*net));
  const VectorXd values = motion.values_of_network();
  motion.run(values);
  const Loss loss(motion.step_count() + 1, net->nodes().size());
  const VectorXd gradient = loss.gradient(motion);
  Eigen::MatrixXd at_end;
  motion.tangent(Eigen::MatrixXd::Identity(values.size(), values.size()),
                 [&](std::size_t, const Eigen::MatrixXd& positions, const Eigen::MatrixXd&) { at_end = positions; });
  const std::size_t steps = motion.step_count();

  MotionDerivatives in_little(net, plugins(), method(0.6, newton, 0.005), 0.9, values_of_pushed(*net));
  in_little.set_memory(60000);
  in_little.run(values);
  REQUIRE(in_little.kept().states < steps);
  CHECK(loss.gradient(in_little) == gradient);

  const Eigen::MatrixXd all_of_them = Eigen::MatrixXd::Identity(values.size(), values.size());
  motion.begin_steps(values, all_of_them);
  for (std::size_t k = 0; k < steps; ++k) motion.make_step(values, all_of_them);
  Eigen::MatrixXd positions, velocities;
  motion.step_tangents(1, positions, velocities);
  CHECK((positions - at_end).norm() <= 1e-8 * at_end.norm());
}

// Differences of sweeps take time in proportion to a high power of their number.
TEST_CASE("rigid connections of many nodes that touch are refused with their number and node") {
  Network net;
  for (NodeIndex k = 0; k < 42; ++k) {
    net.add_node(point({0.1 * k, k % 2 == 0 ? 0.0 : 0.1, 0.002 + 0.001 * k}, 1.0, {0, 0, -1.0}));
    if (k > 0) net.add_rigid(k - 1, k);
  }
  net.add_plane(floor_with(smooth));
  MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), method(1.0, wavefront, 0.005), 0.005,
                           {{Kind::mass, false, "", {0}}});
  motion.run(motion.values_of_network());
  std::string said;
  try {
    static_cast<void>(gradient_of_end(motion, 0, 2));
  } catch (const Error& error) {
    said = error.what();
  }
  CAPTURE(said);
  CHECK(said.find("rigid connections join 42 nodes, of which node 0 touches plane 'floor' (number 0) at 0.005 s; up to "
                  "40 are differentiated while they touch") != std::string::npos);
}

TEST_CASE("velocities of nodes that are constrained from the start are refused") {
  Network net = block_at({0, 0, 0.1}, {0, 0, 0});
  net.add_rigid(2, 5);
  Node resting = point({3, 0, 0}, 1.0);
  const NodeIndex lying = net.add_node(resting);
  net.add_plane(floor_with(smooth));
  for (const NodeIndex node : {NodeIndex{2}, lying})
    CHECK(refusal_of([&] {
            MotionDerivatives(std::make_shared<const Network>(net), plugins(), method(1.0, newton), 0.1,
                              {{Kind::initial_velocity, false, "", {node}}});
          }).find("is in contact or rigidly connected at the start") != std::string::npos);
}

TEST_CASE("a search tells of contacts, and how many happen in other steps than at its start") {
  const auto falls = [](double height) {
    Network net;
    net.add_node(point({0, 0, height}, 1.0));
    net.add_node(point({0, 0, height + 1.0}, 1.0));
    net.add_spring(0, 1, net.add_material(damped(50.0, 1.0)));
    net.set_gravity({0, 0, -10});
    net.add_plane(floor_with(held));
    return net;
  };
  const Network net = falls(0.2);
  Simulation real(net, plugins(), method(1.0, newton));
  for (const NodeIndex k : {0U, 1U}) real.set_velocity(k, {0, 0, 1.0});  // so that it touches later
  const Observations seen = observe(real, 30, {0, 1});
  const LearnedNet learned = learn({experiment(net, method(1.0, newton), seen)}, plugins(),
                                   {{{Kind::initial_velocity, false, "", {0, 1}}}}, LearnOptions{});
  std::string notes;
  for (const std::string& each : learned.notes) notes += each + "\n";
  CAPTURE(notes);
  CHECK(notes.find("The motion has 1 change of contact, from") != std::string::npos);
  CHECK(notes.find("; 1 of them in other steps than") != std::string::npos);
}
