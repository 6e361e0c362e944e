// What kinetic and potential energy together leave out of a run's balance.
#pragma once

#include <string>
#include <vector>

#include "view/content.hpp"

namespace springnet::view {

// In words that follow "leaves out", those that this run has, best listed with commas. Records are too far apart to add
// up the work of forces between them. Empty: the sum is constant but for the integrator's own error.
[[nodiscard]] std::vector<std::string> left_out_of_energy(const Content& content);

}  // namespace springnet::view
