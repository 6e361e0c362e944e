// The state of all prescribed motion at a time: poses of obstacles, motions of nodes. Functions that depend on time
// take it as an argument.
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
