// Nodes [begin, end), or other things that are numbered.
#pragma once

#include <cstddef>

namespace springnet::layers {

struct NodeRange {
  std::size_t begin, end;
};

}  // namespace springnet::layers
