// Progress of loading a scene and setting up its simulation, which take seconds for networks of millions of springs.
#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

namespace springnet {

struct Loading {
  std::string_view stage;  // "reading box.msh"
  double share;            // of the stage, 0 to 1; nan: not known
};

// Called where a stage begins and, where its share is known, some times until it ends, by the thread that loads. Work
// that takes no noticeable time is not told. Exceptions end the loading. Empty: nothing is told.
using LoadingCallback = std::function<void(const Loading&)>;

// Nodes, springs or cells that are worth telling.
inline constexpr std::size_t slow_to_load = 100'000;

}  // namespace springnet
