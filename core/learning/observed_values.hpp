// Access to rows of observations whatever they observe.
#pragma once

#include <cstddef>
#include <cstdint>

#include <springnet/observations.hpp>

namespace springnet::learning {

// Which values of a row are observed, as bits.
inline unsigned observed_values(const Observations::VectorRow& row) {
  return (row.weight[0] > 0.0 ? 1u : 0u) | (row.weight[1] > 0.0 ? 2u : 0u) | (row.weight[2] > 0.0 ? 4u : 0u);
}
inline unsigned observed_values(const Observations::DistanceRow& row) { return row.weight > 0.0 ? 1 : 0; }
inline unsigned observed_values(const Observations::SurfacePoint& row) { return row.weight > 0.0 ? 1 : 0; }

// Calls use(rows, name) for each list.
template <class Use>
void for_each_list(const Observations& observations, const Use& use) {
  use(observations.positions, "positions");
  use(observations.velocities, "velocities");
  use(observations.reactions, "reactions");
  use(observations.distances, "distances");
  use(observations.surface_points, "surface_points");
}

}  // namespace springnet::learning
