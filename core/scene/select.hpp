// Selections of nodes and springs: by body, group, number, box and sphere; what is selected meets all that is given.
#pragma once

#include <vector>

#include <springnet/network.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

// User's numbers, rising, each once. Boxes and spheres see the nodes where the scene puts them, before any motion.
// Throw Error(input) if nothing is selected.
[[nodiscard]] std::vector<NodeIndex> select_nodes(const Value& selection, const Network& network);
// Both ends of a spring have to meet what is given.
[[nodiscard]] std::vector<SpringIndex> select_springs(const Value& selection, const Network& network);

// Adds to what all tables of a kind have selected, where each selection is kept. Throws Error(input) for more than a
// hundred million.
void count_selected(const Value& selection, std::size_t count, std::size_t& total);

// A group that a selection names: of that body, which has that many before it.
struct SelectedGroup {
  std::size_t body;
  std::size_t group;
};
// Those of all bodies that it may be from; none if the selection names no group.
[[nodiscard]] std::vector<SelectedGroup> select_groups(const Value& selection, const Network& network);

// Names for a message: "left, right, skin", the first of them if they are many.
[[nodiscard]] std::string list_of(const std::vector<std::string>& names);

// The body of this name.
[[nodiscard]] const Body& find_body(const Value& name, const Network& network);
// A node's number: within the body, or of the whole network if there is none.
[[nodiscard]] NodeIndex read_node(const Value& number, const Body* body, const Network& network);

}  // namespace springnet::scene
