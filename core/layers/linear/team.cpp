#include "layers/linear/team.hpp"

namespace springnet::layers {

void Team::barrier() const {
  if (count_ > 1) {
#pragma omp barrier
  }
}

}  // namespace springnet::layers
