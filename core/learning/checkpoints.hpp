// Where a run that goes backwards keeps what it can go on from: the binomial plan (A. Griewank, A. Walther, Algorithm
// 799: revolve, ACM Trans. Math. Softw. 26, 2000). With s places for states, the first of the run among them, and
// binomial(s + r, r) parts, each part is made at most r times, and no plan makes fewer.
#pragma once

#include <cstddef>

namespace springnet::learning {

// Of `parts` that are gone through backwards, with `places` >= 1 of which one has the start of the first part: how many
// parts on the next one is kept. parts >= 2, places >= 2.
[[nodiscard]] std::size_t parts_until_kept(std::size_t parts, std::size_t places) noexcept;

// How many parts are passed in all, forwards, to be where each of them begins, from the last one to the first.
[[nodiscard]] std::size_t parts_passed(std::size_t parts, std::size_t places) noexcept;

}  // namespace springnet::learning
