// The checks of a neuron. Each runs in a child process of its own.
#pragma once

#include <springnet/plugin_host.hpp>

#include "check/report.hpp"

namespace springnet::check {

// It answers for one node.
[[nodiscard]] Outcome check_neuron_call(const Component& component, std::uint64_t seed);
// Accelerations are finite.
[[nodiscard]] Outcome check_neuron_finite(const Component& component, std::uint64_t seed);
// By force, position and velocity, by mass, time and parameters, against differences; the acceleration depends on the
// force as F / m.
[[nodiscard]] Outcome check_neuron_derivatives(const Component& component, std::uint64_t seed);

}  // namespace springnet::check
