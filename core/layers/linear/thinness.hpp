// Whether a net is a line or a surface rather than a solid, which decides how its linear systems are best
// preconditioned.
#pragma once

#include "layers/layout.hpp"

namespace springnet::layers {

// Whether most of the net is closer to a line or surface than to a solid: the distance in springs between the ends of a
// part is about the square root of the number of its nodes, or more. Small nets count as thin.
[[nodiscard]] bool is_thin(const Layout& layout);

}  // namespace springnet::layers
