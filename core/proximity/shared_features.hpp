// Which primitives have a corner or an edge in common. A pair whose closest points lie on features that another pair
// has as well is never nearer than that other one, which therefore says all that both do.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "proximity/distance.hpp"
#include "proximity/primitives.hpp"

namespace springnet::proximity {

class SharedFeatures {
 public:
  explicit SharedFeatures(const Primitives& primitives);

  // use(kind, pair) of each pair that may touch, this one among them, whose primitives have these features of it.
  template <class Use>
  void for_each_pair_at(PairKind kind, Pair pair, Features features, const Use& use) const {
    std::array<std::array<NodeIndex, 3>, 2> nodes{};
    std::array<std::size_t, 2> counts{};
    const std::array<NodeIndex, 4> all = primitives_.nodes_of(kind, pair);
    for (int i = 0; i < first_nodes(kind) + second_nodes(kind); ++i)
      if ((features >> i & 1u) != 0) {
        const std::size_t side = i < first_nodes(kind) ? 0 : 1;
        nodes[side][counts[side]++] = all[static_cast<std::size_t>(i)];
      }
    if (counts[0] == 0 || counts[1] == 0) return;
    const auto visit = [&](PairKind of, std::uint32_t first, std::uint32_t second) {
      if (of != PairKind::node_triangle && first > second) std::swap(first, second);
      if (primitives_.may_touch(of, {first, second})) use(of, Pair{first, second});
    };
    std::array<Having, 2> having;
    for (std::size_t side = 0; side < 2; ++side) find(nodes[side], counts[side], having[side]);
    for (const std::uint32_t a : having[0].edges)
      for (const std::uint32_t b : having[1].edges) visit(PairKind::edge_edge, a, b);
    for (std::size_t side = 0; side < 2; ++side)
      if (having[side].ball != none)
        for (const std::uint32_t triangle : having[1 - side].triangles)
          visit(PairKind::node_triangle, having[side].ball, triangle);
    if (having[0].ball != none && having[1].ball != none) visit(PairKind::node_node, having[0].ball, having[1].ball);
  }

 private:
  static constexpr std::uint32_t none = 0xffffffffu;
  // Primitives that have all nodes of a feature.
  struct Having {
    std::uint32_t ball = none;
    std::vector<std::uint32_t> edges, triangles;
  };
  void find(const std::array<NodeIndex, 3>& nodes, std::size_t count, Having& having) const;

  // Places of primitives, for each node those from begin[node] to begin[node + 1].
  struct OfNodes {
    std::vector<std::uint32_t> begin, places;
  };
  template <class List>
  [[nodiscard]] OfNodes of_nodes(const List& list) const;

  const Primitives& primitives_;
  OfNodes edges_, triangles_;
  std::vector<std::uint32_t> balls_;  // [node]
};

}  // namespace springnet::proximity
