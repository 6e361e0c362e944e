// What rigid connections make of the outputs of a cluster at the end of a step, differentiated; see rigid_sweep.cpp:
//
//   U = V + W G(P)^T x,  G(P) U = 0;  P: p + c v + w U, corrected to the lengths.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "constraints/rigid.hpp"
#include "learning/rod_lengths.hpp"

namespace springnet::learning {

struct ClusterOverStep {
  std::vector<std::uint32_t> nodes;  // the engine's numbers
  std::vector<ClusterRod> rods;
  Eigen::VectorXd mobility;  // [node] 1/kg; 0: its motion is given
  double w, c;               // s, of a step: theta h, (1 - theta) h
  double theta;
  bool timed = true;  // derivatives by times are wanted
  // [3 node], x y z of each: m, m/s. V of a node whose motion is given: that at the end.
  Eigen::VectorXd p, v, free, P, U;
};

struct ClusterDerivative {
  Eigen::MatrixXd by_state;     // of (P, U) by (p, v, V), [6 node][9 node]
  Eigen::MatrixXd by_mobility;  // by the mobilities, [6 node][node]
  Eigen::MatrixXd by_times;     // by the times of start and end, [6 node][2]; empty: not known
};
// None if the formulas do not give (P, U).
[[nodiscard]] std::optional<ClusterDerivative> output_derivative(const ClusterOverStep& cluster);

}  // namespace springnet::learning
