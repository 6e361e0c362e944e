// What looks like a slip in a scene.
#pragma once

#include <vector>

#include <springnet/inspection.hpp>

#include "inspection/linearised.hpp"
#include "inspection/orders.hpp"

namespace springnet {

[[nodiscard]] Suspicions find_suspicions(const Network& network, const LinearNetwork& linear, const Joints& joints);

}  // namespace springnet
