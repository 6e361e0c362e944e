// Losses of motions, for derivatives of them.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/motion_derivatives.hpp>

#include "generator.hpp"
#include "nets.hpp"

namespace springnet::testing {

inline std::vector<std::uint32_t> all(std::size_t count) {
  std::vector<std::uint32_t> result(count);
  for (std::size_t k = 0; k < count; ++k) result[k] = static_cast<std::uint32_t>(k);
  return result;
}

inline SimulationOptions method(double theta, double rule, double step = 0.02) {
  SimulationOptions options;
  options.integrator = recurrent(rule, rule == newton ? 1e-12 : 1e-11, {{"theta", theta}, {"max_sweeps", 100000}});
  options.time_step = step;
  options.threads = 1;
  return options;
}

// Steps are divided where events are located.
inline SimulationOptions located(double theta, double step, double rule = newton) {
  SimulationOptions result = method(theta, rule, step);
  result.integrator.parameters["events"] = 1.0;
  return result;
}

// Of the position of a node at the end by all values.
inline Eigen::VectorXd gradient_of_end(MotionDerivatives& motion, NodeIndex node, Eigen::Index axis) {
  return motion.adjoint([&](std::size_t state, MotionDerivatives::StateChange& add) {
    if (state == motion.step_count()) add.positions(axis, node) = 1.0;
  });
}

// A loss of all states, with weights at random, and its derivatives.
struct Loss {
  std::vector<MotionDerivatives::StateChange> weights;
  Loss(std::size_t states, std::size_t nodes) {
    Dice dice(9);
    for (std::size_t k = 0; k < states; ++k) {
      MotionDerivatives::StateChange one{Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(nodes)),
                                         Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(nodes))};
      for (Eigen::Index i = 0; i < one.positions.size(); ++i) {
        one.positions.data()[i] = dice.between(-1, 1);
        one.velocities.data()[i] = dice.between(-0.1, 0.1);
      }
      weights.push_back(one);
    }
  }
  [[nodiscard]] double of(const MotionDerivatives& motion) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < weights.size(); ++k)
      sum += weights[k].positions.cwiseProduct(motion.positions(k)).sum() +
             weights[k].velocities.cwiseProduct(motion.velocities(k)).sum();
    return sum;
  }
  [[nodiscard]] Eigen::VectorXd gradient(MotionDerivatives& motion) const {
    return motion.adjoint([&](std::size_t k, MotionDerivatives::StateChange& add) {
      add.positions += weights[k].positions;
      add.velocities += weights[k].velocities;
    });
  }
  [[nodiscard]] Eigen::VectorXd along(MotionDerivatives& motion, const Eigen::MatrixXd& changes) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(changes.cols());
    motion.tangent(changes, [&](std::size_t k, const Eigen::MatrixXd& positions, const Eigen::MatrixXd& velocities) {
      sum += positions.transpose() * weights[k].positions.reshaped() +
             velocities.transpose() * weights[k].velocities.reshaped();
    });
    return sum;
  }
};

}  // namespace springnet::testing
