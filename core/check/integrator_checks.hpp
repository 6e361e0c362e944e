// The checks of an integrator. Each runs in a child process of its own.
#pragma once

#include <springnet/plugin_host.hpp>

#include "check/report.hpp"

namespace springnet::check {

// host: of the law `linear` and the neuron `point_mass`.

// It makes a step of an oscillator.
[[nodiscard]] Outcome check_integrator_call(const Component& component, const PluginHost& host);
// An oscillator approaches its closed form as steps become smaller; the order, and how the energy changes, are told.
[[nodiscard]] Outcome check_integrator_order(const Component& component, const PluginHost& host);
// Two free masses keep their momentum.
[[nodiscard]] Outcome check_integrator_momentum(const Component& component, const PluginHost& host);

}  // namespace springnet::check
