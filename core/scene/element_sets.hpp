// The elements of [[element]] tables by their names.
#pragma once

#include <vector>

#include <springnet/scene.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

// Numbers of the elements of all tables that a list names, ascending, unique. Throws Error(input) for a name that no
// table has.
[[nodiscard]] std::vector<ElementIndex> select_elements(const Value& names, const std::vector<ElementSet>& sets);

}  // namespace springnet::scene
