// The critical time constant of synchronous propagation, from the network linearised at the committed state.
#pragma once

#include <springnet/sdk/host.hpp>

#include "step.hpp"

namespace springnet::recurrent {

// The w (s) up to which the greatest eigenvalue of w^2 M^-1 K + w M^-1 D is below 1, with M^-1 K = -da/dp and M^-1 D =
// -da/dv at the start of the step: beyond it, synchronous sweeps with w = theta h do not settle. Accurate to about one
// per cent. Infinity if nothing acts on the nodes. Throws Failure where a law has no derivatives.
[[nodiscard]] double critical_weight(const sdk::Host& host, const Step& step);

}  // namespace springnet::recurrent
