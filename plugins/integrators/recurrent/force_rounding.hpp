// Rounding error of the forces: the lower limit of any force tolerance.
//
// Positions are known to eps |p|, and the distance of two nodes to eps (|p1| + |p2|), so that the force on a node is
// known to the stiffness around it times that. The estimate is the change F(p + dp) - F(p) of the linearised net for
// random changes dp of that size, and F(v + dv) - F(v) likewise; it includes springs, elements and enclosed volumes.
// Velocities add m eps |v| / h to the residual of a step of h.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/host.hpp>

#include "step.hpp"

namespace springnet::recurrent {

class ForceRounding {
 public:
  explicit ForceRounding(sdk::Host host) : host_(host) {}

  // Estimates the error at a state; 0 if derivatives are missing or not finite. Replaces the host's last linearisation.
  void estimate(const Step& step, const springnet_state& at);

  void forget() noexcept {
    force_ = 0.0;
    node_ = no_node;
  }
  [[nodiscard]] double force() const noexcept { return force_; }       // N, greatest over the nodes
  [[nodiscard]] std::uint32_t node() const noexcept { return node_; }  // where; no_node: not known

 private:
  // Finds, for each node and its neighbours, the greatest distance from the origin, m, and speed, m/s.
  void find_sizes(const springnet_network& network, const springnet_state& at);

  sdk::Host host_;
  double force_ = 0.0;
  std::uint32_t node_ = no_node;
  std::vector<double> size_, speed_;                 // [node_count]
  std::vector<double> position_, velocity_, image_;  // [3 node_count]
};

}  // namespace springnet::recurrent
