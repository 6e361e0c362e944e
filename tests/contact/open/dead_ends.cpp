// Random rigid bodies in contact, too many for the suite: the reference goes on, keeps lengths and surfaces, takes no
// energy from nowhere, and finds what it finds at every tolerance. The first case holds seeds that failed once and pass
// now, so that they do so on; the second one those that are not met yet.

#include <doctest/doctest.h>

#include "fate.hpp"
#include "tumbling.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("rigid bodies that stopped the reference once, or chattered in it, do not") {
  for (const std::uint64_t seed : {26, 30, 101, 113, 130, 161, 170, 175, 194, 211, 238, 263, 373, 399}) {
    const Tumbling scene(seed);
    INFO(scene.name() << ", seed " << seed);
    check_fate(scene.net, Tumbling::until);
  }
}

// 272: a rod between springs rubs on a sphere and a plane; 1e-7 and 1e-9 are 6 mm apart from 1.35 s on. 307: a triangle
// with all its corners on a capsule that holds them. Forces are not determined: with two of them braced each could
// leave if the other stayed, with one let go the other cannot, and the run stops between the two at 0.843 s.
TEST_CASE("rigid bodies go the same way at every tolerance, and on") {
  for (const std::uint64_t seed : {272, 307}) {
    const Tumbling scene(seed);
    INFO(scene.name() << ", seed " << seed);
    check_fate(scene.net, Tumbling::until);
  }
}
