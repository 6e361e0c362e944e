// Whether coordinates resolve the distances between nodes.
#pragma once

#include <cstddef>

#include <springnet/network.hpp>

namespace springnet {

// Numbers of each that have been checked already and are skipped.
struct Checked {
  std::size_t springs = 0, elements = 0, rigids = 0;
};

// Throws Error(input) for the first spring, element or rigid connection whose length is lost to the rounding of its
// nodes' coordinates: far from the origin the spacing of floating-point numbers approaches the length.
void check_spacing(const Network& network, const Checked& checked = {});

}  // namespace springnet
