// The elements in memory: their nodes, the elements of each node, and batches for the evaluation of laws.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "layers/elements/enclosure.hpp"
#include "layers/elements/invariant.hpp"
#include "layers/elements/kernels.hpp"
#include "layers/laws.hpp"

namespace springnet::layers {

// An element seen from one of its nodes.
struct ElementShare {
  std::uint32_t element;
  std::uint32_t place;      // which of the element's nodes this is
  std::uint32_t group;      // of laws
  std::uint32_t enclosure;  // index into enclosures(); no_enclosure for an element of three or four nodes
};
inline constexpr std::uint32_t no_enclosure = 0xffffffffu;

// What the scalars of an element are at rest, and its direction.
struct SeveralRest {
  double value = 0.0;                           // of the element as a whole: Element::reference
  std::array<double, max_scalars> reference{};  // [scalar of the group's list]
  std::array<double, 3> direction{};            // components in the edges from the first corner
};

// Live elements of three or four nodes with the same invariant and laws: batched()[begin, begin + count).
struct ElementBatch {
  Invariant invariant;
  std::uint32_t group;
  std::uint32_t begin, count;
  bool one_row = false;  // of all its elements
};

class ElementLayout {
 public:
  // engine: [user's node]
  ElementLayout(const Network& network, const CompiledLaws& laws, const std::vector<std::uint32_t>& engine);

  [[nodiscard]] std::size_t count() const noexcept { return alive_.size(); }
  [[nodiscard]] std::size_t live_count() const noexcept { return live_count_; }
  [[nodiscard]] bool alive(std::uint32_t element) const noexcept { return alive_[element] != 0; }
  [[nodiscard]] Invariant invariant(std::uint32_t element) const noexcept { return invariant_[element]; }
  [[nodiscard]] std::uint32_t group(std::uint32_t element) const noexcept { return laws_->element_group[element]; }
  [[nodiscard]] std::uint32_t row(std::uint32_t element) const noexcept { return laws_->element_row[element]; }
  [[nodiscard]] double reference(std::uint32_t element) const noexcept {
    if (reads_several(invariant_[element])) return rest(element).value;
    return laws_->groups[group(element)].columns[0][row(element)];
  }
  // Nodes of an element as the engine numbers them, each once: its corners, or those of its enclosure by place.
  [[nodiscard]] std::span<const std::uint32_t> nodes(std::uint32_t element) const noexcept {
    return {nodes_.data() + start_[element], nodes_.data() + start_[element + 1]};
  }
  // Index of an element's first node in arrays over the nodes of all elements.
  [[nodiscard]] std::size_t slot(std::uint32_t element) const noexcept { return start_[element]; }
  [[nodiscard]] std::size_t slot_count() const noexcept { return nodes_.size(); }

  // Live elements of a node: those of three or four nodes sorted by laws, then enclosures.
  [[nodiscard]] std::span<const ElementShare> shares(std::uint32_t node) const noexcept {
    if (live_count_ == 0) return {};
    return {shares_.data() + share_start_[node], shares_.data() + share_stop_[node]};
  }
  [[nodiscard]] const std::vector<ElementBatch>& batches() const noexcept { return batches_.get(); }
  [[nodiscard]] const std::vector<std::uint32_t>& batched() const noexcept { return batched_.get(); }
  // Corners and references of a batch, and the rows of its elements.
  [[nodiscard]] BatchCorners corners(const ElementBatch& batch) const noexcept {
    const auto at = [&batch](const SharedVector<std::uint32_t>& nodes) { return nodes.data() + batch.begin; };
    return {
        {at(corner_[0]), at(corner_[1]), at(corner_[2]), at(corner_[3])}, reference_.data() + batch.begin, batch.count};
  }
  [[nodiscard]] const std::uint32_t* rows(const ElementBatch& batch) const noexcept {
    return row_.data() + batch.begin;
  }
  // [member] of a batch, in the internal state; null: no law has any.
  [[nodiscard]] const std::uint32_t* places(const ElementBatch& batch) const noexcept {
    return place_.empty() ? nullptr : place_.data() + batch.begin;
  }
  // `internal` must stay.
  void take_places(const InternalLayout& internal) {
    internal_ = &internal;
    fill_places();
  }
  // To be called for a copy: with copies of what it reads, which must stay.
  void read(const CompiledLaws& laws, const InternalLayout& internal) noexcept {
    laws_ = &laws;
    if (internal_ != nullptr) internal_ = &internal;
  }
  // Of elements whose laws read several scalars; also of removed ones.
  [[nodiscard]] const SeveralRest& rest(std::uint32_t element) const noexcept {
    return rest_[element - first_several_[element]];
  }
  // [scalar], [component]: arrays over the members of such a batch.
  void several_arrays(const ElementBatch& batch, const double* (&references)[max_scalars],
                      const double* (&direction)[3]) const noexcept {
    const std::size_t at = batch.begin - first_several_batched_;
    for (std::size_t s = 0; s < max_scalars; ++s) references[s] = several_reference_[s].data() + at;
    for (std::size_t c = 0; c < 3; ++c) direction[c] = several_direction_[c].data() + at;
  }
  // [share of the node] where the force of an element of three or four nodes on the node is in arrays over the corners
  // of batched(): place * batched().size() + index in batched(). As many as shares(node) that are no enclosures.
  [[nodiscard]] std::span<const std::uint32_t> force_slots(std::uint32_t node) const noexcept {
    return {force_slots_.data() + share_start_[node], force_slots_.data() + slot_stop_[node]};
  }

  struct EnclosureElement {
    std::uint32_t element;
    Enclosure shape;
  };
  // By element, removed ones included.
  [[nodiscard]] const std::vector<EnclosureElement>& enclosures() const noexcept { return enclosures_.get(); }
  [[nodiscard]] std::size_t live_enclosures() const noexcept { return live_enclosures_; }

  // Appends the nodes that share an element with a node; of an enclosure only those that share a triangle with it.
  void add_neighbours(std::uint32_t node, std::vector<std::uint32_t>& neighbours) const;
  // Live elements with a side between the ends of one of these springs; for an enclosure, a side of a triangle. By
  // number, each once.
  [[nodiscard]] std::vector<std::uint32_t> broken_by(
      const std::vector<std::pair<std::uint32_t, std::uint32_t>>& springs) const;
  // Live elements with a side (for an enclosure: of a triangle) for which crosses(node, node) is true.
  template <class Crosses>
  [[nodiscard]] std::vector<std::uint32_t> crossed_by(const Crosses& crosses) const;

  // Elements removed before are ignored; returns the others.
  std::vector<std::uint32_t> remove(const std::vector<std::uint32_t>& elements);
  void put_back_all();
  // To be called after the row of an element, or a value in it, has become another one; after its group has.
  void row_changed(std::uint32_t element);
  void groups_changed();

 private:
  void share_out();
  void drop_dead_shares(std::size_t begin_node, std::size_t end_node);
  void make_batches();
  void fill_batches();
  void fill_places();
  // Whether the line between corners i < j is a side: not between the tips of a hinge, nor between the ends of an
  // angle.
  [[nodiscard]] bool is_side(std::uint32_t element, std::size_t i, std::size_t j) const noexcept {
    switch (invariant_[element]) {
      case Invariant::dihedral:
      case Invariant::hinge:
        return i != 2 || j != 3;
      case Invariant::angle:
      case Invariant::chain:
        return i != 0 || j != 2;
      default:
        return true;
    }
  }

  const CompiledLaws* laws_;
  SharedVector<Invariant> invariant_;
  SharedVector<std::uint32_t> first_several_;  // [element] its number less its index in rest_; empty: there are none
  SharedVector<SeveralRest> rest_;
  std::size_t first_several_batched_ = 0;                                       // they come last in batched()
  SharedVector<double> several_reference_[max_scalars], several_direction_[3];  // [batched, from there on]
  SharedVector<std::uint8_t> alive_;
  std::size_t live_count_ = 0, live_enclosures_ = 0;
  SharedVector<std::size_t> start_;
  SharedVector<std::uint32_t> nodes_;
  SharedVector<EnclosureElement> enclosures_;
  SharedVector<std::size_t> share_start_, share_stop_;  // [node]; empty without elements
  SharedVector<ElementShare> shares_;
  SharedVector<ElementBatch> batches_;
  SharedVector<std::uint32_t> batched_;
  // [batched]
  SharedVector<std::uint32_t> corner_[max_corners], row_;
  SharedVector<std::uint32_t> place_in_batched_;  // [element], of live ones that are there
  SharedVector<double> reference_;
  const InternalLayout* internal_ = nullptr;  // null: no law has internal state
  SharedVector<std::uint32_t> place_;
  SharedVector<std::uint32_t> force_slots_;  // [share]
  SharedVector<std::size_t> slot_stop_;      // [node]
};

template <class Crosses>
std::vector<std::uint32_t> ElementLayout::crossed_by(const Crosses& crosses) const {
  std::vector<std::uint32_t> found;
  std::size_t next_enclosure = 0;
  for (std::uint32_t e = 0; e < count(); ++e) {
    bool is_crossed = false;
    if (invariant_[e] == Invariant::enclosed_volume) {
      const Enclosure& enclosure = enclosures_[next_enclosure++].shape;
      for (std::size_t place = 0; place < enclosure.size() && alive(e) && !is_crossed; ++place)
        for (const Enclosure::Spoke& spoke : enclosure.spokes(place))
          is_crossed =
              is_crossed || (enclosure.nodes()[place] < spoke.other && crosses(enclosure.nodes()[place], spoke.other));
    } else {
      const std::span<const std::uint32_t> corners = nodes(e);
      for (std::size_t i = 0; i < corners.size() && alive(e); ++i)
        for (std::size_t j = 0; j < i; ++j) {
          is_crossed = is_crossed || (is_side(e, j, i) && crosses(corners[j], corners[i]));
        }
    }
    if (is_crossed) found.push_back(e);
  }
  return found;
}

}  // namespace springnet::layers
