// What is asked of nets and integrators whose motion is differentiated.
#pragma once

#include <springnet/network.hpp>

namespace springnet::learning {

// A parameter of the integrator, or what it is if it is not given.
[[nodiscard]] double option(const LawUse& integrator, const char* name, double otherwise);

// Throws Error(input) for what cannot be differentiated.
void check_method(const LawUse& integrator);
void check_net(const Network& network);

}  // namespace springnet::learning
