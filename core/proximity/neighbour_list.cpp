#include "proximity/neighbour_list.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet::proximity {

namespace {

// Of the skin, for the rounding of displacements, and of distances in the search.
constexpr double usable_skin = 1.0 - 1e-6;

}  // namespace

NeighbourList::NeighbourList(Primitives primitives, double skin, const SearchOptions& options)
    : primitives_(std::move(primitives)), skin_(skin), search_(primitives_, options) {
  if (!(skin > 0.0) || !std::isfinite(skin))
    throw Error(ErrorKind::input, fmt::format("the skin of a list of neighbours is {} m; it must be positive", skin));
  for (auto& component : reference_) component.resize(primitives_.nodes().size());
}

bool NeighbourList::covers(const Positions& x, double margin) const {
  if (!is_valid_) return false;
  const std::vector<NodeIndex>& nodes = primitives_.nodes();
  if (nodes.empty()) return true;
  if (nodes.back() >= x.nodes) return false;
  // The box around all displacements: if its diagonal is within the skin, so is what two nodes differ by.
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double squared_diagonal = 0.0;
  std::array<double, 3> middle{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double* const now = x.x[k];
    const double* const then = reference_[k].data();
    double low = infinity, high = -infinity, sum = 0.0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const double moved = now[nodes[i]] - then[i];
      low = std::min(low, moved);
      high = std::max(high, moved);
      sum += moved;
    }
    if (!std::isfinite(sum)) return false;
    squared_diagonal += (high - low) * (high - low);
    middle[k] = 0.5 * (low + high);
  }
  const double most = std::max(0.0, usable_skin * skin_ - margin);
  if (squared_diagonal <= most * most) return true;
  if (squared_diagonal > 3.0 * most * most) return false;  // one side is longer than the skin
  // Else each by itself, within half of the skin about the middle.
  double greatest = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    double squared = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double moved = x.x[k][nodes[i]] - reference_[k][i] - middle[k];
      squared += moved * moved;
    }
    greatest = std::max(greatest, squared);
  }
  return greatest <= 0.25 * most * most;
}

bool NeighbourList::update(const Positions& start, const Positions& end, double bend) {
  // Relative motion along straight lines is a mean of that at the start and at the end.
  const bool moves = start.x[0] != end.x[0] || start.x[1] != end.x[1] || start.x[2] != end.x[2];
  if (covers(start, bend) && (!moves || covers(end, bend))) return false;
  is_valid_ = false;
  ++searches_;
  try {
    search_.find(start, end, skin_, pairs_);
  } catch (...) {
    for (auto& pairs : pairs_.of_kind) pairs.clear();
    throw;
  }
  // A pair that was not found is beyond its thickness and the skin all along, also at the end.
  const std::vector<NodeIndex>& nodes = primitives_.nodes();
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < nodes.size(); ++i) reference_[k][i] = end.x[k][nodes[i]];
  is_valid_ = true;
  return true;
}

}  // namespace springnet::proximity
