// Angles that are exactly straight where a motion starts.
#pragma once

#include <cstdint>
#include <vector>

#include "layers/kernels.hpp"
#include "simulation/engine.hpp"

namespace springnet::learning {

// With x the bending of a straight angle, q = pi - |x|, its law answers Q x / |x|, and where x is 0 the limit along the
// motion, Q x' / |x'|. The derivative of that by x' is what the engine is linearised with, Q_u in each direction
// across, if Q = Q_u q': at rest, or of a viscosity alone that is linear. Else it is another one, and none where the
// angle does not move. Throws Error(input) for the first element of this kind that has one of these nodes (the engine's
// numbers). Of the engine's laws, at this state.
void check_straight_angles(Engine& engine, double time, const layers::NodeArrays& nodes,
                           const std::vector<std::uint32_t>& with_start_velocities);

}  // namespace springnet::learning
