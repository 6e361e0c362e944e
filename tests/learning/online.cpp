// Learning while the net moves: sensitivities against the tangent, costs that fall, limits of memory.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "learning_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// A chain that hangs in a viscous fluid and is driven at its end: what was learned wrongly at first is forgotten.
Network driven(double stiffness, double damping) {
  Network net = chain(6, {0, 0, 0}, {0, 0, -1}, damped(stiffness, damping));
  const auto dragged = net.add_neuron({"dragged", {{"drag", 1.0}}});
  for (NodeIndex k = 0; k < 6; ++k) {
    Node node = net.nodes()[k];
    node.neuron = dragged;
    net.set_node(k, node);
  }
  net.fix(0);
  net.set_gravity({0, 0, -2});
  Load load;
  load.nodes = {5};
  load.force = {0.3, 0.2, 1.0};
  load.course.frequency = 0.4;
  net.add_load(load);
  return net;
}

Observations at_the_end(const Simulation& simulation) {
  Observations result;
  for (NodeIndex k = 1; k < 6; ++k) result.positions.push_back(row(simulation.time(), k, simulation.position(k)));
  return result;
}

}  // namespace

TEST_CASE("sensitivities that are carried along are those of the whole motion") {
  const auto net = std::make_shared<const Network>(driven(30.0, 1.0));
  for (const double theta : {1.0, 0.5}) {
    const auto make = [&] {
      return MotionDerivatives(net, plugins(), to_learn_with(theta, 0.05), 0.5,
                               {{Kind::spring_parameter, false, "stiffness", from_to(0, 5)},
                                {Kind::initial_velocity, false, "", from_to(1, 6)}});
    };
    MotionDerivatives whole = make(), online = make();
    const Eigen::VectorXd values = whole.values_of_network();
    const Eigen::MatrixXd changes = Eigen::MatrixXd::Identity(values.size(), values.size());
    whole.run(values);
    std::vector<Eigen::MatrixXd> at_all;
    whole.tangent(changes, [&](std::size_t, const Eigen::MatrixXd& positions, const Eigen::MatrixXd&) {
      at_all.push_back(positions);
    });
    online.begin_steps(values, changes);
    Eigen::MatrixXd positions, velocities;
    for (std::size_t k = 1; k <= whole.step_count(); ++k) {
      online.make_step(values, changes);
      // A step after values were set starts from no guess, and ends within the tolerance of the other one.
      CHECK((online.positions(1) - whole.positions(k)).norm() <= 1e-12);
      for (const std::size_t end : {0, 1}) {
        online.step_tangents(end, positions, velocities);
        CHECK((positions - at_all[k - 1 + end]).norm() <= 1e-9 * (1.0 + at_all[k].norm()));
      }
    }
  }
}

TEST_CASE("the paper's method lowers the cost while the net moves, and does not find what acts little") {
  const SimulationOptions options = to_learn_with(0.5, 0.05);
  const auto guess = std::make_shared<const Network>(driven(24.0, 0.8));
  const std::vector<Learnable> together{{{Kind::spring_parameter, false, "stiffness", from_to(0, 5)}, true},
                                        {{Kind::viscosity_parameter, false, "damping", from_to(0, 5)}, true}};
  Simulation real(driven(30.0, 1.0), plugins(), options), untaught(*guess, plugins(), options);
  OnlineLearner learner(guess, plugins(), options, together);
  Observations all;
  double late = 0.0, late_untaught = 0.0;
  for (int i = 0; i < 1200; ++i) {
    real.step();
    untaught.step();
    const Observations seen = at_the_end(real);
    if (i < 100) all.append(seen);
    const double cost = learner.step(seen);
    CHECK(learner.time() == real.time());
    if (i < 1100) continue;
    late += cost;
    for (const Observations::VectorRow& each : seen.positions)
      late_untaught += 0.5 * (untaught.position(each.node) - each.value).squaredNorm();
  }
  CHECK(late < 1e-3 * late_untaught);
  CHECK(learner.values()[0] == doctest::Approx(30.0).epsilon(0.01));
  // Its gradient is small beside that of the stiffness: steepest descent hardly moves it, in contrast to learn().
  CHECK(learner.values()[5] < 0.95);
  const LearnedNet whole = learn({{guess, options, all}}, plugins(), together);
  CHECK(whole.parameters[0].value == doctest::Approx(30.0).epsilon(1e-6));
  CHECK(whole.parameters[5].value == doctest::Approx(1.0).epsilon(1e-6));
  // Nothing observed: a step without a lesson.
  const Eigen::VectorXd before = learner.values();
  CHECK(learner.step({}) == 0.0);
  CHECK(learner.values() == before);
}

TEST_CASE("both methods are compared by the cost of the whole motion, over the work") {
  const SimulationOptions options = to_learn_with(0.5, 0.05);
  const auto guess = std::make_shared<const Network>(driven(24.0, 0.8));
  const std::vector<Learnable> together{{{Kind::spring_parameter, false, "stiffness", from_to(0, 5)}, true},
                                        {{Kind::viscosity_parameter, false, "damping", from_to(0, 5)}, true}};
  Simulation real(driven(30.0, 1.0), plugins(), options);
  constexpr int steps = 60;
  const Experiment seen{guess, options, observe(real, steps, from_to(1, 6))};
  std::vector<LearnProgress> told_whole, told_online;
  LearnOptions whole;
  whole.on_iteration = [&](const LearnProgress& now) {
    told_whole.push_back(now);
    return true;
  };
  const LearnedNet best = learn({seen}, plugins(), together, whole);
  const LearnedNet online = learn_online(seen, plugins(), together, {}, [&](const LearnProgress& now) {
    told_online.push_back(now);
    return true;
  });
  const LearnCourse of_whole = course_of("trajectory", told_whole, seen, plugins(), together);
  const LearnCourse of_online = course_of("online", told_online, seen, plugins(), together);
  REQUIRE(of_online.points.size() == steps + 1);
  CHECK(of_online.parameters == std::vector<std::size_t>{0, 5});
  // The same start and the same measure; each ends with the cost that its method has found.
  CHECK(of_whole.points.front().cost == of_online.points.front().cost);
  CHECK(of_whole.points.front().cost == doctest::Approx(best.start_cost).epsilon(1e-12));
  CHECK(of_online.points.back().cost == doctest::Approx(online.cost).epsilon(1e-9));
  CHECK(of_whole.points.back().cost <= best.cost + 1e-12 * best.start_cost);
  CHECK(of_online.points.back().cost < of_online.points.front().cost);
  CHECK(of_whole.points.back().cost < 1e-6 * of_online.points.back().cost);
  CHECK(of_online.points.back().values[0] == online.parameters[0].value);
  CHECK(of_whole.points.back().values[1] == doctest::Approx(1.0).epsilon(1e-5));
  // A motion with the derivatives by two variables is the work of three; the whole search makes several.
  CHECK(of_online.points.back().work == doctest::Approx(3.0));
  CHECK(of_online.points[20].work == doctest::Approx(1.0));
  // An iteration: a motion of seven steps, which is what was observed in an eighth of the time, and its derivatives.
  REQUIRE(told_whole[1].share == 0.125);
  CHECK(told_whole[1].work - told_whole[0].work >= 3.0 * 7.0);
  for (const LearnCourse* const each : {&of_whole, &of_online})
    CHECK(std::is_sorted(each->points.begin(), each->points.end(),
                         [](const auto& one, const auto& other) { return one.work < other.work; }));
  // On the way the values are those of that time: the cost of a motion that goes on with them.
  const LearnCourse::Point& early = of_online.points[10];
  const Network with = with_values(guess, plugins(), together, told_online[9].values);
  Simulation again(with, plugins(), options);
  double cost = 0.0;
  for (std::size_t row = 0; row < seen.observations.positions.size(); ++row) {
    if (row % 5 == 0) again.step();
    const Observations::VectorRow& each = seen.observations.positions[row];
    cost += 0.5 * (again.position(each.node) - each.value).squaredNorm();
  }
  CHECK(early.cost == doctest::Approx(cost).epsilon(1e-8));
}

TEST_CASE("noise does not make the values run away while the net moves") {
  // At first nothing has moved: the differences are noise, and sensitivities are small beside it.
  const SimulationOptions options = to_learn_with(0.5, 0.05);
  const auto guess = std::make_shared<const Network>(driven(24.0, 0.8));
  Simulation real(driven(30.0, 1.0), plugins(), options), still(driven(30.0, 1.0), plugins(), options);
  Observations seen = observe(real, 200, from_to(1, 6));
  double square = 0.0;
  for (const auto& each : seen.positions) square += (each.value - still.position(each.node)).squaredNorm();
  const double noise = 0.01 * std::sqrt(square / static_cast<double>(seen.positions.size()));
  Dice dice(3);
  for (auto& each : seen.positions) each.value += noise * normal(dice);
  for (const bool together : {true, false})
    for (const double rate : {0.01, 0.05, 0.3}) {
      CAPTURE(together);
      CAPTURE(rate);
      OnlineOptions online;
      online.rate = rate;
      double longest = 0.0;  // of a step, of logarithms and of multiples of the start
      Eigen::VectorXd before;
      const auto watch = [&](const LearnProgress& now) {
        if (before.size() > 0)
          longest = std::max(longest, (now.values - before).cwiseAbs().maxCoeff() / before.cwiseAbs().minCoeff());
        before = now.values;
        return true;
      };
      const LearnedNet learned =
          learn_online({guess, options, seen}, plugins(),
                       {{{Kind::spring_parameter, false, "stiffness", from_to(0, 5)}, together}}, online, watch);
      CHECK(learned.cost < learned.start_cost);
      // Half of the rate, relative to the start of the values.
      CHECK(longest <= 0.5 * rate * 24.0 / 15.0);
      for (const LearnedParameter& each : learned.parameters) {
        CHECK(each.value > 15.0);
        CHECK(each.value < 50.0);
      }
    }
}

TEST_CASE("online learning refuses sensitivities beyond its memory, and times of other steps") {
  const auto net = std::make_shared<const Network>(driven(24.0, 0.8));
  const std::vector<Learnable> each{{{Kind::spring_parameter, false, "stiffness", from_to(0, 5)}}};
  const auto refusal = [&](const OnlineOptions& options, double time) {
    try {
      OnlineLearner learner(net, plugins(), to_learn_with(0.5, 0.05), each, options);
      Observations seen;
      seen.positions.push_back(row(time, 1, {1, 0, 0}));
      learner.step(seen);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refusal({}, 0.03).empty());
  OnlineOptions small;
  small.memory = 4 * 6 * 8 * 6 * 5 - 1;
  CHECK(refusal(small, 0.03).find("sensitivities of 6 nodes by 5 variables") != std::string::npos);
  OnlineOptions fast;
  fast.rate = 1.5;
  CHECK(refusal(fast, 0.03).find("the rate is 1.5") != std::string::npos);
  CHECK(refusal({}, 0.3).find("0.3") != std::string::npos);
}
