// Loops over the functions of sdk/math.hpp have the same bits for every instruction set, and as single calls.
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/sdk/dual.hpp>

#include "law_call.hpp"
#include "loops.hpp"

using namespace springnet::test;

namespace {

// Numbers of every size and sign, many near 1, and the special ones.
std::vector<double> arguments(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<double> result{0.0,     -0.0, 1.0,    -1.0, 0.5,    2.0,    HUGE_VAL, -HUGE_VAL, std::nan(""), 5e-324,
                             -1e-310, 3.0,  0x1p23, 1e22, -1e300, 745.14, 1.7e308,  0x1p-1022, -709.9,       0x1p53};
  while (result.size() < 50000) {
    result.push_back(std::bit_cast<double>(random()));
    for (const double scale : {1.0, 4.0, 50.0, 1000.0}) {
      result.push_back(scale * std::uniform_real_distribution<double>(-1.0, 1.0)(random));
    }
  }
  std::shuffle(result.begin(), result.end(), random);
  return result;
}

// All nan are one: which of two is passed on is up to the order of operands.
std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(std::isnan(x) ? std::nan("") : x); }

}  // namespace

TEST_CASE("functions have the same bits for every instruction set and as single calls") {
  const std::vector<double> x = arguments(1), y = arguments(2);
  const std::size_t count = std::min(x.size(), y.size());
  for (const std::uint32_t set : instruction_sets()) {
    if (set == SPRINGNET_GENERIC) continue;
    const auto loops = set == SPRINGNET_AVX2 ? avx2_loops() : avx512_loops();
    for (std::size_t k = 0; k < loops.size(); ++k) {
      CAPTURE(set);
      CAPTURE(loops[k].name);
      std::vector<double> here(count), there(count);
      loops[k].run(x.data(), y.data(), here.data(), count);
      generic_loops()[k].run(x.data(), y.data(), there.data(), count);
      std::size_t different = 0;
      for (std::size_t i = 0; i < count; ++i) different += bits(here[i]) != bits(there[i]) ? 1 : 0;
      CHECK(different == 0);
    }
  }
  // Calls with other neighbours: the ends of loops are scalar code.
  for (const Loop& loop : generic_loops()) {
    CAPTURE(loop.name);
    std::vector<double> together(1000), alone(1000);
    loop.run(x.data(), y.data(), together.data(), 1000);
    for (std::size_t i = 0; i < 1000; ++i) loop.run(x.data() + i, y.data() + i, alone.data() + i, 1);
    std::size_t different = 0;
    for (std::size_t i = 0; i < 1000; ++i) different += bits(together[i]) != bits(alone[i]) ? 1 : 0;
    CHECK(different == 0);
  }
}
