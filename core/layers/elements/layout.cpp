#include "layers/elements/layout.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <tuple>
#include <utility>

#include "network/invariant_values.hpp"

namespace springnet::layers {
namespace {

// The scalars of a list at the rest configuration of an element: by the same operations as the kernels', so that an
// element there reads its references to the bit.
SeveralRest rest_of(const ScalarList& list, const Element& element) {
  SeveralRest rest;
  rest.value = element.reference;
  const auto at = [&](std::uint8_t corner) -> invariants::Point {
    const Vector3 p = element.rest[corner] - element.rest[0];
    return {p[0], p[1], p[2]};
  };
  for (std::size_t s = 0; s < list.count; ++s) {
    const auto& c = list.scalar[s].corner;
    switch (list.scalar[s].measure) {
      case Measure::length:
        rest.reference[s] = invariants::length(at(c[0]), at(c[1]));
        break;
      case Measure::angle:
        rest.reference[s] = invariants::angle(at(c[0]), at(c[1]), at(c[2]));
        break;
      case Measure::dihedral:
        rest.reference[s] = invariants::dihedral(at(c[0]), at(c[1]), at(c[2]), at(c[3]));
        break;
      case Measure::area:
        rest.reference[s] = invariants::area(at(c[0]), at(c[1]), at(c[2]));
        break;
      case Measure::volume:
        rest.reference[s] = invariants::volume(at(c[0]), at(c[1]), at(c[2]), at(c[3]));
        break;
    }
  }
  if (element.direction == Vector3::Zero()) return rest;
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> edges(3, static_cast<Eigen::Index>(list.corners - 1));
  for (std::size_t k = 1; k < list.corners; ++k)
    edges.col(static_cast<Eigen::Index>(k - 1)) = element.rest[k] - element.rest[0];
  const Eigen::VectorXd components = edges.colPivHouseholderQr().solve(element.direction);
  for (std::size_t k = 0; k + 1 < list.corners; ++k) rest.direction[k] = components[static_cast<Eigen::Index>(k)];
  return rest;
}

}  // namespace

ElementLayout::ElementLayout(const Network& network, const CompiledLaws& laws, const std::vector<std::uint32_t>& engine)
    : laws_(&laws), start_({0}) {
  const std::vector<Element>& elements = network.elements();
  if (elements.empty()) return;
  alive_.assign(elements.size(), 1);
  live_count_ = elements.size();
  for (std::uint32_t e = 0; e < elements.size(); ++e) {
    std::vector<std::uint32_t> nodes;
    for (const NodeIndex node : elements[e].nodes) nodes.push_back(engine[node]);
    invariant_.push_back(elements[e].invariant);
    if (elements[e].invariant == Invariant::enclosed_volume) {
      enclosures_.push_back({e, Enclosure(nodes)});
      nodes = enclosures_.back().shape.nodes();
    }
    std::vector<std::uint32_t>& all = nodes_.own();
    all.insert(all.end(), nodes.begin(), nodes.end());
    start_.push_back(nodes_.size());
    if (reads_several(elements[e].invariant)) {
      first_several_.own().resize(elements.size());
      first_several_.own()[e] = e - static_cast<std::uint32_t>(rest_.size());
      rest_.push_back(rest_of(laws.groups[group(e)].scalars, elements[e]));
    }
  }
  live_enclosures_ = enclosures_.size();

  std::vector<std::size_t> start(engine.size() + 1, 0);
  for (const std::uint32_t node : nodes_) ++start[node + 1];
  for (std::size_t k = 0; k < engine.size(); ++k) start[k + 1] += start[k];
  share_start_ = std::move(start);
  share_out();
  make_batches();
}

void ElementLayout::share_out() {
  const std::size_t nodes = share_start_.size() - 1;
  std::vector<ElementShare> shares(nodes_.size());
  std::vector<std::size_t> stop(share_start_.begin(), share_start_.end() - 1);
  std::uint32_t next_enclosure = 0;
  for (std::uint32_t e = 0; e < count(); ++e) {
    const std::uint32_t enclosure = invariant_[e] == Invariant::enclosed_volume ? next_enclosure++ : no_enclosure;
    const std::span<const std::uint32_t> own = this->nodes(e);
    for (std::uint32_t i = 0; i < own.size(); ++i) shares[stop[own[i]]++] = {e, i, group(e), enclosure};
  }
  for (std::size_t k = 0; k < nodes; ++k) {
    const auto order = [this](const ElementShare& s) {
      return std::tuple(s.enclosure != no_enclosure, s.group, invariant_[s.element], s.element);
    };
    std::sort(shares.data() + share_start_[k], shares.data() + stop[k],
              [&](const ElementShare& a, const ElementShare& b) { return order(a) < order(b); });
  }
  shares_ = std::move(shares);
  share_stop_ = std::move(stop);
}

void ElementLayout::put_back_all() {
  if (live_count_ == alive_.size()) return;
  alive_.assign(alive_.size(), 1);
  live_count_ = alive_.size();
  live_enclosures_ = enclosures_.size();
  share_out();
  make_batches();
}

void ElementLayout::row_changed(std::uint32_t element) {
  if (!alive(element) || invariant_[element] == Invariant::enclosed_volume) return;
  const std::uint32_t place = place_in_batched_[element];
  row_.own()[place] = row(element);
  reference_.own()[place] = reference(element);
  const auto behind = std::upper_bound(batches_.begin(), batches_.end(), place,
                                       [](std::uint32_t at, const ElementBatch& batch) { return at < batch.begin; });
  const auto number = static_cast<std::size_t>(behind - batches_.begin()) - 1;  // before own() moves them
  ElementBatch& batch = batches_.own()[number];
  batch.one_row = std::all_of(row_.begin() + batch.begin, row_.begin() + batch.begin + batch.count,
                              [&](std::uint32_t other) { return other == row_[batch.begin]; });
}

void ElementLayout::groups_changed() {
  if (count() == 0) return;
  share_out();
  drop_dead_shares(0, share_stop_.size());
  make_batches();
}

void ElementLayout::drop_dead_shares(std::size_t begin_node, std::size_t end_node) {
  std::vector<ElementShare>& all = shares_.own();
  std::vector<std::size_t>& stop = share_stop_.own();
  for (std::size_t node = begin_node; node < end_node; ++node) {
    ElementShare* begin = all.data() + share_start_[node];
    ElementShare* end = all.data() + stop[node];
    const ElementShare* kept = std::remove_if(begin, end, [this](const ElementShare& s) { return !alive(s.element); });
    stop[node] = static_cast<std::size_t>(kept - all.data());
  }
}

// Sorted by invariant and laws, then by lowest node, so that successive elements read the same nodes.
void ElementLayout::make_batches() {
  std::vector<std::uint32_t> batched;
  for (std::uint32_t e = 0; e < count(); ++e)
    if (alive(e) && invariant_[e] != Invariant::enclosed_volume) batched.push_back(e);
  const auto lowest = [this](std::uint32_t e) {
    const std::span<const std::uint32_t> own = nodes(e);
    return *std::min_element(own.begin(), own.end());
  };
  std::sort(batched.begin(), batched.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(invariant_[a], group(a), lowest(a), a) < std::tuple(invariant_[b], group(b), lowest(b), b);
  });
  batched_ = std::move(batched);
  std::vector<ElementBatch> batches;
  for (std::uint32_t begin = 0; begin < batched_.size();) {
    const std::uint32_t e = batched_[begin];
    std::uint32_t end = begin + 1;
    const std::size_t most = reads_several(invariant_[e]) ? several_batch : element_batch;
    while (end < batched_.size() && end - begin < most && invariant_[batched_[end]] == invariant_[e] &&
           group(batched_[end]) == group(e))
      ++end;
    const bool one_row = std::all_of(batched_.begin() + begin, batched_.begin() + end,
                                     [&](std::uint32_t other) { return row(other) == row(e); });
    batches.push_back({invariant_[e], group(e), begin, end - begin, one_row});
    begin = end;
  }
  batches_ = std::move(batches);
  fill_batches();
}

void ElementLayout::fill_batches() {
  std::vector<std::uint32_t> rows, corners[max_corners];
  std::vector<double> references;
  std::vector<std::uint32_t> index(count());
  for (std::uint32_t i = 0; i < batched_.size(); ++i) {
    const std::uint32_t e = batched_[i];
    const std::span<const std::uint32_t> own = nodes(e);
    index[e] = i;
    rows.push_back(row(e));
    references.push_back(reference(e));
    for (std::size_t c = 0; c < max_corners; ++c) corners[c].push_back(own[std::min(c, own.size() - 1)]);
  }
  row_ = std::move(rows);
  reference_ = std::move(references);
  for (std::size_t c = 0; c < max_corners; ++c) corner_[c] = std::move(corners[c]);
  for (SharedVector<double>& values : several_reference_) values.clear();
  for (SharedVector<double>& values : several_direction_) values.clear();
  first_several_batched_ = batched_.size();
  for (std::size_t i = 0; i < batched_.size(); ++i) {
    if (!reads_several(invariant_[batched_[i]])) continue;
    first_several_batched_ = std::min(first_several_batched_, i);
    const SeveralRest& own = rest(batched_[i]);
    for (std::size_t k = 0; k < max_scalars; ++k) several_reference_[k].push_back(own.reference[k]);
    for (std::size_t c = 0; c < 3; ++c) several_direction_[c].push_back(own.direction[c]);
  }
  const auto pitch = static_cast<std::uint32_t>(batched_.size());
  std::vector<std::uint32_t> slots(shares_.size());
  std::vector<std::size_t> stop = share_stop_.get();
  for (std::size_t k = 0; k < stop.size(); ++k) {
    std::size_t at = share_start_[k];
    for (; at < share_stop_[k] && shares_[at].enclosure == no_enclosure; ++at)
      slots[at] = shares_[at].place * pitch + index[shares_[at].element];
    stop[k] = at;
  }
  force_slots_ = std::move(slots);
  slot_stop_ = std::move(stop);
  place_in_batched_ = std::move(index);
  if (internal_ != nullptr) fill_places();
}

void ElementLayout::fill_places() {
  std::vector<std::uint32_t> places(batched_.size(), 0);
  for (std::size_t i = 0; i < batched_.size(); ++i)
    if (internal_->has(group(batched_[i]))) places[i] = internal_->of_element(batched_[i]);
  place_ = std::move(places);
}

void ElementLayout::add_neighbours(std::uint32_t node, std::vector<std::uint32_t>& neighbours) const {
  for (const ElementShare& share : shares(node)) {
    if (share.enclosure != no_enclosure) {
      for (const Enclosure::Spoke& spoke : enclosures_[share.enclosure].shape.spokes(share.place))
        neighbours.push_back(spoke.other);
      continue;
    }
    for (const std::uint32_t other : nodes(share.element))
      if (other != node) neighbours.push_back(other);
  }
}

std::vector<std::uint32_t> ElementLayout::broken_by(
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& springs) const {
  std::vector<std::uint32_t> found;
  for (const auto& [first, second] : springs) {
    for (const ElementShare& share : shares(first)) {
      const std::span<const std::uint32_t> own = nodes(share.element);
      if (share.enclosure != no_enclosure) {
        if (enclosures_[share.enclosure].shape.has_side(first, second)) found.push_back(share.element);
        continue;
      }
      const auto a = static_cast<std::size_t>(std::find(own.begin(), own.end(), first) - own.begin());
      const auto b = static_cast<std::size_t>(std::find(own.begin(), own.end(), second) - own.begin());
      if (b < own.size() && is_side(share.element, std::min(a, b), std::max(a, b))) found.push_back(share.element);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<std::uint32_t> ElementLayout::remove(const std::vector<std::uint32_t>& elements) {
  std::vector<std::uint32_t> removed;
  for (const std::uint32_t e : elements) {
    if (!alive(e)) continue;
    alive_.own()[e] = 0;
    removed.push_back(e);
    if (invariant_[e] == Invariant::enclosed_volume) --live_enclosures_;
  }
  if (removed.empty()) return removed;
  live_count_ -= removed.size();
  for (const std::uint32_t e : removed) {
    for (const std::uint32_t node : nodes(e)) drop_dead_shares(node, std::size_t{node} + 1);
  }
  make_batches();
  return removed;
}

}  // namespace springnet::layers
