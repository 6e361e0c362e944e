// What surfaces make of a node's output at the end of a step, differentiated: the formulas of Contact's sweeps at their
// fixed point, where the update of a node by itself has the velocity V without surfaces, whatever the rule.
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "constraints/contact.hpp"

namespace springnet::learning {

// Contact of a node over a step.
struct StepContact {
  std::uint32_t node = 0;  // the engine's number
  Touch before, touch;     // committed at the start of the step; within it
  bool bounces = false;    // off those surfaces of `touch` that are new
  bool kept = false;       // no sweep decided: a slip goes on whatever the forces
};

// A node over a step from (p, v) to (P, U); m, m/s.
struct NodeOverStep {
  Vector3 p, v;
  Vector3 free;  // V
  Vector3 P, U;
};

struct StepPlacement {
  const Placement &start, &end;
  double h, theta;  // s, 1
};

struct OutputDerivative {
  Eigen::Matrix<double, 6, 9> by_state = Eigen::Matrix<double, 6, 9>::Zero();  // of (P, U) by (p, v, V)
  Eigen::Matrix<double, 6, 2> by_times = Eigen::Matrix<double, 6, 2>::Zero();  // by the times of start and end
  bool has_times = true;                                                       // else these are not known
};

// None if no formula gives (P, U): the contact is of a kind that is not differentiated.
[[nodiscard]] std::optional<OutputDerivative> output_derivative(const Contact& contact, const StepPlacement& step,
                                                                const StepContact& how, const NodeOverStep& node);

}  // namespace springnet::learning
