// Rigid bodies in contact, where what one node's contact allows depends on those of the others: the reference goes on,
// keeps lengths and surfaces, takes no energy from nowhere, and finds what it finds at every tolerance.

#include <doctest/doctest.h>

#include "fate.hpp"
#include "tumbling.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("rigid bodies that tumble into grooves and between surfaces do not stop the reference") {
  for (const std::uint64_t seed :
       {23, 26, 27, 30, 44, 47, 56, 63, 84, 101, 104, 113, 130, 131, 147, 156, 161, 170, 175, 184, 194}) {
    const Tumbling scene(seed);
    INFO(scene.name() << ", seed " << seed);
    check_fate(scene.net, Tumbling::until);
  }
}
