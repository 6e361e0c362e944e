// Mechanisms: motions that nothing resists, to first order.
#pragma once

#include <springnet/inspection.hpp>

#include "inspection/start.hpp"

namespace springnet {

// Fills result.mobility; needs result.parts. part: [node] index into result.parts.
void count_mechanisms(const StartingNetwork& start, const std::vector<std::uint32_t>& part, Inspection& result);

}  // namespace springnet
