// Whether coordinates still tell how far nodes are apart.
#pragma once

#include <springnet/network.hpp>

namespace springnet {

// Throws Error(input) for the first spring, element or rigid connection whose length is lost to the rounding of its
// nodes' coordinates: far from the origin the distance of neighbouring numbers comes near the length.
void check_spacing(const Network& network);

}  // namespace springnet
