// What elements of a batch have in common: references, parameters and inputs whose stride is 0.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "check/law_call.hpp"

namespace springnet::check {

// How::shared of some: one column in each of them, or all but one, and every second one, from the first or the second.
[[nodiscard]] std::vector<std::uint64_t> mixed_sharings(const LawCall& call);
// Elements that have the shared columns of the first one. Where the reference is shared they keep their stretches.
[[nodiscard]] std::vector<Point> with_shared(const LawCall& call, std::vector<Point> points, std::uint64_t shared);
// "strides of 0 of reference, parameter 'stiffness'"; empty if there are none.
[[nodiscard]] std::string told_sharing(const LawCall& call, std::uint64_t shared);

}  // namespace springnet::check
