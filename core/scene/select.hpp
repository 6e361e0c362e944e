// Selections of nodes and springs by body, group, number, box and sphere; all given criteria must be met.
#pragma once

#include <vector>

#include <springnet/network.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

// User's numbers, ascending, unique. Boxes and spheres refer to positions in the scene, before any motion. Throw
// Error(input) if nothing is selected.
[[nodiscard]] std::vector<NodeIndex> select_nodes(const Value& selection, const Network& network);
// Springs with both ends in the selection.
[[nodiscard]] std::vector<SpringIndex> select_springs(const Value& selection, const Network& network);

// Adds `count` to the `total` selected by tables whose selections are stored. Throws Error(input) above a hundred
// million.
void count_selected(const Value& selection, std::size_t count, std::size_t& total);

// A group that a selection names: indices of the body and of the group within it.
struct SelectedGroup {
  std::size_t body;
  std::size_t group;
};
// The groups of all bodies that the selection covers; empty if it names no group.
[[nodiscard]] std::vector<SelectedGroup> select_groups(const Value& selection, const Network& network);

// Names for a message: "left, right, skin"; only the first few of many.
[[nodiscard]] std::string list_of(const std::vector<std::string>& names);

// The body of this name.
[[nodiscard]] const Body& find_body(const Value& name, const Network& network);
// A node's number: within the body, or of the whole network if there is none.
[[nodiscard]] NodeIndex read_node(const Value& number, const Body* body, const Network& network);

}  // namespace springnet::scene
