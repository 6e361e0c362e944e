// The checks of a neuron. Each runs in a child process of its own.
#pragma once

#include <springnet/plugin_host.hpp>

#include "check/report.hpp"

namespace springnet::check {

// It answers for one node.
[[nodiscard]] Outcome check_neuron_call(const Component& component, std::uint64_t seed);
// Accelerations are finite.
// No access beyond the arrays, no input changed.
[[nodiscard]] Outcome check_neuron_arrays(const Component& component, std::uint64_t seed);
[[nodiscard]] Outcome check_neuron_finite(const Component& component, std::uint64_t seed);
// By force, position and velocity, by mass, time and parameters, against differences; the acceleration depends on the
// force as F / m.
[[nodiscard]] Outcome check_neuron_derivatives(const Component& component, std::uint64_t seed);
// The same bits for every size of a batch, alignment and instruction set.
[[nodiscard]] Outcome check_neuron_batches(const Component& component, std::uint64_t seed);
// Memory that is not given back.
[[nodiscard]] Outcome check_neuron_leaks(const Component& component, std::uint64_t seed);

}  // namespace springnet::check
