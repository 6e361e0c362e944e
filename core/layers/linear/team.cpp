#include "layers/linear/team.hpp"

namespace springnet::layers {

void Team::wait() {
#pragma omp barrier
}

}  // namespace springnet::layers
