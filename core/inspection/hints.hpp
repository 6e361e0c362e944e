// Likely input mistakes, most often wrong units.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/inspection.hpp>

#include "inspection/start.hpp"

namespace springnet {

// `found`: complete except for the hints. part: [node] index into found.parts.
[[nodiscard]] std::vector<Hint> find_hints(const StartingNetwork& start, const std::vector<std::uint32_t>& part,
                                           const Inspection& found);

}  // namespace springnet
