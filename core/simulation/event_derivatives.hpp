// Derivatives of event functions that depend on no force: gaps, and margins of rupture.
#pragma once

#include "simulation/contact_events.hpp"
#include "simulation/model.hpp"
#include "simulation/topology.hpp"

namespace springnet {

// See springnet_event_derivative. Throws Error(plugin) for an event of another kind, and for a law that does not give
// the derivatives of its margin. by_internal: += derivatives by the internal states of laws; null: not wanted.
springnet_status find_event_derivative(Model& model, ContactEvents& events, Topology& topology,
                                       springnet_event_derivative& request, double* by_internal = nullptr);

}  // namespace springnet
