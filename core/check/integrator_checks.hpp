// The checks of an integrator. Each runs in a child process of its own.
#pragma once

#include <springnet/plugin_host.hpp>

#include "check/report.hpp"

namespace springnet::check {

// host: of the neuron `point_mass`.

// It makes a step of an oscillator.
[[nodiscard]] Outcome check_integrator_call(const Component& component, const PluginHost& host);
// An oscillator approaches its closed form as steps become smaller; the order, and how the energy changes, are told.
[[nodiscard]] Outcome check_integrator_order(const Component& component, const PluginHost& host);
// Two free masses keep their momentum.
[[nodiscard]] Outcome check_integrator_momentum(const Component& component, const PluginHost& host);
// A load, a cut, a rupture and a jump of a moved node's velocity between the ends of steps.
[[nodiscard]] Outcome check_integrator_events(const Component& component, const PluginHost& host);
// A mass falls onto a plane, stays there, and is pulled off.
[[nodiscard]] Outcome check_integrator_contact(const Component& component, const PluginHost& host);
// Two masses on a rod turn about each other.
[[nodiscard]] Outcome check_integrator_rigid(const Component& component, const PluginHost& host);
// A Maxwell element relaxes.
[[nodiscard]] Outcome check_integrator_states(const Component& component, const PluginHost& host);
// What it cannot do is a status with a reason; states stay finite.
[[nodiscard]] Outcome check_integrator_refusals(const Component& component, const PluginHost& host);
// Each option at each of its bounds.
[[nodiscard]] Outcome check_integrator_options(const Component& component, const PluginHost& host);
// The same bits for every run and number of threads.
[[nodiscard]] Outcome check_integrator_repeats(const Component& component, const PluginHost& host);
// `forget`, `save` and `restore`.
[[nodiscard]] Outcome check_integrator_memory(const Component& component, const PluginHost& host);
// Memory that is not given back.
[[nodiscard]] Outcome check_integrator_leaks(const Component& component, const PluginHost& host);

}  // namespace springnet::check
