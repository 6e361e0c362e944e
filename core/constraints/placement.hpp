// Where everything that moves by itself is at a time: obstacles and prescribed nodes. Functions that depend on the time
// take it as this argument.
#pragma once

#include <vector>

#include "constraints/obstacle.hpp"
#include "constraints/prescribed.hpp"
#include "constraints/sample_time.hpp"

namespace springnet {

struct Placement {
  SampleTime time{};
  std::vector<Pose> poses;      // [obstacle]
  Prescribed::Samples motions;  // of prescribed nodes
};

}  // namespace springnet
