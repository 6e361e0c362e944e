// Loops of integrators in the host's threads.
#pragma once

#include <springnet/sdk/plugin.h>

#include "simulation/model.hpp"

namespace springnet {

// See springnet_host::parallel_for.
springnet_status run_loop(Model& model, const springnet_loop& loop);

}  // namespace springnet
