// Four hundred random rigid bodies in contact, too many for the suite: the reference goes on, keeps lengths and
// surfaces, takes no energy from nowhere, and finds what it finds at every tolerance.

#include <doctest/doctest.h>

#include "fate.hpp"
#include "tumbling.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("rigid bodies that tumble onto surfaces and into grooves keep the rules of contact in the reference") {
  constexpr std::uint64_t bodies = 400;
  for (std::uint64_t seed = 0; seed < bodies; ++seed) {
    const Tumbling scene(seed);
    INFO(scene.name() << ", seed " << seed);
    check_fate(scene.net, Tumbling::until);
  }
}
