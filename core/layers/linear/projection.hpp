// Projections onto what constraint rows G allow, with mobilities W of the nodes, in place; [node][3].
#pragma once

#include <functional>

namespace springnet::layers {

struct Projection {
  // A change of velocities, m/s: Q z = z - W G^T (G W G^T)^-1 G z.
  std::function<void(double* values)> change;
  // Impulses, N s: Q^T r.
  std::function<void(double* values)> impulse;
  // Takes out of forces, N, what reactions balance, with the friction that these cause; null: there is no friction, and
  // Q^T does. The system then is not symmetric.
  std::function<void(double* values)> reactions;
};

}  // namespace springnet::layers
