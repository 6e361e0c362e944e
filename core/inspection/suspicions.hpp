// Likely input mistakes in single springs and nodes.
#pragma once

#include <springnet/inspection.hpp>

#include "inspection/start.hpp"

namespace springnet {

[[nodiscard]] Suspicions find_suspicions(const StartingNetwork& start);

}  // namespace springnet
