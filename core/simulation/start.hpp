// Start of a simulation: magnitudes for tolerances, and a state that satisfies the constraints.
#pragma once

#include <functional>

#include "simulation/model.hpp"

namespace springnet {

// Throws Error(simulation) where a law cannot be evaluated.
[[nodiscard]] Scales find_scales(Model& model);

// Throws Error(input) for a free node that is misplaced: behind a plane, inside an instrument. is_checked(node,
// surface): those that are looked at.
void check_places(const Model& model, double size, const std::function<bool(std::uint32_t, std::size_t)>& is_checked);
// Makes lengths and velocities satisfy rigid connections; nodes that start on an obstacle with a force into it touch it
// from the start. Throws Error(input) if a node starts inside an obstacle, or lengths cannot be kept. size: of the
// scene, m.
void start_constraints(Model& model, double size);

}  // namespace springnet
