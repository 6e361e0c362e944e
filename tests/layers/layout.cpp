// Renumbering, units, and springs that are removed.

#include <doctest/doctest.h>

#include <numeric>
#include <set>

#include "random_net.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("the order of nodes is a permutation, and every live spring is in the units of its ends") {
  const Network net = random_network(20000, 4, 5);
  const layers::Layout layout(net, *plugins(), true);
  const layers::Ordering& ordering = layout.ordering();
  std::vector<std::uint32_t> sorted = ordering.user;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t k = 0; k < sorted.size(); ++k) REQUIRE(sorted[k] == k);
  for (std::uint32_t k = 0; k < sorted.size(); ++k) REQUIRE(ordering.engine[ordering.user[k]] == k);

  std::vector<int> seen(net.springs().size(), 0);
  std::size_t far = 0;
  for (std::size_t u = 0; u < layout.units().size(); ++u) {
    const layers::Unit& unit = layout.units()[u];
    CHECK(unit.first_node % layers::tile_nodes == 0);
    std::size_t live = 0;
    for (const layers::Segment& segment : unit.segments) {
      CHECK(segment.count <= layers::max_segment);
      for (std::uint32_t i = segment.begin; i < segment.begin + segment.count; ++i) {
        const std::uint32_t s = unit.spring[i];
        const bool is_live = (unit.live_mask[i / 8] >> (i % 8) & 1) != 0;
        REQUIRE(is_live == (s != layers::no_spring));
        if (!is_live) continue;
        ++live;
        ++seen[s];
        const auto [low, high] = std::minmax({layout.first(s), layout.second(s)});
        const bool is_far = layout.unit_of(high) > layout.unit_of(low) + 1;
        REQUIRE(is_far == (segment.access == layers::Access::far));
        REQUIRE((layout.unit_of(low) == u || (is_far && layout.unit_of(high) == u)));
        far += is_far ? 1 : 0;
      }
    }
    CHECK(live == unit.live);
  }
  CHECK(far > 0);  // from the last nodes to the first ones
  for (std::uint32_t s = 0; s < seen.size(); ++s) {
    const std::uint32_t a = layout.unit_of(layout.first(s)), b = layout.unit_of(layout.second(s));
    REQUIRE(seen[s] == ((a < b ? b - a : a - b) > 1 ? 2 : 1));
  }
}

TEST_CASE("a lattice is in chunks, and shuffled numbers do not spread it in memory") {
  Lattice lattice;
  lattice.nodes = {20, 20, 20};
  lattice.diagonals = Diagonals::space;
  Network regular, shuffled;
  const MaterialIndex material = regular.add_material(damped(1.0, 1.0));
  regular.add_lattice("box", lattice, Node{}, material);
  std::vector<std::uint32_t> order(regular.nodes().size()), place(order.size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  for (std::uint32_t k = 0; k < order.size(); ++k) {
    place[order[k]] = k;
    shuffled.add_node(regular.nodes()[order[k]]);
  }
  shuffled.add_material(damped(1.0, 1.0));
  for (const Spring& s : regular.springs())
    shuffled.add_spring(place[s.first], place[s.second], material, s.rest_length);

  const auto mean_distance = [](const layers::Layout& layout) {
    double sum = 0.0;
    for (std::uint32_t s = 0; s < layout.spring_count(); ++s)
      sum += std::abs(double(layout.first(s)) - double(layout.second(s)));
    return sum / static_cast<double>(layout.spring_count());
  };
  const layers::Layout one(regular, *plugins(), true), two(shuffled, *plugins(), true),
      raw(shuffled, *plugins(), false);
  for (const layers::Unit& unit : one.units()) {
    CHECK(unit.first.empty());
    CHECK(5 * unit.spring.size() < 6 * unit.live);  // few gaps
  }
  // A random numbering has a mean distance of a third of the nodes; Cuthill-McKee one of about a layer (up to 1.5 x
  // 20^2 nodes).
  CHECK(mean_distance(raw) > 2000.0);
  CHECK(mean_distance(two) < 700.0);
}

namespace {

// A copy without some springs, whose numbers it adds to `removed`.
template <class IsRemoved>
Network without(const Network& whole, const IsRemoved& is_removed, std::vector<std::uint32_t>& removed) {
  Network part;
  for (const LawUse& neuron : whole.neurons()) part.add_neuron(neuron);
  for (const Material& material : whole.materials()) part.add_material(material);
  for (const Node& node : whole.nodes()) part.add_node(node);
  part.set_gravity(whole.gravity());
  for (std::uint32_t s = 0; s < whole.springs().size(); ++s) {
    const Spring& spring = whole.springs()[s];
    if (is_removed(s, spring))
      removed.push_back(s);
    else
      part.add_spring(spring.first, spring.second, spring.material, spring.rest_length);
  }
  return part;
}

}  // namespace

TEST_CASE("whole chunks, segments and tiles of springs can be removed") {
  Lattice lattice;
  lattice.nodes = {11, 14, 40};
  lattice.diagonals = Diagonals::space;
  for (const bool relative : {false, true}) {
    CAPTURE(relative);
    Network whole;
    whole.add_lattice(
        "box", lattice, Node{},
        whole.add_material({LawUse{"linear", {{"stiffness", 3.0}}},
                            relative ? LawUse{"relative", {{"damping", 0.5}}} : LawUse{"linear", {{"damping", 0.5}}}}));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-0.1, 0.1);
    for (NodeIndex k = 0; k < whole.nodes().size(); ++k) {
      Node node = whole.nodes()[k];
      node.position += Vector3(unit(random), unit(random), unit(random));
      node.velocity = Vector3(unit(random), unit(random), unit(random));
      whole.set_node(k, node);
    }
    EvaluatorFixture cut(whole, InstructionSet::best, 1, false);
    cut.evaluate();  // whose forces must not stay behind
    std::vector<std::uint32_t> removed;
    const auto is_removed = [](std::uint32_t, const Spring& s) {
      const std::uint32_t low = std::min(s.first, s.second), distance = std::max(s.first, s.second) - low;
      const std::uint32_t tile = low / 64;
      if (tile == 0 || tile == 9) return true;                 // all
      if (tile == 3) return distance == 1 || distance == 11;   // of two distances
      if (tile == 4) return distance == 1 || distance >= 154;  // of one rest length nearly all
      if (tile >= 5 && tile < 8) return low % 64 < 16;         // of sixteen nodes
      return tile == 8 && (distance == 11 || low % 8 < 7);     // but one of each eight
    };
    const Network part = without(whole, is_removed, removed);
    cut.layout.remove(removed);
    CHECK(cut.layout.units()[0].live < cut.layout.units()[0].laid_out);  // it was not laid out again
    for (int turn = 0; turn < 2; ++turn) cut.evaluate();
    EvaluatorFixture built(part, InstructionSet::best, 1, false);
    built.evaluate();
    for (std::uint32_t k = 0; k < whole.nodes().size(); ++k)
      REQUIRE((cut.force(k) - built.force(k)).norm() <= 1e-13);  // another order of sums of up to 14 forces below 1 N
  }
}

TEST_CASE("a network without some springs is the network from which they were removed") {
  const Network whole = random_network(9000, 3, 9);
  std::vector<std::uint32_t> removed;
  const Network part = without(
      whole, [](std::uint32_t s, const Spring&) { return s % 7 == 3; }, removed);
  EvaluatorFixture cut(whole, InstructionSet::best, 1, false), built(part, InstructionSet::best, 1, false);
  CHECK(cut.layout.remove(removed).size() == removed.size());
  CHECK(cut.layout.remove(removed).empty());
  CHECK(cut.layout.live_count() == part.springs().size());
  cut.evaluate();
  built.evaluate();
  for (std::uint32_t k = 0; k < whole.nodes().size(); ++k)
    REQUIRE((cut.force(k) - built.force(k)).norm() <= 1e-12 * (1.0 + built.force(k).norm()));  // another order of sums
  CHECK(cut.layout.neighbours() == built.layout.neighbours());
}

TEST_CASE("units are of equal size, twice as large as springs reach, and depend on the network alone") {
  Lattice lattice;
  lattice.nodes = {15, 80, 40};  // a layer has 1200 nodes
  Network net;
  net.add_lattice("box", lattice, Node{}, net.add_material(damped(1.0, 0.0)));
  for (const bool renumber : {true, false}) {
    const layers::Ordering ordering = layers::order_nodes(net, renumber);
    for (std::uint32_t k = 0; k < 48000; ++k) REQUIRE(ordering.user[k] == k);  // it is compact
    const std::uint32_t size = ordering.unit_start[1];
    CHECK(size % layers::tile_nodes == 0);
    CHECK(size >= 2 * 1200);
    CHECK(size < 2 * 1200 * 9 / 8 + layers::tile_nodes);  // to an eighth
    for (std::size_t u = 0; u + 2 < ordering.unit_start.size(); ++u)
      CHECK(ordering.unit_start[u + 1] - ordering.unit_start[u] == size);
    CHECK(ordering.unit_start.back() == 48000);
  }
}

TEST_CASE("a net whose springs lead anywhere still has eight units") {
  std::mt19937 random(7);
  Network net;
  for (std::uint32_t k = 0; k < 40000; ++k) net.add_node(point({0.1 * k, 1.0 * (k % 3), 0}));
  const MaterialIndex material = net.add_material(damped(1.0, 0.0));
  // Three springs a node: with one it would be a few trees, which have a narrow order.
  for (std::uint32_t i = 0; i < 120000; ++i)
    if (const auto other = static_cast<std::uint32_t>(random() % 40000); other != i % 40000)
      net.add_spring(i % 40000, other, material);
  CHECK(layers::order_nodes(net, true).unit_start.size() == 1 + 8);
}

TEST_CASE(
    "neighbours are the nodes joined by springs, rods, elements and following faces, by increasing user's number") {
  Network net;
  for (int k = 0; k < 8; ++k) net.add_node(point({static_cast<double>(k * k), static_cast<double>(k % 3), 0}));
  const MaterialIndex material = net.add_material(damped(1.0, 0.0));
  net.add_spring(5, 0, material);
  net.add_spring(0, 5, material);  // twice the same neighbour
  net.add_rigid(0, 7);
  net.add_element(Invariant::angle, {3, 0, 1}, material);
  Load load;
  load.faces = {{0, 2, 4}};
  load.pressure = 1.0;
  load.follow = true;
  net.add_load(load);
  layers::Layout layout(net, *plugins(), true);
  const layers::Ordering& ordering = layout.ordering();
  const auto of = [&](NodeIndex node) {
    const std::uint32_t k = ordering.engine[node];
    std::vector<NodeIndex> found;
    for (std::uint32_t i = layout.neighbour_start()[k]; i < layout.neighbour_start()[k + 1]; ++i)
      found.push_back(ordering.user[layout.neighbours()[i]]);
    return found;
  };
  using Nodes = std::vector<NodeIndex>;
  CHECK(of(0) == Nodes{1, 2, 3, 4, 5, 7});
  CHECK(of(3) == Nodes{0, 1});
  CHECK(of(6).empty());
  CHECK(of(7) == Nodes{0});
  CHECK(layout.remove({0}) == std::vector<std::uint32_t>{0});
  CHECK(of(0) == Nodes{1, 2, 3, 4, 5, 7});  // there is the other one
  CHECK(layout.remove({1, 0}) == std::vector<std::uint32_t>{1});
  CHECK(of(0) == Nodes{1, 2, 3, 4, 7});
  CHECK(of(5).empty());
  CHECK(layout.remove_elements({0}).size() == 1);
  CHECK(of(0) == Nodes{2, 4, 7});
  CHECK(layout.remove_faces({0}).size() == 1);
  CHECK(of(0) == Nodes{7});  // rods stay
  CHECK(layout.live_count() == 0);
  CHECK(layout.incident_begin(ordering.engine[0]) == layout.incident_end(ordering.engine[0]));
}

namespace {

// Whether all slots without a spring have the parameters of the spring whose length the kernels give them.
bool gaps_are_consistent(const layers::Unit& unit) {
  for (std::size_t i = 0; i < unit.segments.size(); ++i) {
    const layers::Segment& segment = unit.segments[i];
    if (segment.row != layers::mixed_rows || segment.dead == segment.count) continue;
    const std::size_t end = i + 1 < unit.segments.size() ? unit.segments[i + 1].value_begin : unit.values.size();
    for (std::size_t column = segment.value_begin; column < end; column += segment.count) {
      for (std::uint32_t slot = 0; slot < segment.count; ++slot) {
        if (unit.spring[segment.begin + slot] != layers::no_spring) continue;
        std::uint32_t source = segment.living;
        if (segment.access == layers::Access::chunks)
          for (std::uint32_t other = slot / 8 * 8 + 8; other-- > slot / 8 * 8;)
            if (unit.spring[segment.begin + other] != layers::no_spring) source = other;
        if (unit.values[column + slot] != unit.values[column + source]) return false;
      }
    }
  }
  return true;
}

}  // namespace

TEST_CASE("laws meet no length of one spring with the rest length of another, where springs are missing") {
  // exp(10 (l / l0 - 1)) is infinite for any two springs of these that are mixed up.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const bool regular : {true, false}) {
    CAPTURE(regular);
    Network net;
    const MaterialIndex material = net.add_material(
        {LawUse{"exponential", {{"stiffness", 1.0}, {"exponent", 10.0}}}, LawUse{"linear", {{"damping", 1.0}}}});
    double x = 0.0;
    for (std::uint32_t k = 0; k < 100; ++k) {
      net.add_node(point({x, 0, 0}));
      x += k % 2 == 0 ? 1.0 : 1e-3;
    }
    for (std::uint32_t k = 0; k < 99; ++k) {
      const std::uint32_t other = regular ? k + 1 : k + 1 + static_cast<std::uint32_t>(random() % (99 - k));
      if (k % 8 != 5) net.add_spring(k, other, material);  // gaps from the beginning, too
    }
    EvaluatorFixture fixture(net, InstructionSet::best, 1, false);
    std::vector<std::uint32_t> order(net.springs().size());
    std::iota(order.begin(), order.end(), 0u);
    if (!regular) std::shuffle(order.begin(), order.end(), random);
    const auto is_at_rest = [&] {
      fixture.evaluate();
      for (std::uint32_t k = 0; k < net.nodes().size(); ++k)
        if (!(fixture.force(k).norm() <= 1e-9)) return false;  // lengths are rounded; stiff in strain
      return true;
    };
    CHECK(is_at_rest());
    CHECK(gaps_are_consistent(fixture.layout.units()[0]));
    for (const std::uint32_t s : order) {
      CAPTURE(s);
      fixture.layout.remove({s});
      REQUIRE(is_at_rest());
      REQUIRE(gaps_are_consistent(fixture.layout.units()[0]));
    }
  }
}

TEST_CASE("a force that is not finite is at the ends of its spring alone") {
  for (const std::uint32_t distance : {1u, 2u}) {
    Network net;
    const MaterialIndex material = net.add_material(
        {LawUse{"exponential", {{"stiffness", 1.0}, {"exponent", 10.0}}}, LawUse{"linear", {{"damping", 1.0}}}});
    for (std::uint32_t k = 0; k < 24; ++k) net.add_node(point({1.0 * k + (k >= 13 ? 400.0 : 0.0), 0, 0}));
    for (std::uint32_t k = 12; k + distance < 24; k += distance) net.add_spring(k, k + distance, material, distance);
    EvaluatorFixture fixture(net, InstructionSet::best, 1, false);
    fixture.evaluate();
    for (std::uint32_t k = 0; k < 24; ++k) CHECK(fixture.force(k).allFinite() == (k != 12 && k != 12 + distance));
  }
}
