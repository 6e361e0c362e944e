// Likely mistakes in a scene, most often of units.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/inspection.hpp>

#include "inspection/linearised.hpp"

namespace springnet {

// `found`: all but the hints. part: of each node, as a number into found.parts.
[[nodiscard]] std::vector<Hint> find_hints(const Network& network, const LinearNetwork& linear,
                                           const std::vector<std::uint32_t>& part, const Inspection& found);

}  // namespace springnet
