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
  // It ends the step with the velocity that takes it to the surface, which then stops it: see Contact::arrives.
  bool arrives = false;
};
[[nodiscard]] bool arrives(const Contact& contact, const StepContact& how);

// A node over a step from (p, v) to (P, U); m, m/s.
struct NodeOverStep {
  Vector3 p, v;
  Vector3 free;  // V
  Vector3 P, U;
  double unsettled = 0.0;  // m/s: how far V, and so P / h and U, may be from those of a step that is settled exactly
};

// A node that has arrived: its velocity in the step, m/s, and how that at the end follows it and P.
struct Arrival {
  std::uint32_t node;
  Vector3 velocity;
  Matrix3 by_position, by_velocity;  // 1/s, 1
};

struct StepPlacement {
  const Placement &start, &end;
  double h, theta;  // s, 1
};

struct OutputDerivative {
  Eigen::Matrix<double, 6, 9> by_state = Eigen::Matrix<double, 6, 9>::Zero();     // of (P, U) by (p, v, V)
  Eigen::Matrix<double, 6, 2> by_times = Eigen::Matrix<double, 6, 2>::Zero();     // by the times of start and end
  bool has_times = true;                                                          // else these are not known
  Eigen::Matrix<double, 6, 2> by_friction = Eigen::Matrix<double, 6, 2>::Zero();  // of the first and second surface
};

// Of a node whose velocity at the end of the step is `node.U`; `free` is not read.
[[nodiscard]] Arrival arrival_of(const Contact& contact, const StepPlacement& step, const StepContact& how,
                                 const NodeOverStep& node);
// None if no formula gives (P, U): the contact is of a kind that is not differentiated.
[[nodiscard]] std::optional<OutputDerivative> output_derivative(const Contact& contact, const StepPlacement& step,
                                                                const StepContact& how, const NodeOverStep& node);

}  // namespace springnet::learning
