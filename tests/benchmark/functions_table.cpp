// The time of each function of sdk/math.hpp in a vectorised loop, ns an element, beside SLEEF's functions of up to 1
// ulp for the same width of vectors, where that library was found (Debian: libsleef-dev). SLEEF uses FMA with AVX2 and
// AVX-512, so that its bits depend on the instruction set; ours do without.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "law_call.hpp"
#include "loops.hpp"
#if defined(SPRINGNET_SLEEF_LOOPS)
#include "sleef_loops.hpp"
#endif

namespace {

constexpr std::size_t count = 2048;  // all arrays stay in the cache of the first level

template <class Run>
double nanoseconds(const Run& run) {
  double best = 1e9;
  for (int repetition = 0; repetition < 200; ++repetition) {
    const auto begin = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    best = std::min(best, time.count());
  }
  return 1e9 * best / static_cast<double>(count);
}

// Where a function is used: both formulas of those that have two, no overflow.
std::vector<double> arguments(const std::string& name, std::uint64_t seed) {
  const bool positive = name.starts_with("log") || name.find("pow") != std::string::npos || name == "sqrt";
  const bool unit = name == "asin" || name == "acos";
  const double low = positive ? 0.1 : (unit ? -1.0 : -3.0), high = unit ? 1.0 : 3.0;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> spread(low, high);
  std::vector<double> result(count);
  for (double& value : result) value = spread(random);
  return result;
}

double other([[maybe_unused]] const char* name, [[maybe_unused]] std::uint32_t set, [[maybe_unused]] const double* x,
             [[maybe_unused]] const double* y, [[maybe_unused]] double* out) {
#if defined(SPRINGNET_SLEEF_LOOPS)
  using namespace springnet::benchmark;
  const std::span<const SleefLoop> loops =
      set == SPRINGNET_AVX512 ? sleef_avx512() : (set == SPRINGNET_AVX2 ? sleef_avx2() : sleef_generic());
  for (const SleefLoop& loop : loops) {
    if (std::strcmp(loop.name, name) == 0) return nanoseconds([&] { loop.run(x, y, out, count); });
  }
#endif
  return 0.0;
}

}  // namespace

int main() {
  using namespace springnet::test;
#if !defined(SPRINGNET_SLEEF_LOOPS)
  std::printf(
      "SLEEF was not found when this program was configured (Debian: libsleef-dev): its columns are empty.\n\n");
#endif
  std::printf("| function |");
  const auto sets = instruction_sets();
  for (const std::uint32_t set : sets) {
    std::printf(" %s, ns | SLEEF, ns | ratio |",
                set == SPRINGNET_AVX512 ? "AVX-512" : (set == SPRINGNET_AVX2 ? "AVX2" : "SSE2"));
  }
  std::printf("\n|---|");
  for (std::size_t k = 0; k < sets.size(); ++k) std::printf("---|---|---|");
  std::printf("\n");
  for (std::size_t k = 0; k < generic_loops().size(); ++k) {
    const char* name = generic_loops()[k].name;
    const std::vector<double> x = arguments(name, 1), y = arguments("", 2);
    std::vector<double> out(count);
    std::printf("| %s |", name);
    for (const std::uint32_t set : sets) {
      const Loop& loop =
          set == SPRINGNET_AVX512 ? avx512_loops()[k] : (set == SPRINGNET_AVX2 ? avx2_loops()[k] : generic_loops()[k]);
      const double ours = nanoseconds([&] { loop.run(x.data(), y.data(), out.data(), count); });
      const double theirs = other(name, set, x.data(), y.data(), out.data());
      if (theirs > 0.0) {
        std::printf(" %.2f | %.2f | %.2f |", ours, theirs, ours / theirs);
      } else {
        std::printf(" %.2f | | |", ours);
      }
    }
    std::printf("\n");
    std::fflush(stdout);
  }
}
