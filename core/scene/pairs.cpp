#include "scene/pairs.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include <fmt/format.h>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>

#include "scene/select.hpp"
#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

namespace index = boost::geometry::index;
using Point = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;
using Box = boost::geometry::model::box<Point>;
using Entry = std::pair<Point, NodeIndex>;
using Tree = index::rtree<Entry, index::quadratic<16>>;

// Relative tolerance for comparing distances, because lattice positions are rounded: far above rounding, far below an
// intended difference.
constexpr double rounding = 1e-9;

Tree make_tree(const std::vector<NodeIndex>& nodes, const Network& network) {
  std::vector<Entry> entries;
  entries.reserve(nodes.size());
  for (const NodeIndex node : nodes) {
    const Vector3& p = network.nodes()[node].position;
    entries.emplace_back(Point(p.x(), p.y(), p.z()), node);
  }
  return Tree(entries);
}

// Nodes of the tree at most `distance` from `node`, without itself, in ascending order.
std::vector<NodeIndex> neighbours(const Tree& tree, NodeIndex node, double distance, const Network& network) {
  const Vector3& p = network.nodes()[node].position;
  // Enlarged by the rounding of the box's corners.
  const Vector3 reach = Vector3::Constant(distance * (1 + rounding)) + 1e-15 * p.cwiseAbs();
  const Vector3 low = p - reach, high = p + reach;
  std::vector<Entry> found;
  tree.query(index::intersects(Box(Point(low.x(), low.y(), low.z()), Point(high.x(), high.y(), high.z()))),
             std::back_inserter(found));
  std::vector<NodeIndex> result;
  for (const auto& [point, other] : found) {
    if (other != node && (network.nodes()[other].position - p).norm() <= distance * (1 + rounding))
      result.push_back(other);
  }
  std::sort(result.begin(), result.end());
  return result;
}

// Stops early once there are more than `max_pairs`.
std::vector<Pair> pairs_within(const std::vector<NodeIndex>& from, const std::vector<NodeIndex>& to, double distance,
                               std::size_t max_pairs, const Network& network) {
  const Tree tree = make_tree(to, network);
  const auto in = [](const std::vector<NodeIndex>& sorted, NodeIndex node) {
    return std::binary_search(sorted.begin(), sorted.end(), node);
  };
  std::vector<Pair> pairs;
  for (const NodeIndex a : from) {
    for (const NodeIndex b : neighbours(tree, a, distance, network)) {
      // If the selections overlap, a pair is found from both ends: keep one.
      if (b < a && in(from, b) && in(to, a)) continue;
      pairs.emplace_back(a, b);
    }
    if (pairs.size() > max_pairs) break;
  }
  return pairs;
}

// For each node of `from` the nearest other node of `to`; the lowest number if several are equally near.
std::vector<Pair> nearest_pairs(const std::vector<NodeIndex>& from, const std::vector<NodeIndex>& to,
                                const Network& network) {
  const Tree tree = make_tree(to, network);
  std::vector<Pair> pairs;
  std::set<Pair> known;
  for (const NodeIndex a : from) {
    const Vector3& p = network.nodes()[a].position;
    std::vector<Entry> found;
    tree.query(index::nearest(Point(p.x(), p.y(), p.z()), 1) &&
                   index::satisfies([&](const Entry& entry) { return entry.second != a; }),
               std::back_inserter(found));
    if (found.empty()) continue;
    const double distance = (network.nodes()[found.front().second].position - p).norm();
    const NodeIndex b = neighbours(tree, a, distance, network).front();
    // If the selections overlap, two nodes may be each other's nearest.
    if (known.insert(std::minmax(a, b)).second) pairs.emplace_back(a, b);
  }
  return pairs;
}

NodeIndex read_end(const Value& value, std::string_view schema, const Network& network) {
  const Table end = value.table(schema);
  const auto name = end.find("body");
  return read_node(end.need("node"), name ? &find_body(*name, network) : nullptr, network);
}

std::vector<Pair> read_pairs(const Value& list, std::string_view schema, const Network& network) {
  std::vector<Pair> pairs;
  for (const Value& pair : list.elements()) {
    const std::vector<Value> ends = pair.elements(2);
    pairs.emplace_back(read_end(ends[0], schema, network), read_end(ends[1], schema, network));
    if (pairs.back().first == pairs.back().second) pair.fail("joins a node to itself; give two different nodes");
  }
  if (pairs.empty()) list.fail("lists no pair; give one or more, or remove the key");
  return pairs;
}

}  // namespace

std::vector<Pair> find_pairs(const Table& connect, const Network& network, const LimitOf& limit) {
  if (const auto pairs = connect.find("pairs")) {
    for (const char* key : {"from", "to", "within", "nearest"}) {
      if (connect.has(key)) connect.find(key)->fail("cannot be combined with 'pairs'; remove one of them");
    }
    return read_pairs(*pairs, fmt::format("{}.pairs", connect.schema()), network);
  }
  if (!connect.has("from")) connect.fail("does not say what it joins; add 'pairs', or 'from', 'to' and 'within'");
  const std::vector<NodeIndex> from = select_nodes(connect.need("from"), network);
  const std::vector<NodeIndex> to = select_nodes(connect.need("to"), network);
  const auto within = connect.find("within");
  const auto nearest = connect.find("nearest");
  if (within.has_value() == (nearest && nearest->boolean())) {
    connect.fail("needs either within = a distance in m, or nearest = true");
  }
  if (!within) return nearest_pairs(from, to, network);
  const PairLimit allowed = limit(from.size(), to.size());
  std::vector<Pair> pairs = pairs_within(from, to, within->number_above_0("m"), allowed.max_pairs, network);
  if (pairs.size() > allowed.max_pairs) {
    within->fail(
        fmt::format("joins more than {} pairs of the {} nodes of 'from' and the {} of 'to', but {}; lower the "
                    "distance, or select fewer nodes",
                    grouped(allowed.max_pairs), grouped(from.size()), grouped(to.size()), allowed.reason));
  }
  if (pairs.empty()) within->fail("no two nodes of 'from' and 'to' are that close; increase the distance");
  return pairs;
}

}  // namespace springnet::scene
