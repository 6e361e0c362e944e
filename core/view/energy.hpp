// What the sum of kinetic and potential energy leaves out of a run's balance.
#pragma once

#include <string>
#include <vector>

#include "view/content.hpp"

namespace springnet::view {

// Only what occurs in this run, as noun phrases that follow "leaves out". Records are too far apart to integrate the
// work of forces between them. If empty, the sum is constant except for the integrator's error.
[[nodiscard]] std::vector<std::string> left_out_of_energy(const Content& content);

}  // namespace springnet::view
