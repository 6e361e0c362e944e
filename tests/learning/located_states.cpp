// Motions whose laws have internal states, with steps divided where events are located: the derivatives against
// differences of the motions.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/motion_derivatives.hpp>

#include "derivative_check.hpp"
#include "torn_net.hpp"
#include "touching_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// As where laws have no states: steps divided at events settle part by part.
constexpr Differences differences{3e-5, 1e-5};

struct Law {
  LawUse use;
  std::vector<const char*> parameters;
};

const Law maxwell{{"maxwell", {{"stiffness", 300.0}, {"relaxation_time", 0.04}}}, {"stiffness", "relaxation_time"}};
const Law solid{{"standard_linear_solid", {{"stiffness", 200.0}, {"fast_stiffness", 300.0}, {"relaxation_time", 0.03}}},
                {"stiffness", "fast_stiffness", "relaxation_time"}};
const Law plastic{
    {"plastic", {{"stiffness", 300.0}, {"yield_tension", 1.0}, {"hardening", 30.0}, {"relaxation_time", 0.02}}},
    {"stiffness", "yield_tension", "hardening", "relaxation_time"}};

// A block that falls, with a spring that has memory beside each other one.
Network block_with(const Law& law, const Vector3& velocity) {
  Network net = block_at({0, 0, 0.1}, velocity, 6);
  const MaterialIndex with_memory = net.add_material({law.use, std::nullopt});
  for (std::uint32_t s = 0, count = static_cast<std::uint32_t>(net.springs().size()); s < count; s += 2)
    net.add_spring(net.springs()[s].first, net.springs()[s].second, with_memory);
  return net;
}

std::vector<LearnedValues> values_of_block(const Network& net, const Law& law) {
  std::vector<std::uint32_t> plain, others;
  for (std::uint32_t s = 0; s < net.springs().size(); ++s)
    (net.materials()[net.springs()[s].material].viscosity ? plain : others).push_back(s);
  std::vector<LearnedValues> values{{Kind::spring_parameter, false, "stiffness", plain},
                                    {Kind::mass, false, "", all(net.nodes().size())},
                                    {Kind::initial_velocity, false, "", all(net.nodes().size())}};
  for (const char* each : law.parameters) values.push_back({Kind::spring_parameter, false, each, others});
  return values;
}

}  // namespace

TEST_CASE("events of a body whose springs have memory move with what it is made of") {
  for (const Law* const law : {&maxwell, &solid, &plastic})
    for (const Friction& friction : {held, smooth, rough})
      for (const double theta : {1.0, 0.5}) {
        CAPTURE(law->use.id);
        CAPTURE(static_cast<int>(friction.kind));
        CAPTURE(theta);
        Network net = block_with(*law, {0.4, 0.2, -0.5});
        net.add_plane(floor_with(friction, {0.2, -0.1, 1.0}, 0.4));
        CHECK(check_derivatives(net, located(theta, 0.01), 0.2, values_of_block(net, *law), differences) > 3);
      }
}

// Without restitution nodes stay, and the forces of springs with memory decide when they slip and are let go.
TEST_CASE("releases and slips of a body whose springs have memory move with what it is made of") {
  for (const Law* const law : {&maxwell, &plastic})
    for (const Friction& friction : {held, rough})
      for (const double theta : {1.0, 0.5}) {
        CAPTURE(law->use.id);
        CAPTURE(static_cast<int>(friction.kind));
        CAPTURE(theta);
        Network net = block_with(*law, {0.4, 0.2, -1.5});
        net.add_plane(floor_with(friction, {0.2, -0.1, 1.0}));
        // So near that no event moves to another step; what steps leave unsettled then shows as some 1e-5.
        const Differences how{1e-6, 1e-4};
        CHECK(check_derivatives(net, located(theta, 0.01), 0.14, values_of_block(net, *law), how) > 3);
      }
}

// The tension of a Maxwell spring that is drawn at a constant speed v is k v tau (1 - exp(-t / tau)): it lifts the mass
// from the floor when that is its weight.
TEST_CASE("a spring with memory lifts a mass at the time of the closed form, which moves with what it is made of") {
  constexpr double k = 40.0, tau = 0.3, speed = 1.0, g = 9.81;
  Network net;
  net.add_node(point({0, 0, 0}));
  const NodeIndex hook = net.add_node(point({0, 0, 1}));
  net.add_spring(
      0, hook, net.add_material({LawUse{"maxwell", {{"stiffness", k}, {"relaxation_time", tau}}}, std::nullopt}), 1.0);
  Move up;
  up.nodes = {hook};
  up.motion.interpolation = Motion::Interpolation::linear;
  up.motion.times = {0.0, 1.0};
  up.motion.displacements = {Vector3::Zero(), Vector3(0, 0, speed)};
  net.add_move(up);
  net.set_gravity({0, 0, -g});
  net.add_plane(floor_with(smooth));
  const std::vector<LearnedValues> values{{Kind::spring_parameter, false, "stiffness", {0}},
                                          {Kind::spring_parameter, false, "relaxation_time", {0}},
                                          {Kind::mass, false, "", {0}}};
  MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), located(0.5, 0.01), 0.7, values);
  motion.run(motion.values_of_network());
  const std::vector<Event> events = motion.events();
  const auto lifted =
      std::find_if(events.begin(), events.end(), [](const Event& each) { return each.kind == Event::Kind::released; });
  REQUIRE(lifted != events.end());
  // Steps of second order, of a thirtieth of the relaxation time.
  CHECK(lifted->time == doctest::Approx(-tau * std::log(1.0 - g / (k * speed * tau))).epsilon(1e-3));
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    CHECK(check_derivatives(net, located(theta, 0.01), 0.7, values, differences) > 0);
  }
}

TEST_CASE("springs that are damaged until they break do so at times that are part of the derivatives") {
  const Network net = torn(0.2037, true);
  const auto all_springs = static_cast<std::uint32_t>(net.springs().size());
  const std::vector<std::uint32_t> damaged{all_springs - 2, all_springs - 1};
  const std::vector<LearnedValues> values{{Kind::spring_parameter, false, "stiffness", all(all_springs)},
                                          {Kind::spring_parameter, false, "threshold_strain", damaged},
                                          {Kind::spring_parameter, false, "relaxation_time", damaged},
                                          {Kind::rest_length, false, "", all(all_springs)},
                                          {Kind::mass, false, "", {1, 4, 7}}};
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), located(theta, 0.011), 0.5, values);
    motion.run(motion.values_of_network());
    const std::vector<Event> events = motion.events();
    REQUIRE(std::any_of(events.begin(), events.end(), [&](const Event& each) {
      return each.kind == Event::Kind::ruptured && each.index >= damaged[0];
    }));
    CHECK(check_derivatives(net, located(theta, 0.011), 0.5, values, differences) > 6);
  }
}

TEST_CASE("an element breaks from damage at a time that is part of the derivatives, beside others that touch at once") {
  Network net;
  const NodeIndex a = net.add_node(point({0, 0, 0.3}, 1.0, {0, 0, -1.0})),
                  b = net.add_node(point({1.2, 0, 0.3}, 1.0, {0.3, 0, -1.0})),
                  c = net.add_node(point({0.1, 1.1, 0.9}, 1.5, {0, 0.2, -1.0}));
  net.add_element(Invariant::area, {a, b, c},
                  net.add_material({LawUse{"damaging",
                                           {{"stiffness", 40.0},
                                            {"threshold_strain", 0.01},
                                            {"softening_strain", 0.3},
                                            {"relaxation_time", 0.05},
                                            {"breaking_damage", 0.4}}},
                                    std::nullopt}),
                  0.5);
  const MaterialIndex relaxing = net.add_material({maxwell.use, std::nullopt});
  net.add_spring(a, c, relaxing);
  net.add_spring(b, c, relaxing);
  Plane floor = floor_with(smooth, Vector3::UnitZ(), 0.5);
  net.add_plane(floor);
  const std::vector<LearnedValues> values{{Kind::spring_parameter, true, "stiffness", {0}},
                                          {Kind::spring_parameter, true, "threshold_strain", {0}},
                                          {Kind::rest_length, true, "", {0}},
                                          {Kind::spring_parameter, false, "relaxation_time", {0, 1}},
                                          {Kind::mass, false, "", {0, 1, 2}}};
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), located(theta, 0.011), 0.4, values);
    motion.run(motion.values_of_network());
    const std::vector<Event> events = motion.events();
    REQUIRE(std::any_of(events.begin(), events.end(),
                        [](const Event& each) { return each.kind == Event::Kind::ruptured && each.element; }));
    CHECK(check_derivatives(net, located(theta, 0.011), 0.4, values, differences) > 1);
  }
}

// The end of the spring is so heavy that its length stays: damage goes to its aim g as d = g (1 - exp(-t / tau)), the
// spring breaks at tb = -tau log(1 - b / g), and by then it has given the mass the momentum
//   k x (tb - g (tb - tau (1 - exp(-tb / tau)))),   1 - exp(-tb / tau) = b / g.
TEST_CASE("the momentum that a spring gives until damage breaks it has the derivatives of the closed form") {
  constexpr double k = 40.0, x = 0.2, threshold = 0.05, softening = 0.3, tau = 0.1, breaking = 0.2, mass = 1e6;
  const auto velocity = [](double stiffness, double e0, double relaxation) {
    const double g = (e0 + softening) / softening * (1.0 - e0 / x);
    const double end = -relaxation * std::log(1.0 - breaking / g);
    return -stiffness * x * (end - g * end + relaxation * breaking) / mass;
  };
  Network net;
  Node wall = point({0, 0, 0});
  wall.fixed = true;
  net.add_node(wall);
  net.add_node(point({1.0 + x, 0, 0}, mass));
  const MaterialIndex damaged = net.add_material({LawUse{"damaging",
                                                         {{"stiffness", k},
                                                          {"threshold_strain", threshold},
                                                          {"softening_strain", softening},
                                                          {"relaxation_time", tau},
                                                          {"breaking_damage", breaking}}},
                                                  std::nullopt});
  net.add_spring(0, 1, damaged, 1.0);
  MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), located(0.5, 0.001), 0.1,
                           {{Kind::spring_parameter, false, "stiffness", {0}},
                            {Kind::spring_parameter, false, "threshold_strain", {0}},
                            {Kind::spring_parameter, false, "relaxation_time", {0}}});
  motion.run(motion.values_of_network());
  REQUIRE(motion.events().size() == 1);
  const std::size_t last = motion.step_count();
  // Steps of second order, of a hundredth of the relaxation time; the length changes by less than 1e-6 of itself.
  constexpr double accuracy = 1e-4;
  CHECK(motion.velocities(last)(0, 1) == doctest::Approx(velocity(k, threshold, tau)).epsilon(accuracy));
  const Eigen::VectorXd gradient = motion.adjoint([last](std::size_t state, MotionDerivatives::StateChange& add) {
    if (state == last) add.velocities(0, 1) = 1.0;
  });
  constexpr double d = 1e-5;
  const Eigen::Vector3d right(
      (velocity(k * (1 + d), threshold, tau) - velocity(k * (1 - d), threshold, tau)) / (2 * d * k),
      (velocity(k, threshold + d, tau) - velocity(k, threshold - d, tau)) / (2 * d),
      (velocity(k, threshold, tau + d * tau) - velocity(k, threshold, tau - d * tau)) / (2 * d * tau));
  for (Eigen::Index i = 0; i < 3; ++i) {
    CAPTURE(i);
    CHECK(gradient[i] == doctest::Approx(right[i]).epsilon(accuracy));
  }
}
