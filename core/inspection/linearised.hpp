// The network's springs, elements and neurons, linearised where they are at the start and at rest.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "inspection/linear_elements.hpp"

namespace springnet {

using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// The force on the first end changes with the relative position dp and velocity dv of both by -K dp - D dv, where
//   K = (T' - T / l) n n^T + (T / l) I,   D = d n n^T + e I.
struct LinearSpring {
  double length;           // m
  Vector3 direction;       // n, from the second end to the first; zero where they coincide, as the engine has it
  double tension;          // T, N
  double stiffness;        // T', N/m: dQ/dq of the spring function; nan if unknown
  double axial_damping;    // d, N s/m: dQ/dq' of laws that read a rate; nan if unknown
  double general_damping;  // e, N s/m: of laws that read the relative speed; nan if unknown

  [[nodiscard]] double across_stiffness() const { return length > 0.0 ? tension / length : 0.0; }  // T / l, N/m
};

// a = by_force F + by_position p + by_velocity v, around the start.
struct LinearNode {
  bool free = false;                  // neither fixed nor moved
  Vector3 force = Vector3::Zero();    // net force of springs, elements, gravity and loads at the start, N
  Block by_force = Block::Zero();     // 1/kg
  Block by_position = Block::Zero();  // 1/s^2
  Block by_velocity = Block::Zero();  // 1/s
};

struct LinearNetwork {
  std::vector<LinearSpring> springs;  // as the network's
  LinearElements elements;            // likewise
  std::vector<LinearNode> nodes;      // likewise
  std::string unknown_because;        // empty unless some law or neuron cannot be linearised
};

// Throws Error(plugin) for a component that is not there, Error(input) for parameters it does not take.
[[nodiscard]] LinearNetwork linearise(const Network& network, const PluginHost& plugins);

}  // namespace springnet
