// What is asked of nets and integrators whose motion is differentiated.
#pragma once

#include <springnet/network.hpp>

namespace springnet::learning {

// A parameter of the integrator, or what it is if it is not given.
[[nodiscard]] double option(const LawUse& integrator, const char* name, double otherwise);

// Throws Error(input) for what cannot be differentiated.
void check_method(const LawUse& integrator);

// Whether derivatives of accelerations at a time do not depend on the step: loads are averaged over each, and
// derivatives by masses have them; input signals may jump.
[[nodiscard]] bool have_no_jumps(const Network& network);

}  // namespace springnet::learning
