// Overlaps at the start, by depth.
#include "proximity/near_pairs.hpp"

#include <cmath>
#include <cstddef>

#include <vector>

#include <doctest/doctest.h>

#include "proximity/pair_search.hpp"
#include "surfaces.hpp"

using namespace springnet;
using namespace springnet::proximity;

TEST_CASE("the deepest overlaps are named first") {
  Surfaces surfaces;
  add_block(surfaces, 3, 0.1, Vector3::Zero(), 0.005, 0);
  add_block(surfaces, 3, 0.1, Vector3(0.03, 0.04, 0.208), 0.005, 1);  // 8 mm above, 10 mm thick
  const Primitives primitives(surfaces.lists({{0, 1}}));
  const auto found = deepest_overlaps(primitives, surfaces.positions(), 1000);
  REQUIRE(!found.empty());
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i > 0) CHECK(found[i - 1].gap <= found[i].gap);
    CHECK(found[i].gap == doctest::Approx(-0.002).epsilon(1e-12));  // coordinates of 0.2 m are rounded by 1e-17
    CHECK(std::abs(found[i].separation.direction.z()) == doctest::Approx(1.0).epsilon(1e-12));
  }
  CHECK(deepest_overlaps(primitives, surfaces.positions(), 3).size() == 3);
  // One node is lowered.
  const NodeIndex corner = 27;  // the first of the second block
  surfaces.set(corner, surfaces.positions()[corner] - Vector3(0, 0, 0.004));
  const auto after = deepest_overlaps(primitives, surfaces.positions(), 1);
  REQUIRE(after.size() == 1);
  CHECK(after[0].gap == doctest::Approx(-0.006).epsilon(1e-12));
  CHECK(after[0].kind == PairKind::node_triangle);
  CHECK(primitives.balls()[after[0].pair.first].node == corner);
}

TEST_CASE("near pairs are those within the gap") {
  Surfaces surfaces;
  add_folded_sheet(surfaces, 12, 0.01, 3, 1e-3, Vector3::Zero(), 5e-4, 0);
  const Primitives primitives(surfaces.lists({{0, 0}}));
  PairLists pairs;
  PairSearch(primitives).find(surfaces.positions(), 3e-3, pairs);
  std::vector<NearPair> near;
  find_near(primitives, pairs, surfaces.positions(), 2e-3, near);
  std::size_t expected = 0;
  for (const PairKind kind : pair_kinds)
    for (const Pair pair : pairs[kind])
      expected += separation(kind, primitives.corners(kind, pair, surfaces.positions())).distance -
                      primitives.thickness(kind, pair) <=
                  2e-3;
  CHECK(near.size() == expected);
  CHECK(near.size() > 100);
  CHECK(near.size() < pairs.size());
  find_near(primitives, pairs, surfaces.positions(), -1.0, near);
  CHECK(near.empty());
}
