// Changes by the embedding program between two steps. Contacts and forces are found anew when the next step begins.
#pragma once

#include <cstdint>
#include <optional>

#include "simulation/model.hpp"

namespace springnet {

// m, m/s. A new position releases all contacts of the node, a new velocity those that it separates from.
void set_node(Model& model, std::uint32_t node, const std::optional<Vector3>& position,
              const std::optional<Vector3>& velocity);
void set_fixed(Model& model, std::uint32_t node, bool fixed);
// In a straight line from the present position, to arrive at `time`, s.
void move_surface(Model& model, std::size_t surface, const Vector3& position, double time);
void move_node(Model& model, std::uint32_t node, const Vector3& position, double time);

}  // namespace springnet
