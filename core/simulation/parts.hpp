// What springs and elements contribute at a state, for integrators that split forces or solve element by element:
// forces of chosen parts, values and derivatives of each spring or element, energy and momentum.
#pragma once

#include <springnet/sdk/plugin.h>

#include "simulation/model.hpp"

namespace springnet {

// See springnet_host::part_forces, view_elements, view_scalars and balance. Statuses and messages as there;
// Error(plugin) for ranges and arrays that do not fit. By the calling thread alone.
springnet_status part_forces(Model& model, const springnet_part_forces& request);
springnet_status view_elements(Model& model, springnet_element_view& request);
springnet_status view_scalars(Model& model, springnet_scalar_view& request);
springnet_status balance(Model& model, springnet_balance& request);

}  // namespace springnet
