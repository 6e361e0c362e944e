// Notes for the user on contacts, each counted and written once, and the error that a node has no place left.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "simulation/model.hpp"

namespace springnet {

// A node touches an obstacle so slowly that integration errors decide when, and whether.
void note_grazing_touch(Model& model, std::uint32_t node, std::size_t surface, double time);
// A slip begins or ends so slowly that integration errors decide when, and whether.
void note_grazing_slip(Model& model, std::uint32_t node, std::size_t surface, double time);
// No contact forces were found that satisfy all contacts of a node and what is rigidly connected to it.
void note_unresolved(Model& model, std::uint32_t node, double time);
// Friction of bodies was held before it settled, although a pair slips inside its cone.
void note_held_friction(Model& model, const std::string& pair, double time);
// Sets the message that these obstacles, and bodies in words, leave no place for a node; returns SPRINGNET_RECOVERABLE.
springnet_status no_place(Model& model, std::uint32_t node, const std::vector<std::int32_t>& surfaces, double time,
                          const std::string& bodies = {});

}  // namespace springnet
