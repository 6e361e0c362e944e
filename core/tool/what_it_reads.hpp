// What a law reads of its element's nodes, in words.
#pragma once

#include <string>

#include <springnet/sdk/plugin.h>

namespace springnet::tool {

// "the distance of two nodes, m"; "of a tetrahedron of nodes 0 to 3: lengths 01 02 03 12 13 23, volume 0123".
[[nodiscard]] std::string what_it_reads(const springnet_law& law);

}  // namespace springnet::tool
