// Times of observations between the states of a motion.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <springnet/motion_derivatives.hpp>

namespace springnet::learning {

// Between two states, positions are cubic Hermite splines of positions and velocities, velocities their derivatives: of
// third order, where a step is of second at most. The vector of a node is p[0] x + v[0] x' of a state and
// p[1] x + v[1] x' of the next one.
struct Between {
  std::size_t state = 0;
  double share = 0.0;           // of the step, 0 to 1
  double p[2] = {}, v[2] = {};  // of velocities in 1/s and 1
};

// state_times: s, ascending, two or more. rate: of the velocity in place of the position.
[[nodiscard]] Between between_states(const std::vector<double>& state_times, double time, bool rate);

// Positions, or velocities, of all nodes, [3][node].
[[nodiscard]] Eigen::Matrix3Xd vectors_at(const MotionDerivatives& motion, const Between& at);

}  // namespace springnet::learning
