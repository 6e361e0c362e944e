// Lists with a value for each of what is listed beside them.
#pragma once

#include <string_view>
#include <vector>

#include <springnet/network.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

// Finite numbers, `count` of them; `what` one of them is for, as "pair".
[[nodiscard]] std::vector<double> numbers_for(const Value& list, std::size_t count, std::string_view what);
// Three nodes, numbered within the body, or in the network if it is null.
[[nodiscard]] Face read_face(const Value& face, const Body* body, const Network& network);
// The keys rest_lengths, masses, velocities, faces and groups of a body of listed nodes, before end_body().
void read_own_lists(const Table& body, Network& network);

}  // namespace springnet::scene
