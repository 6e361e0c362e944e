// Contact detection on a block of 97,336 nodes beside another body, none of which touch, and on a sheet of 40,000 nodes
// in narrow folds, whose layers are within the margin of each other near each fold: rows of the benchmark program. The
// R-tree of Boost.Geometry finds the same overlaps of boxes for comparison with `overlaps`.
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/iterator/function_output_iterator.hpp>

#include "proximity/near_pairs.hpp"
#include "proximity/neighbour_list.hpp"
#include "surfaces.hpp"

namespace {

using namespace springnet::proximity;
using springnet::NodeIndex;
using springnet::Vector3;

constexpr double radius = 5e-4, skin = 1e-3;  // m; edges are 1e-2 m long

struct Net {
  Surfaces surfaces;
  Primitives primitives;
};

Net net_of(bool block) {
  Surfaces surfaces;
  if (block) {
    add_block(surfaces, 46, 1e-2, Vector3::Zero(), radius, 0);
    add_block(surfaces, 20, 1e-2, Vector3(0.1, 0.1, 0.46), radius, 1);  // 1e-2 m above
    return {surfaces, Primitives(surfaces.lists({{0, 0}, {0, 1}}))};
  }
  add_folded_sheet(surfaces, 200, 1e-2, 20, 3e-4, Vector3::Zero(), radius, 0);
  return {surfaces, Primitives(surfaces.lists({{0, 0}}))};
}

void report(benchmark::State& state, const Net& net, std::size_t pairs) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(net.surfaces.x[0].size()));
  state.counters["pairs"] = static_cast<double>(pairs);
}

// The first search, which builds the trees.
void first_search(benchmark::State& state, bool block) {
  const Net net = net_of(block);
  PairLists found;
  for ([[maybe_unused]] auto iteration : state) PairSearch(net.primitives).find(net.surfaces.positions(), skin, found);
  report(state, net, found.size());
}

// Each later one.
void search(benchmark::State& state, bool block) {
  const Net net = net_of(block);
  PairSearch search(net.primitives);
  PairLists found;
  search.find(net.surfaces.positions(), skin, found);
  for ([[maybe_unused]] auto iteration : state) search.find(net.surfaces.positions(), skin, found);
  report(state, net, found.size());
}

// The check of a step that needs no search: at its start and at its end.
void step_check(benchmark::State& state, bool block) {
  const Net net = net_of(block);
  NeighbourList list(net.primitives, skin);
  Surfaces end = net.surfaces;
  end.x[2][7] += 0.1 * skin;
  list.update(net.surfaces.positions(), end.positions());
  for ([[maybe_unused]] auto iteration : state)
    if (list.update(net.surfaces.positions(), end.positions())) state.SkipWithError("it searched");
  report(state, net, list.pairs().size());
}

// Distances of all pairs of the list, of which those that overlap are kept.
void near_pairs(benchmark::State& state, bool block) {
  const Net net = net_of(block);
  PairLists pairs;
  PairSearch(net.primitives).find(net.surfaces.positions(), skin, pairs);
  std::vector<NearPair> found;
  for ([[maybe_unused]] auto iteration : state) find_near(net.primitives, pairs, net.surfaces.positions(), 0.0, found);
  report(state, net, found.size());
}

// First meetings of all pairs of the list, in a step of a tenth of the skin.
void meetings(benchmark::State& state, bool block) {
  const Net net = net_of(block);
  PairLists pairs;
  PairSearch(net.primitives).find(net.surfaces.positions(), skin, pairs);
  Surfaces end = net.surfaces;
  std::uint64_t random = 1;
  for (auto& component : end.x)
    for (double& coordinate : component) {
      random = random * 6364136223846793005U + 1442695040888963407U;
      coordinate += 0.1 * skin * (static_cast<double>(random >> 11) * 0x1p-52 - 1.0);
    }
  std::vector<MeetingPair> found;
  for ([[maybe_unused]] auto iteration : state)
    find_meetings(net.primitives, pairs, net.surfaces.positions(), end.positions(), found);
  report(state, net, found.size());
}

template <class Primitive, class NodesOf>
std::pair<std::vector<Box>, std::vector<Group>> boxes_of(const Net& net, const std::vector<Primitive>& items,
                                                         const NodesOf& nodes_of) {
  std::pair<std::vector<Box>, std::vector<Group>> made;
  for (const Primitive& item : items) {
    Box box = Box::empty();
    for (const NodeIndex node : nodes_of(item)) box.include(net.surfaces.positions()[node]);
    for (std::size_t k = 0; k < 3; ++k) {
      box.low[k] -= item.radius + 0.5 * skin;
      box.high[k] += item.radius + 0.5 * skin;
    }
    made.first.push_back(box);
    made.second.push_back(item.group);
  }
  return made;
}

struct AllBoxes {
  std::pair<std::vector<Box>, std::vector<Group>> balls, edges, triangles;
};

AllBoxes all_boxes(const Net& net) {
  return {boxes_of(net, net.primitives.balls(), [](const Ball& ball) { return std::array{ball.node}; }),
          boxes_of(net, net.primitives.edges(), [](const Edge& edge) { return edge.nodes; }),
          boxes_of(net, net.primitives.triangles(), [](const Triangle& triangle) { return triangle.nodes; })};
}

// Overlaps of boxes alone: of edges with each other, of nodes with triangles. The trees are fitted anew, as in each
// search but the first.
void overlaps(benchmark::State& state, bool block) {
  const Net net = net_of(block);
  const AllBoxes boxes = all_boxes(net);
  BoxTree balls, edges, triangles;
  balls.build(boxes.balls.first, boxes.balls.second);
  edges.build(boxes.edges.first, boxes.edges.second);
  triangles.build(boxes.triangles.first, boxes.triangles.second);
  std::size_t pairs = 0;
  const auto any = [](Group) { return ~std::uint32_t{0}; };
  const auto count = [&pairs](std::uint32_t, std::uint32_t) { ++pairs; };
  for ([[maybe_unused]] auto iteration : state) {
    pairs = 0;
    Effort effort(Effort::of_search(net.primitives));
    balls.refit(boxes.balls.first);
    edges.refit(boxes.edges.first);
    triangles.refit(boxes.triangles.first);
    edges.for_own_overlaps(0, edges.leaves(), any, effort, count);
    BoxTree::for_overlaps(balls, 0, balls.leaves(), triangles, any, effort, count);
  }
  report(state, net, pairs);
}

// The same by R-trees, packed anew each time, which is the fastest that Boost.Geometry has for boxes that all move.
void overlaps_rtree(benchmark::State& state, bool block) {
  namespace geometry = boost::geometry;
  using Point = geometry::model::point<double, 3, geometry::cs::cartesian>;
  using Value = std::pair<geometry::model::box<Point>, std::uint32_t>;
  using Tree = geometry::index::rtree<Value, geometry::index::linear<8>>;
  const Net net = net_of(block);
  const AllBoxes boxes = all_boxes(net);
  const auto values_of = [](const std::vector<Box>& of) {
    std::vector<Value> values;
    for (const Box& box : of)
      values.emplace_back(geometry::model::box<Point>(Point(box.low[0], box.low[1], box.low[2]),
                                                      Point(box.high[0], box.high[1], box.high[2])),
                          static_cast<std::uint32_t>(values.size()));
    return values;
  };
  std::size_t pairs = 0;
  for ([[maybe_unused]] auto iteration : state) {
    pairs = 0;
    const std::vector<Value> balls = values_of(boxes.balls.first), edges = values_of(boxes.edges.first),
                             triangles = values_of(boxes.triangles.first);
    const Tree of_edges(edges.begin(), edges.end()), of_triangles(triangles.begin(), triangles.end());
    for (const Value& edge : edges)
      of_edges.query(
          geometry::index::intersects(edge.first),
          boost::make_function_output_iterator([&](const Value& other) { pairs += edge.second < other.second; }));
    for (const Value& ball : balls)
      of_triangles.query(geometry::index::intersects(ball.first),
                         boost::make_function_output_iterator([&](const Value&) { ++pairs; }));
  }
  report(state, net, pairs);
}

#define SPRINGNET_PROXIMITY(function)                                                                             \
  BENCHMARK_CAPTURE(function, block, true)->Name("proximity/" #function "/block")->Unit(benchmark::kMillisecond); \
  BENCHMARK_CAPTURE(function, sheet, false)->Name("proximity/" #function "/sheet")->Unit(benchmark::kMillisecond)
SPRINGNET_PROXIMITY(first_search);
SPRINGNET_PROXIMITY(search);
SPRINGNET_PROXIMITY(step_check);
SPRINGNET_PROXIMITY(near_pairs);
SPRINGNET_PROXIMITY(meetings);
SPRINGNET_PROXIMITY(overlaps);
SPRINGNET_PROXIMITY(overlaps_rtree);
#undef SPRINGNET_PROXIMITY

}  // namespace
