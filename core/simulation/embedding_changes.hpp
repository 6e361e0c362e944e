// What an embedding program changes between two steps. Contacts and forces are found anew when the next step begins.
#pragma once

#include <cstdint>
#include <optional>

#include "simulation/model.hpp"

namespace springnet {

// m, m/s. A node with a new position loses its contacts; one with a new velocity those from which it separates.
void set_node(Model& model, std::uint32_t node, const std::optional<Vector3>& position,
              const std::optional<Vector3>& velocity);
void set_fixed(Model& model, std::uint32_t node, bool fixed);
// From where it is now in a straight line, to be there at `time`, s.
void move_surface(Model& model, std::size_t surface, const Vector3& position, double time);
void move_node(Model& model, std::uint32_t node, const Vector3& position, double time);

}  // namespace springnet
