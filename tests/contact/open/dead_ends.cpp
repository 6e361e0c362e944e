// Random rigid bodies in contact, too many for the suite: the reference goes on, keeps lengths and surfaces, takes no
// energy from nowhere, and finds what it finds at every tolerance. The first case holds seeds that failed once and pass
// now, so that they do so on; the second one what is not met yet.

#include <doctest/doctest.h>

#include "fate.hpp"
#include "tumbling.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("rigid bodies that stopped the reference once, or chattered in it, do not") {
  for (const std::uint64_t seed : {26, 30, 101, 113, 130, 161, 170, 175, 194, 211, 238, 263, 307, 373, 399}) {
    const Tumbling scene(seed);
    INFO(scene.name() << ", seed " << seed);
    check_fate(scene.net, Tumbling::until);
  }
}

// A rod between springs comes to rest with friction on a plane, on both its nodes: what the rod bears between them is
// not determined, and there are two motions. 1e-7, 1e-10 and 1e-11 find one, 1e-8 and 1e-9 the other, 6 mm apart
// from 1.35 s.
TEST_CASE("rigid bodies go the same way at every tolerance") {
  const Tumbling scene(272);
  INFO(scene.name());
  check_fate(scene.net, Tumbling::until);
}
