// The slowest vibration.
#pragma once

#include <optional>

#include <springnet/inspection.hpp>

#include "inspection/start.hpp"

namespace springnet {

// Of a network whose mobility is known already; empty as Inspection::slowest says.
[[nodiscard]] std::optional<Vibration> slowest_vibration(const StartingNetwork& start, const Mobility& mobility);

}  // namespace springnet
