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

constexpr double long_step = 0.2;  // of the skin

// The least and the greatest of many numbers, in lanes that a processor compares at once.
class Spread {
 public:
  void include(std::size_t place, double value) {
    const std::size_t lane = place % lanes;
    low_[lane] = value < low_[lane] ? value : low_[lane];
    high_[lane] = value > high_[lane] ? value : high_[lane];
  }
  [[nodiscard]] double width() const { return high() - low(); }
  [[nodiscard]] double middle() const { return 0.5 * (low() + high()); }

 private:
  static constexpr std::size_t lanes = 4;
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  [[nodiscard]] double low() const { return *std::min_element(low_.begin(), low_.end()); }
  [[nodiscard]] double high() const { return *std::max_element(high_.begin(), high_.end()); }

  std::array<double, lanes> low_{infinity, infinity, infinity, infinity};
  std::array<double, lanes> high_{-infinity, -infinity, -infinity, -infinity};
};

// Of the box around displacements: no two differ by more.
double diagonal_of(const std::array<Spread, 3>& spreads) {
  double squared = 0.0;
  for (const Spread& each : spreads) squared += each.width() * each.width();
  return std::sqrt(squared);
}

}  // namespace

NeighbourList::NeighbourList(Primitives primitives, double skin, const SearchOptions& options)
    : primitives_(std::move(primitives)), skin_(skin), search_(primitives_, options) {
  if (!(skin > 0.0) || !std::isfinite(skin))
    throw Error(ErrorKind::input, fmt::format("the skin of a list of neighbours is {} m; it must be positive", skin));
  for (auto& component : reference_) component.resize(primitives_.nodes().size());
  if (!primitives_.nodes().empty())
    for (auto& component : start_) component.resize(primitives_.nodes().back() + std::size_t{1});
}

bool NeighbourList::covers(const Positions& x, double margin) const {
  return is_valid_ && relative_motion(x) <= std::max(0.0, usable_skin * skin_ - margin);
}

double NeighbourList::relative_motion(const Positions& x) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::vector<NodeIndex>& nodes = primitives_.nodes();
  if (nodes.empty()) return 0.0;
  if (nodes.back() >= x.nodes) return infinity;
  std::array<Spread, 3> spreads;
  for (std::size_t k = 0; k < 3; ++k) {
    double sum = 0.0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const double moved = x.x[k][nodes[i]] - reference_[k][i];
      spreads[k].include(i, moved);
      sum += moved;
    }
    if (!std::isfinite(sum)) return infinity;
  }
  const double diagonal = diagonal_of(spreads);
  if (diagonal <= usable_skin * skin_) return diagonal;
  // Else twice what each by itself has moved from the middle.
  const Vector3 middle(spreads[0].middle(), spreads[1].middle(), spreads[2].middle());
  double greatest = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    double squared = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double moved = x.x[k][nodes[i]] - reference_[k][i] - middle[static_cast<Eigen::Index>(k)];
      squared += moved * moved;
    }
    greatest = std::max(greatest, squared);
  }
  return std::min(diagonal, 2.0 * std::sqrt(greatest));
}

bool NeighbourList::update(const Positions& start, const Positions& end, double bend) {
  note_motion(start, end);
  step_ += bend;
  const double most = usable_skin * skin_;
  if (is_valid_ && from_search_ + step_ <= most) return false;
  if (is_valid_) {
    // The sum of all motions may be more than what is left of them. Relative motion along straight lines is a mean of
    // that at the start and at the end.
    from_search_ = relative_motion(start);
    const bool moves = start.x[0] != end.x[0] || start.x[1] != end.x[1] || start.x[2] != end.x[2];
    if (from_search_ + bend <= most && (!moves || relative_motion(end) + bend <= most)) return false;
  }
  is_valid_ = false;
  ++searches_;
  try {
    search_.find(start, end, skin_, pairs_);
  } catch (...) {
    for (auto& pairs : pairs_.of_kind) pairs.clear();
    schedule_.reset(pairs_, skin_);
    throw;
  }
  // A pair that was not found is beyond its thickness and the skin all along, also at the end.
  const std::vector<NodeIndex>& nodes = primitives_.nodes();
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < nodes.size(); ++i) reference_[k][i] = end.x[k][nodes[i]];
  schedule_.reset(pairs_, skin_);
  moved_ = 0.0;
  from_search_ = step_;
  is_valid_ = true;
  return true;
}

void NeighbourList::note_motion(const Positions& start, const Positions& end) {
  const std::vector<NodeIndex>& nodes = primitives_.nodes();
  close_within_ = -std::numeric_limits<double>::infinity();
  step_ = nodes.empty() ? 0.0 : std::numeric_limits<double>::infinity();
  if (nodes.empty() || nodes.back() >= std::min(start.nodes, end.nodes)) return;  // which a search refuses
  std::array<Spread, 3> came, goes;
  double sum = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double* const from = start.x[k];
    const double* const to = end.x[k];
    double* const before = start_[k].data();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const NodeIndex node = nodes[i];
      const double now = from[node], moved = now - before[node], next = to[node] - now;
      before[node] = now;
      came[k].include(i, moved);
      goes[k].include(i, next);
      sum += next;
    }
  }
  if (!std::isfinite(sum)) return;
  const double moved = diagonal_of(came);
  moved_ += moved;
  from_search_ += moved;
  step_ = diagonal_of(goes);
}

const PairLists& NeighbourList::close(double gap) {
  // A long step would look at most pairs here, and then again.
  if (step_ + gap > long_step * skin_) return pairs_;
  if (gap <= close_within_) return close_;
  const Positions start{{start_[0].data(), start_[1].data(), start_[2].data()}, start_[0].size()};
  // Rounding of displacements.
  const double reach = (step_ + gap) * (2.0 - usable_skin) + (1.0 - usable_skin) * skin_;
  schedule_.find_close(primitives_, pairs_, start, moved_, reach, close_);
  moved_ = 0.0;
  close_within_ = gap;
  return close_;
}

}  // namespace springnet::proximity
