// The network's springs, linearised where they are at the start and at rest.
#pragma once

#include <optional>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet {

struct LinearSpring {
  double length;           // m
  double tension;          // N
  double stiffness;        // N/m: dQ/dq of the spring function; nan if unknown
  double axial_damping;    // N s/m: dQ/dq' of laws that read a rate; nan if unknown
  double general_damping;  // N s/m: of laws that read the relative speed; nan if unknown
};

// One entry a spring of the network.
[[nodiscard]] std::vector<LinearSpring> linearise(const Network& network, const PluginHost& plugins);

// The time constant t at which the spectral radius of t^2 M^-1 K + t M^-1 D becomes 1, for nodes that are mass points.
// Empty if a spring is not known, if a free node is no mass point, or if there is no such t.
[[nodiscard]] std::optional<double> synchronous_limit(const Network& network, const std::vector<LinearSpring>& springs);

}  // namespace springnet
