// Contact of bodies with each other and with themselves: what is checked against what, with which friction, and which
// pairs touch at the committed state. Detection is the business of the room proximity; what pairs do in a step that of
// the room simulation (SweepPairs, VerletPairs).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "constraints/contact.hpp"
#include "constraints/vectors.hpp"
#include "layers/numbers_before.hpp"
#include "proximity/near_pairs.hpp"
#include "proximity/neighbour_list.hpp"
#include "proximity/shared_features.hpp"
#include "text/archive.hpp"

namespace springnet {

// Of gaps in steps, in units of the least thickness. Faces on faces have more pairs than determine their places, from
// slightly different times at which these met, and so agree no better.
inline constexpr double gap_tolerance = 1e-4;

// Two primitives in contact: a node and a node or a triangle, or two edges.
struct PairTouch {
  proximity::PairKind kind;
  proximity::Pair pair;
  Vector3 force = Vector3::Zero();  // N, on the first: mean over the last step, or at the time
  Vector3 guess = Vector3::Zero();  // N: of that over the next step
  // While events are located, as of nodes on obstacles: friction holds it, or it slides.
  bool sticks = false;
  bool held = false;  // sticks, though friction is beyond its cone: it began to slip and stuck without end
  Contact::Slip phase = Contact::Slip::ongoing;
  Vector3 slip = Vector3::Zero();   // unit, of the first on the second: the last direction, or where the slip began
  proximity::Features between = 0;  // where it touches; 0: wherever it is closest
  double held_gap = 0.0;            // m: as wide as it stays; not 0 where others at the same place are in the way
  auto key() const noexcept { return std::pair(kind, pair); }
};

class BodyContacts {
 public:
  // Throws Error (input) for a pair without thickness.
  BodyContacts(const Network& network, const std::vector<std::uint32_t>& user_number,
               const std::vector<std::uint32_t>& engine_number);

  [[nodiscard]] bool any() const noexcept { return list_ != nullptr; }
  [[nodiscard]] bool any_rigid() const noexcept { return any_rigid_; }
  [[nodiscard]] std::size_t count() const noexcept { return contacts_.size(); }
  [[nodiscard]] const BodyContact& contact(std::size_t number) const { return contacts_[number]; }
  [[nodiscard]] proximity::NeighbourList& list() noexcept { return *list_; }
  [[nodiscard]] const proximity::Primitives& primitives() const noexcept { return list_->primitives(); }
  // The contact of the scene that a pair is of; one with the greater number where it is of two.
  [[nodiscard]] const BodyContact& law_of(proximity::PairKind kind, proximity::Pair pair) const;

  // Whether two pairs have the same law and thickness.
  [[nodiscard]] bool touch_alike(proximity::PairKind kind, proximity::Pair pair, proximity::PairKind other_kind,
                                 proximity::Pair other) const {
    return &law_of(kind, pair) == &law_of(other_kind, other) &&
           primitives().thickness(kind, pair) == primitives().thickness(other_kind, other);
  }
  // While events are located.
  [[nodiscard]] const proximity::SharedFeatures& shared() const { return *shared_; }
  // Of a pair that touches, between the features at which it does.
  [[nodiscard]] proximity::Separation separation_of(const PairTouch& touch, const proximity::Positions& x) const;
  [[nodiscard]] bool touches(proximity::PairKind kind, proximity::Pair pair) const;

  // Pairs that touch at the committed state, by kind, then in order.
  [[nodiscard]] const std::vector<PairTouch>& touching() const noexcept { return touching_; }
  // Of a pair that is checked, m.
  [[nodiscard]] double least_thickness() const noexcept { return least_thickness_; }
  // "node 3 and the face of nodes 8, 9, 12".
  [[nodiscard]] std::string describe(proximity::PairKind kind, proximity::Pair pair) const;
  void set_touching(std::vector<PairTouch> touching) { touching_ = std::move(touching); }
  [[nodiscard]] std::vector<PairTouch>& touching() noexcept { return touching_; }
  // Whether an integrator locates events: up to the next one the pairs that touch go on touching, and stick or slide as
  // they do. False: steps decide that.
  [[nodiscard]] bool located() const noexcept { return located_; }
  void set_located(bool located);
  void archive(Archive& archive);
  // Of the network before it was extended: pairs that touch go on touching.
  void take_over(const BodyContacts& before, const layers::NumbersBefore& numbers);

 private:
  const std::vector<std::uint32_t>& user_number_;
  std::vector<BodyContact> contacts_;
  std::size_t groups_ = 0;
  std::vector<std::uint32_t> law_of_groups_;        // [group, group] place in contacts_
  double least_thickness_ = 0.0;                    // m
  bool any_rigid_ = false;                          // some of their nodes have rigid connections
  std::unique_ptr<proximity::NeighbourList> list_;  // null: no contacts
  std::vector<PairTouch> touching_;
  bool located_ = false;
  std::unique_ptr<proximity::SharedFeatures> shared_;  // null: not needed yet
};

// Whether some of the nodes in contact have rigid connections.
[[nodiscard]] bool are_any_rigid(const Network& network);
// Throws Error (input) if bodies of this network begin in each other, further than rounding: names the deepest pair.
void check_apart(const Network& network);
// Such pairs, the deepest first.
struct StartingOverlap {
  std::string pair;  // "node 3 and the face of nodes 8, 9, 12"
  double depth;      // m
};
[[nodiscard]] std::vector<StartingOverlap> starting_overlaps(const Network& network, std::size_t most);

// The positions of a state as the room proximity reads them.
[[nodiscard]] inline proximity::Positions positions_of(const springnet_const_vectors& p, std::size_t nodes) {
  return {{p.x, p.y, p.z}, nodes};
}

}  // namespace springnet
