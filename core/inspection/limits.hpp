// The largest time steps: those that the installed integrators report, and the one up to which a step has a unique
// solution.
#pragma once

#include <springnet/inspection.hpp>

#include "inspection/start.hpp"

namespace springnet {

// Fills limits, unknown_because and unique_time_constant of `result`, for result.options.integrator.
void find_limits(const StartingNetwork& start, const PluginHost& plugins, Inspection& result);

}  // namespace springnet
