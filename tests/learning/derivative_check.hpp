// The derivatives of a motion against differences of motions in which the same happens in the same steps.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/motion_derivatives.hpp>

#include "generator.hpp"
#include "motion_loss.hpp"
#include "nets.hpp"

namespace springnet::testing {

struct Differences {
  double way = 1e-5;       // of each value, relative to its size: so near that no event moves to another step
  double accuracy = 2e-7;  // what steps leave unsettled, over the way
  std::size_t memory = std::size_t{1} << 30;
  bool same_steps = true;  // events have to stay in their steps
};

// The adjoint against the tangent, to what linear systems are solved to, and both against differences of fourth order.
// Returns the number of events.
inline std::size_t check_derivatives(const Network& given, const SimulationOptions& options, double duration,
                                     std::vector<LearnedValues> learned, const Differences& how = {}) {
  const auto net = std::make_shared<const Network>(given);
  MotionDerivatives motion(net, plugins(), options, duration, std::move(learned));
  motion.set_memory(how.memory);
  const Eigen::VectorXd values = motion.values_of_network();
  motion.run(values);
  // There the derivative of the method has a kink of its order, or the motion a jump.
  using Happens = std::vector<std::tuple<long, Event::Kind, std::uint32_t>>;  // in which step, what, to which node
  const auto events_of = [&] {
    Happens result;
    for (const Event& each : motion.events())
      result.emplace_back(std::lround(std::ceil(each.time / options.time_step - 1e-6)), each.kind, each.index);
    return result;
  };
  const Happens events = events_of();
  const Loss loss(motion.step_count() + 1, net->nodes().size());
  const Eigen::VectorXd gradient = loss.gradient(motion);
  Dice dice(3);
  Eigen::MatrixXd changes(values.size(), 2);
  for (Eigen::Index i = 0; i < changes.size(); ++i)
    changes.data()[i] = dice.between(-1, 1) * std::max(0.1, std::abs(values[i % values.size()]));
  const Eigen::VectorXd along = loss.along(motion, changes);
  CHECK((motion.kept().steps_again > 0) == (how.memory < std::size_t{1} << 30));
  for (Eigen::Index j = 0; j < changes.cols(); ++j) {
    CHECK(gradient.dot(changes.col(j)) == doctest::Approx(along[j]).epsilon(1e-8));
    const auto at = [&](double h) {
      motion.run(values + h * changes.col(j));
      if (how.same_steps) REQUIRE(events_of() == events);
      return loss.of(motion);
    };
    const double h = how.way;
    const double difference = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
    CHECK(along[j] == doctest::Approx(difference).epsilon(how.accuracy));
  }
  return events.size();
}

}  // namespace springnet::testing
