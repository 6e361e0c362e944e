// Start of a simulation: magnitudes for tolerances, and a state that satisfies the constraints.
#pragma once

#include "simulation/model.hpp"

namespace springnet {

// Throws Error(simulation) where a law cannot be evaluated.
[[nodiscard]] Scales find_scales(Model& model);

// Makes lengths and velocities satisfy rigid connections; nodes that start on an obstacle with a force into it touch it
// from the start. Throws Error(input) if a node starts inside an obstacle, or lengths cannot be kept. size: of the
// scene, m.
void start_constraints(Model& model, double size);

}  // namespace springnet
