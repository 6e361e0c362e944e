#include "proximity/pair_search.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "proximity/distance.hpp"
#include "proximity/in_parts.hpp"

namespace springnet::proximity {

namespace {

constexpr std::size_t leaves_in_part = 128;  // of which threads take one after the other
constexpr double largest_coordinate = 1e70;  // m: products of four are finite

// Puts pairs in order: counts by the first, then sorts the few that have the same.
void put_in_order(std::vector<Pair>& pairs, std::size_t firsts) {
  std::vector<std::size_t> start(firsts + 1, 0);
  for (const Pair& pair : pairs) ++start[pair.first + 1];
  for (std::size_t i = 0; i < firsts; ++i) start[i + 1] += start[i];
  std::vector<Pair> ordered(pairs.size());
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  for (const Pair& pair : pairs) ordered[next[pair.first]++] = pair;
  for (std::size_t i = 0; i < firsts; ++i)
    std::sort(ordered.begin() + static_cast<std::ptrdiff_t>(start[i]),
              ordered.begin() + static_cast<std::ptrdiff_t>(start[i + 1]));
  pairs.swap(ordered);
}

// The most by which nodes of both primitives move relative to each other, m.
double relative_motion(PairKind kind, const std::array<Vector3, 4>& start, const std::array<Vector3, 4>& end) {
  double most = 0.0;
  const auto first = static_cast<std::size_t>(first_nodes(kind)), second = static_cast<std::size_t>(second_nodes(kind));
  for (std::size_t i = 0; i < first; ++i)
    for (std::size_t j = first; j < first + second; ++j)
      most = std::max(most, ((end[i] - start[i]) - (end[j] - start[j])).squaredNorm());
  return std::sqrt(most);
}

bool are_same(const Positions& a, const Positions& b) {
  return a.x[0] == b.x[0] && a.x[1] == b.x[1] && a.x[2] == b.x[2];
}

}  // namespace

void check_positions(const Primitives& primitives, const Positions& x) {
  for (const NodeIndex node : primitives.nodes()) {
    if (node >= x.nodes)
      throw Error(ErrorKind::input,
                  fmt::format("node {} is checked for contact, but there are {} nodes", node, x.nodes));
    const Vector3 at = x[node];
    if (!(at.cwiseAbs().maxCoeff() <= largest_coordinate) || !at.allFinite())
      throw Error(ErrorKind::simulation,
                  fmt::format("node {} is at ({}, {}, {}) m, where no contact can be searched for", node, at.x(),
                              at.y(), at.z()));
  }
}

Vector3 common_motion(const Primitives& primitives, const Positions& start, const Positions& end) {
  if (primitives.nodes().empty()) return Vector3::Zero();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vector3 low = Vector3::Constant(infinity), high = -low;
  for (const NodeIndex node : primitives.nodes()) {
    const Vector3 motion = end[node] - start[node];
    low = low.cwiseMin(motion);
    high = high.cwiseMax(motion);
  }
  return 0.5 * (low + high);
}

PairSearch::PairSearch(const Primitives& primitives, const SearchOptions& options)
    : primitives_(&primitives),
      most_pairs_(std::max(
          options.always, options.pairs_for_each *
                              (primitives.balls().size() + primitives.edges().size() + primitives.triangles().size()))),
      threads_(options.threads) {}

template <class Primitive, class NodesOf>
void PairSearch::fit(BoxTree& tree, const std::vector<Primitive>& items, const NodesOf& nodes_of,
                     const Positions& start, const Positions& end, double margin) {
  const bool moves = !are_same(start, end);
  boxes_.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    Box box = Box::empty();
    for (const NodeIndex node : nodes_of(items[i])) {
      box.include(start[node]);
      if (moves) box.include(end[node] - common_);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      // Half of the margin on either side, and what sums and differences of coordinates are rounded by.
      const double rounding =
          8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(box.low[k]), std::abs(box.high[k]));
      const double reach = items[i].radius + 0.5 * margin + rounding;
      box.low[k] -= reach;
      box.high[k] += reach;
    }
    boxes_[i] = box;
  }
  if (tree.is_built_for(items.size())) {
    tree.refit(boxes_);
    if (!tree.is_worn()) return;
  }
  groups_.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) groups_[i] = items[i].group;
  tree.build(boxes_, groups_);
}

void PairSearch::fit_trees(const Positions& start, const Positions& end, double margin) {
  const bool node_triangle = primitives_->checks_any(PairKind::node_triangle);
  if (node_triangle || primitives_->checks_any(PairKind::node_node))
    fit(
        balls_, primitives_->balls(), [](const Ball& ball) { return std::array{ball.node}; }, start, end, margin);
  if (node_triangle)
    fit(
        triangles_, primitives_->triangles(), [](const Triangle& triangle) { return triangle.nodes; }, start, end,
        margin);
  if (primitives_->checks_any(PairKind::edge_edge))
    fit(
        edges_, primitives_->edges(), [](const Edge& edge) { return edge.nodes; }, start, end, margin);
}

void PairSearch::find(const Positions& start, const Positions& end, double margin, PairLists& found) {
  const bool moves = !are_same(start, end);
  check_positions(*primitives_, start);
  if (moves) check_positions(*primitives_, end);
  common_ = moves ? common_motion(*primitives_, start, end) : Vector3(Vector3::Zero());
  fit_trees(start, end, margin);
  for (auto& pairs : found.of_kind) pairs.clear();
  Effort effort(Effort::of_search(*primitives_));
  std::atomic<std::size_t> count{0};
  for (const PairKind kind : pair_kinds) {
    if (!primitives_->checks_any(kind)) continue;
    const auto is_near = [&](Pair pair) {
      if (!primitives_->may_touch(kind, pair)) return false;
      const auto corners = primitives_->corners(kind, pair, start);
      double reach = primitives_->thickness(kind, pair) + margin;
      if (moves) reach += relative_motion(kind, corners, primitives_->corners(kind, pair, end));
      reach *= 1.0 + 1e-9;  // rounding
      return !is_surely_beyond(kind, corners, reach) && !(separation(kind, corners).distance > reach);
    };
    const auto partners = [&](Group group) { return primitives_->partner_mask(kind, group); };
    const auto search_part = [&](std::size_t first_leaf, std::size_t last_leaf, std::vector<Pair>& pairs) {
      const auto consider = [&](std::uint32_t first, std::uint32_t second) {
        if (!is_near({first, second})) return;
        if (count.fetch_add(1, std::memory_order_relaxed) >= most_pairs_)
          throw Error(ErrorKind::simulation,
                      fmt::format("more than {} pairs of nodes, triangles and edges are within {:.3g} m of contact: "
                                  "positions have collapsed, or the margin is large beside the distances of nodes",
                                  most_pairs_, margin));
        pairs.push_back({first, second});
      };
      if (kind == PairKind::node_triangle)
        BoxTree::for_overlaps(balls_, first_leaf, last_leaf, triangles_, partners, effort, consider);
      else
        (kind == PairKind::node_node ? balls_ : edges_)
            .for_own_overlaps(first_leaf, last_leaf, partners, effort, consider);
    };
    const BoxTree& leaves_of = kind == PairKind::edge_edge ? edges_ : balls_;
    append_in_parts(leaves_of.leaves(), leaves_in_part, threads_, found[kind], search_part);
    put_in_order(found[kind], kind == PairKind::edge_edge ? primitives_->edges().size() : primitives_->balls().size());
  }
}

}  // namespace springnet::proximity
