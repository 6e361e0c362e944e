// The search for all pairs of primitives that are near each other, or may come near each other within a step: boxes
// around the primitives by trees, then distances. Time and memory are linear in the primitives and the pairs that are
// found.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "proximity/box_tree.hpp"
#include "proximity/primitives.hpp"

namespace springnet::proximity {

struct SearchOptions {
  // Pairs that may be found for each primitive, and any number up to `always`. A node among others of its size has
  // about 12 near it; a collapsed net has all.
  std::size_t pairs_for_each = 64;
  std::size_t always = 1'000'000;
  unsigned threads = 1;  // the pairs are the same for any number
};

class PairSearch {
 public:
  // Keeps the reference.
  explicit PairSearch(const Primitives& primitives, const SearchOptions& options = {});

  // All pairs whose distance may be at most their thickness plus `margin` (m, >= 0) while nodes move along straight
  // lines from `start` to `end`, which may be the same; and no pair whose distance at `start` is greater than that by
  // more than its nodes approach each other. In canonical order, which depends on nothing but the positions. `found`
  // keeps its memory. Throws Error: (simulation) if a coordinate is not finite or beyond 1e70 m, or if more pairs are
  // found than the options allow; (input) if a node has no position.
  void find(const Positions& start, const Positions& end, double margin, PairLists& found);
  void find(const Positions& x, double margin, PairLists& found) { find(x, x, margin, found); }

 private:
  void fit_trees(const Positions& start, const Positions& end, double margin);
  template <class Primitive, class NodesOf>
  void fit(BoxTree& tree, const std::vector<Primitive>& items, const NodesOf& nodes_of, const Positions& start,
           const Positions& end, double margin);

  const Primitives* primitives_;
  std::size_t most_pairs_;
  unsigned threads_;
  BoxTree balls_, edges_, triangles_;
  std::vector<Box> boxes_;            // of one kind of primitive at a time
  std::vector<Group> groups_;         // likewise
  Vector3 common_ = Vector3::Zero();  // m: motion that all nodes have in common, about
};

// Throws Error if a node of the primitives has no position, or one that is not finite or beyond 1e70 m.
void check_positions(const Primitives& primitives, const Positions& x);

// The middle of the box around the differences `end - start` of all nodes of the primitives, m.
[[nodiscard]] Vector3 common_motion(const Primitives& primitives, const Positions& start, const Positions& end);

}  // namespace springnet::proximity
