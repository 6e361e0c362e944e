// The forces of pairs that touch, for outputs.
#pragma once

#include <vector>

#include "simulation/model.hpp"

namespace springnet {

// [pair that touches] N, on the first, at the committed state. Of redundant pairs steps know only what they do to the
// nodes that can move: of all forces that do the same these are the smallest that press and lie within their cones of
// friction. Those of pairs that slip keep their direction, and count by what they press. Of groups with a rigid body of
// more than 100 nodes in contact they are those of the steps.
[[nodiscard]] std::vector<Vector3> smallest_pair_forces(const Model& model);

}  // namespace springnet
