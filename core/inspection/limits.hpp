// The largest time constants.
#pragma once

#include <optional>

#include <springnet/inspection.hpp>

#include "inspection/linearised.hpp"
#include "inspection/orders.hpp"

namespace springnet {

// Fills limits, unknown_because and unique_time_constant of `result`, for result.options.theta.
void find_limits(const Network& network, const LinearNetwork& linear, const Joints& joints, Inspection& result);

}  // namespace springnet
