// A tree of boxes around primitives, which finds the pairs that overlap. Items are halved at the median of their
// centres along the longest side, groups first: depth and memory depend on the number of items alone, wherever they lie
// and however large they are. Where nodes move, boxes are fitted anew into the same tree, which takes linear time; a
// tree whose boxes have come to overlap is built anew.
//
// Branches lie in the order of a walk that visits a branch before its parts. `after` of each says where to go on if its
// box is not overlapped, so that a walk needs no stack. (C. Ericson, Real-Time Collision Detection (2005), section 6.6)
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <springnet/network_lists.hpp>

#include "proximity/primitives.hpp"

namespace springnet::proximity {

struct Box {
  std::array<double, 3> low, high;  // m

  // No branches: the comparisons are unpredictable.
  [[nodiscard]] bool overlaps(const Box& other) const {
    return static_cast<int>(low[0] <= other.high[0]) & static_cast<int>(other.low[0] <= high[0]) &
           static_cast<int>(low[1] <= other.high[1]) & static_cast<int>(other.low[1] <= high[1]) &
           static_cast<int>(low[2] <= other.high[2]) & static_cast<int>(other.low[2] <= high[2]);
  }
  void include(const Box& other);
  void include(const Vector3& point);
  // Sum of the sides, m.
  [[nodiscard]] double size() const { return high[0] - low[0] + high[1] - low[1] + high[2] - low[2]; }
  [[nodiscard]] static Box empty();
};

// How many leaves may be compared and pairs visited in a search, which stops one that takes far more than meshes do.
// Shared by the threads of the search.
class Effort {
 public:
  explicit Effort(std::int64_t most) : left_(most) {}
  // Boxes of a mesh overlap some ten others. A hundred primitives that overlap all others are no reason to stop yet.
  [[nodiscard]] static std::int64_t of_search(const Primitives& primitives) {
    return 10'000'000 + 100 * static_cast<std::int64_t>(primitives.balls().size() + primitives.edges().size() +
                                                        primitives.triangles().size());
  }

  // What one part of the search takes of it, in advance: parts that are the same take the same.
  class Share {
   public:
    explicit Share(Effort& of) : of_(of) {}
    // Throws Error (simulation) if none is left.
    void spend() {
      if (left_-- == 0) take();
    }

   private:
    void take();
    Effort& of_;
    std::int64_t left_ = 0;
  };

 private:
  std::atomic<std::int64_t> left_;
};

class BoxTree {
 public:
  static constexpr std::uint32_t leaf_items = 8;

  // boxes: [items], of finite numbers; groups: [items]. Items are numbered as they lie here.
  void build(std::span<const Box> boxes, std::span<const Group> groups);
  // The same items elsewhere.
  void refit(std::span<const Box> boxes);
  [[nodiscard]] bool is_built_for(std::size_t items) const noexcept { return group_of_.size() == items && items > 0; }
  // Branches are twice as large as when it was built, in the geometric mean, which a few far nodes do not move: their
  // boxes overlap, and it should be built anew.
  [[nodiscard]] bool is_worn() const noexcept {
    return size_ > size_when_built_ + static_cast<std::int64_t>(branches_.size());
  }

  // Calls visit(first, second) for each pair of items of two trees whose boxes overlap and whose groups may be checked:
  // bit g % 32 of partners(group) is set for each partner g of a group. Leaves from `begin` to `end` of `first`, of
  // leaves(): parts may be given to threads.
  template <class Partners, class Visit>
  static void for_overlaps(const BoxTree& first, std::size_t begin, std::size_t end, const BoxTree& second,
                           const Partners& partners, Effort& effort, const Visit& visit);
  // The same within one tree, each pair once, the lower number first.
  template <class Partners, class Visit>
  void for_own_overlaps(std::size_t begin, std::size_t end, const Partners& partners, Effort& effort,
                        const Visit& visit) const;
  [[nodiscard]] std::size_t leaves() const noexcept { return leaves_.size(); }

 private:
  struct Branch {
    Box box;
    std::uint32_t groups;  // bit g % 32 is set for each group g below
    std::uint32_t after;   // the next branch that is not below this one
    std::uint32_t leaf;    // index of a leaf; none otherwise
    [[nodiscard]] bool is_leaf() const noexcept { return leaf != none; }
  };
  static constexpr std::uint32_t none = 0xffffffff;
  // Boxes side by side, so that one is compared with all at once. Places without an item have an empty box.
  struct Leaf {
    double low[3][leaf_items], high[3][leaf_items];  // m
    std::uint32_t item[leaf_items];
    std::uint32_t count, branch;

    [[nodiscard]] Box box(std::size_t i) const {
      return {{low[0][i], low[1][i], low[2][i]}, {high[0][i], high[1][i], high[2][i]}};
    }
    // Bit i is set if box i overlaps `other`.
    [[nodiscard]] std::uint32_t overlapping(const Box& other) const {
      double apart[leaf_items];  // m: the greatest distance along an axis
      for (std::size_t i = 0; i < leaf_items; ++i) {
        const double x = std::max(low[0][i] - other.high[0], other.low[0] - high[0][i]);
        const double y = std::max(low[1][i] - other.high[1], other.low[1] - high[1][i]);
        const double z = std::max(low[2][i] - other.high[2], other.low[2] - high[2][i]);
        apart[i] = std::max(std::max(x, y), z);
      }
      std::uint32_t bits = 0;
      for (std::size_t i = 0; i < leaf_items; ++i) bits |= static_cast<std::uint32_t>(apart[i] <= 0.0) << i;
      return bits;
    }
  };
  struct Slot {
    std::uint32_t item;
    Group group;
  };

  void split(std::uint32_t begin, std::uint32_t end, std::span<const Vector3> centres);
  [[nodiscard]] std::uint32_t middle_of(std::uint32_t begin, std::uint32_t end, std::span<const Vector3> centres);
  template <class Partners>
  [[nodiscard]] std::uint32_t partners_of(const Leaf& leaf, const Partners& partners) const {
    std::uint32_t mask = 0;
    for (std::uint32_t i = 0; i < leaf.count; ++i) mask |= partners(group_of_[leaf.item[i]]);
    return mask;
  }
  // Walks over the branches from `from` on that overlap a leaf's box.
  template <class VisitLeaf>
  void walk(std::size_t from, const Box& box, std::uint32_t mask, const VisitLeaf& visit) const {
    for (std::size_t b = from; b < branches_.size();) {
      const Branch& branch = branches_[b];
      if ((branch.groups & mask) == 0 || !branch.box.overlaps(box)) {
        b = branch.after;
        continue;
      }
      if (branch.is_leaf()) visit(leaves_[branch.leaf]);
      ++b;
    }
  }

  std::vector<Branch> branches_;
  std::vector<Slot> slots_;
  std::vector<Leaf> leaves_;
  std::vector<Group> group_of_;                  // [items]
  std::int64_t size_ = 0, size_when_built_ = 0;  // sums of binary logarithms of the branches' sizes
};

template <class Partners, class Visit>
void BoxTree::for_overlaps(const BoxTree& first, std::size_t begin, std::size_t end, const BoxTree& second,
                           const Partners& partners, Effort& all_effort, const Visit& visit) {
  Effort::Share effort(all_effort);
  for (std::size_t l = begin; l < end; ++l) {
    const Leaf& leaf = first.leaves_[l];
    const Box& around = first.branches_[leaf.branch].box;
    second.walk(0, around, first.partners_of(leaf, partners), [&](const Leaf& other) {
      effort.spend();
      // Of the leaf, those that are near the other one.
      for (std::uint32_t near = leaf.overlapping(second.branches_[other.branch].box); near != 0; near &= near - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(near));
        for (std::uint32_t hit = other.overlapping(leaf.box(i)); hit != 0; hit &= hit - 1) {
          effort.spend();
          visit(leaf.item[i], other.item[std::countr_zero(hit)]);
        }
      }
    });
  }
}

template <class Partners, class Visit>
void BoxTree::for_own_overlaps(std::size_t begin, std::size_t end, const Partners& partners, Effort& all_effort,
                               const Visit& visit) const {
  Effort::Share effort(all_effort);
  const auto visit_in_order = [&](std::uint32_t a, std::uint32_t b) {
    effort.spend();
    if (a < b)
      visit(a, b);
    else
      visit(b, a);
  };
  for (std::size_t l = begin; l < end; ++l) {
    const Leaf& leaf = leaves_[l];
    for (std::uint32_t i = 0; i < leaf.count; ++i)
      for (std::uint32_t hit = leaf.overlapping(leaf.box(i)) >> i >> 1; hit != 0; hit &= hit - 1)
        visit_in_order(leaf.item[i], leaf.item[i + 1 + static_cast<std::uint32_t>(std::countr_zero(hit))]);
    // All leaves that come later.
    walk(std::size_t{leaf.branch} + 1, branches_[leaf.branch].box, partners_of(leaf, partners), [&](const Leaf& other) {
      effort.spend();
      for (std::uint32_t near = leaf.overlapping(branches_[other.branch].box); near != 0; near &= near - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(near));
        for (std::uint32_t hit = other.overlapping(leaf.box(i)); hit != 0; hit &= hit - 1)
          visit_in_order(leaf.item[i], other.item[std::countr_zero(hit)]);
      }
    });
  }
}

}  // namespace springnet::proximity
