// Gravity that is learned, by its components or its strength.

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "learning_nets.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// A chain that hangs from a fixed node, with a force at its end.
Network hanging_in(const Vector3& gravity, double stiffness = 60.0) {
  Network net = chain(5, {0, 0, 0}, {0.8, 0, -0.6}, damped(stiffness, 0.6));
  net.fix(0);
  net.set_gravity(gravity);
  Load load;
  load.nodes = {4};
  load.force = {0.5, 0.2, 0.0};
  net.add_load(load);
  return net;
}

LearnedNet learned_from(const Network& real, const Network& guess, const std::vector<const char*>& what) {
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  Simulation simulation(real, plugins(), options);
  std::vector<Learnable> learnables;
  for (const char* const each : what) learnables.push_back(select_learnable(guess, *plugins(), each));
  return learn({experiment(guess, options, observe(simulation, 30, from_to(1, 5)))}, plugins(), learnables);
}

}  // namespace

TEST_CASE("the direction of gravity is recovered from motion, also with stiffnesses, and written") {
  const Vector3 real(1.5, -0.7, -9.6);
  const Network guess = hanging_in({0, 0, -9.81}, 45.0);
  const LearnedNet learned = learned_from(hanging_in(real), guess, {"gravity", "spring.stiffness"});
  CAPTURE(learned.reason);
  CHECK(learned.undetermined == 0);
  REQUIRE(learned.parameters.size() == 7);
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const LearnedParameter& each = learned.parameters[axis];
    CHECK(each.kind == LearnedValues::Kind::gravity);
    CHECK(each.member == axis);
    CHECK(each.start == (axis == 2 ? -9.81 : 0.0));
    CHECK(each.value == doctest::Approx(real[axis]).epsilon(1e-7));
  }
  CHECK(learned.parameters[5].value == doctest::Approx(60.0).epsilon(1e-6));
  CHECK(name_of(learned.parameters[2]) == "gravity.z");
  CHECK(to_json(learned).find("\"kind\": \"gravity\",\n      \"axis\": 2") != std::string::npos);
  const std::vector<Learnable> all{select_learnable(guess, *plugins(), "gravity"),
                                   select_learnable(guess, *plugins(), "spring.stiffness")};
  const Network written = with_values(std::make_shared<const Network>(guess), plugins(), all, learned.values);
  CHECK((written.gravity() - real).norm() < 1e-6);
}

TEST_CASE("the strength of gravity keeps its direction, a component the others") {
  const Vector3 down(0.6, 0.0, -0.8);
  const LearnedNet together = learned_from(hanging_in(9.81 * down), hanging_in(7.0 * down), {"gravity:together"});
  REQUIRE(together.parameters.size() == 2);  // y is 0, and stays so
  CHECK(together.variables == 1);
  CHECK(together.parameters[0].value == doctest::Approx(9.81 * down[0]).epsilon(1e-8));
  CHECK(together.parameters[1].member == 2);
  CHECK(together.parameters[1].value == doctest::Approx(9.81 * down[2]).epsilon(1e-8));
  const LearnedNet one = learned_from(hanging_in({0.3, 0.4, -9.0}), hanging_in({0.3, 0.4, -5.0}), {"gravity@z"});
  REQUIRE(one.parameters.size() == 1);
  CHECK(one.parameters[0].value == doctest::Approx(-9.0).epsilon(1e-8));
}

TEST_CASE("masses, stiffnesses, dampings and forces have one factor in common, gravity has it not") {
  const std::vector<const char*> all{"mass:together", "spring.stiffness:together", "viscosity.damping:together",
                                     "load"};
  const Network net = hanging_in({0, 0, -9.81});
  CHECK(learned_from(net, net, all).undetermined == 1);
  std::vector<const char*> with_gravity = all;
  with_gravity.push_back("gravity");
  const LearnedNet learned = learned_from(net, net, with_gravity);
  CHECK(learned.undetermined == 1);
  for (const LearnedParameter& each : learned.parameters) {
    const bool is_gravity = each.kind == LearnedValues::Kind::gravity;
    CAPTURE(name_of(each));
    CHECK((each.determined > 1.0 - 1e-9) == is_gravity);
  }
}

TEST_CASE("gravity that is not there, or another one in each experiment, is refused") {
  const auto refused = [&](const Network& of, const char* text) {
    return refusal_of([&] { static_cast<void>(select_learnable(of, *plugins(), text)); });
  };
  CHECK(refused(hanging_in({0, 0, 0}), "gravity").find("there is no gravity") != std::string::npos);
  CHECK(refused(hanging_in({0, 0, -9.81}), "gravity@down").find("x, y or z") != std::string::npos);
  CHECK(refused(hanging_in({0, 0, -9.81}), "gravity@x:together").find("is 0, and stays so") != std::string::npos);
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  const Network upright = hanging_in({0, 0, -9.81}), turned = hanging_in({9.81, 0, 0});
  Simulation one(upright, plugins(), options), other(turned, plugins(), options);
  const std::vector<Experiment> both{experiment(upright, options, observe(one, 5, {4})),
                                     experiment(turned, options, observe(other, 5, {4}))};
  const auto learned_of = [&](const char* what) {
    return refusal_of(
        [&] { static_cast<void>(learn(both, plugins(), {select_learnable(upright, *plugins(), what)})); });
  };
  CHECK(learned_of("gravity").find("experiment 2 starts with another one") != std::string::npos);
  CHECK(learned_of("spring.stiffness").empty());
}
