// The table of host functions that an integrator plugin works with.
#pragma once

#include <springnet/sdk/plugin.h>

#include "simulation/engine.hpp"

namespace springnet {

// `engine` has to outlive the table. No exception leaves its functions: they become statuses and messages.
[[nodiscard]] springnet_host make_host_table(Engine& engine);
// Adds those that came with ABI 2.1.
void add_functions_2_1(springnet_host& host);

}  // namespace springnet
