// Derivatives of motions in which springs break and are cut at the end of steps.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/learn.hpp>
#include <springnet/motion_derivatives.hpp>

#include "learning_nets.hpp"
#include "motion_loss.hpp"
#include "nets.hpp"
#include "torn_net.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

Network torn_with_damage() { return torn(0.2, true); }

std::vector<std::pair<double, std::uint32_t>> what_broke(const MotionDerivatives& motion) {
  std::vector<std::pair<double, std::uint32_t>> result;
  for (const Event& each : motion.events()) result.emplace_back(each.time, each.index + (each.element ? 1000U : 0U));
  return result;
}

}  // namespace

TEST_CASE("the gradient of a motion in which springs break is that of differences in which the same ones do") {
  const auto net = std::make_shared<const Network>(torn_with_damage());
  const auto springs = static_cast<SpringIndex>(net->springs().size());
  std::vector<std::uint32_t> weak = all(springs - 2);
  for (const double theta : {1.0, 0.5})
    for (const std::size_t memory : {std::size_t{1} << 30, std::size_t{90'000}}) {
      CAPTURE(theta);
      CAPTURE(memory);
      MotionDerivatives motion(net, plugins(), method(theta, newton, 0.01), 1.2,
                               {{Kind::spring_parameter, false, "stiffness", all(springs)},
                                {Kind::spring_parameter, false, "relaxation_time", {springs - 2, springs - 1}},
                                {Kind::viscosity_parameter, false, "damping", weak},
                                {Kind::spring_parameter, true, "stiffness", {0}},
                                {Kind::rest_length, false, "", all(springs)},
                                {Kind::mass, false, "", {1, 4, 7}},
                                {Kind::initial_velocity, false, "", {1, 2, 3}}});
      motion.set_memory(memory);
      const VectorXd values = motion.values_of_network();
      motion.run(values);
      const auto broken = what_broke(motion);
      const auto has = [&](std::uint32_t index) {
        return std::any_of(broken.begin(), broken.end(), [&](const auto& each) { return each.second == index; });
      };
      REQUIRE(broken.size() > 6);
      REQUIRE(broken.size() < springs - 6);
      REQUIRE(broken.front().first > 0.0);
      REQUIRE(has(0));
      REQUIRE(has(springs - 2));  // a damaged one
      REQUIRE(has(1000));         // the angle
      const Loss loss(121, net->nodes().size());
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
          REQUIRE(what_broke(motion) == broken);
          return loss.of(motion);
        };
        constexpr double h = 2e-6;  // short, so that nothing breaks in another step
        const double difference = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
        CHECK(along[j] == doctest::Approx(difference).epsilon(2e-6));
        motion.run(values);
      }
    }
}

TEST_CASE("a spring that breaks while the net learns is gone from the next step's derivatives") {
  const auto net = std::make_shared<const Network>(torn_with_damage());
  const auto springs = static_cast<SpringIndex>(net->springs().size());
  const std::vector<LearnedValues> learned{{Kind::spring_parameter, false, "stiffness", all(springs)}};
  MotionDerivatives whole(net, plugins(), method(0.5, newton, 0.01), 0.6, learned);
  MotionDerivatives steps(net, plugins(), method(0.5, newton, 0.01), 0.6, learned);
  const VectorXd values = whole.values_of_network();
  whole.run(values);
  REQUIRE(whole.events().size() > 3);
  const Eigen::MatrixXd changes = Eigen::MatrixXd::Ones(values.size(), 1);
  std::vector<Eigen::MatrixXd> positions;
  whole.tangent(changes,
                [&](std::size_t, const Eigen::MatrixXd& p, const Eigen::MatrixXd&) { positions.push_back(p); });
  steps.begin_steps(values, changes);
  for (std::size_t k = 1; k <= whole.step_count(); ++k) {
    steps.make_step(values, changes);
    Eigen::MatrixXd p, v;
    steps.step_tangents(1, p, v);
    CAPTURE(k);
    CHECK(p.isApprox(positions[k], 1e-7));
  }
}

TEST_CASE("a search tells of ruptures, whose times its derivatives leave as they are") {
  const Network net = torn_with_damage();
  Simulation motion(net, plugins(), method(0.5, newton, 0.01));
  const Observations seen = observe(motion, 60, {3, 8});
  Learnable damping{{Kind::viscosity_parameter, false, "damping", {10, 11, 12}}, true};
  LearnOptions options;
  options.max_iterations = 2;
  options.stages = 1;
  const LearnedNet learned = learn({experiment(net, method(0.5, newton, 0.01), seen)}, plugins(), {damping}, options);
  std::string notes;
  for (const std::string& each : learned.notes) notes += each + "\n";
  const auto& events = motion.events();
  const auto first =
      std::find_if(events.begin(), events.end(), [](const Event& each) { return each.kind == Event::Kind::ruptured; });
  REQUIRE(first != events.end());
  CAPTURE(notes);
  const auto count =
      std::count_if(events.begin(), events.end(), [](const Event& each) { return each.kind == Event::Kind::ruptured; });
  CHECK(notes.find("The motion has " + std::to_string(count) + " ruptures, from " + fmt::format("{:g}", first->time) +
                   " s on; none of them in other steps") != std::string::npos);
}
