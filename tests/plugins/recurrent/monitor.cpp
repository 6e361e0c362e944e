#include "monitor.hpp"

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include <doctest/doctest.h>

namespace {

using springnet::recurrent::Monitor;
using springnet::recurrent::Verdict;

struct End {
  Verdict verdict;
  std::uint64_t sweeps;
};

// Feeds difference(sweep), sweep = 1, 2, …, until the monitor has decided.
End run(double tolerance, std::uint64_t max_sweeps, const std::function<double(std::uint64_t)>& difference) {
  Monitor monitor(tolerance, max_sweeps);
  Verdict verdict = Verdict::go_on;
  while (verdict == Verdict::go_on) verdict = monitor.judge(difference(monitor.sweeps() + 1));
  return {verdict, monitor.sweeps()};
}

double geometric(double ratio, std::uint64_t sweep) { return std::pow(ratio, static_cast<double>(sweep)); }

}  // namespace

TEST_CASE("a contraction settles in the sweep that reaches the tolerance") {
  const End end = run(1e-6, 1000, [](std::uint64_t n) { return geometric(0.5, n); });
  CHECK(end.verdict == Verdict::settled);
  CHECK(end.sweeps == 20);  // 2^-20 is the first power below 1e-6
}

TEST_CASE("a difference equal to the tolerance has settled, even a tolerance of zero") {
  CHECK(run(0.25, 10, [](std::uint64_t) { return 0.25; }).verdict == Verdict::settled);
  CHECK(run(0.0, 10, [](std::uint64_t) { return 0.0; }).verdict == Verdict::settled);
}

TEST_CASE("the first sweep never settles") {
  const End end = run(1e-6, 1000, [](std::uint64_t) { return 0.0; });
  CHECK(end.verdict == Verdict::settled);
  CHECK(end.sweeps == 2);
}

TEST_CASE("a slow contraction runs until it settles or max_sweeps is reached") {
  // 0.999^n falls below 1e-6 at n = 13809; no window of 50 sweeps falls by more than 5 %.
  const End end = run(1e-6, 100000, [](std::uint64_t n) { return geometric(0.999, n); });
  CHECK(end.verdict == Verdict::settled);
  CHECK(end.sweeps == 13809);
  CHECK(run(1e-6, 1000, [](std::uint64_t n) { return geometric(0.999, n); }).verdict == Verdict::out_of_sweeps);
}

TEST_CASE("a contraction whose differences beat does not count as an oscillation") {
  // A complex pair of eigenvalues: the differences rise for many sweeps in each beat.
  const End end = run(1e-6, 2000, [](std::uint64_t n) {
    return geometric(0.97, n) * (1.0 + 0.9 * std::sin(0.13 * static_cast<double>(n)));
  });
  CHECK(end.verdict == Verdict::settled);
}

TEST_CASE("a contraction after a transient growth settles") {
  // Ten sweeps of growth by half before the contraction begins, as non-normal iterations show.
  const End end = run(1e-6, 1000, [](std::uint64_t n) {
    return n <= 10 ? geometric(1.5, n) : geometric(1.5, 10) * geometric(0.8, n - 10);
  });
  CHECK(end.verdict == Verdict::settled);
}

TEST_CASE("differences that neither fall nor grow oscillate") {
  CHECK(run(1e-6, 1000, [](std::uint64_t) { return 1.0; }).verdict == Verdict::oscillating);
  CHECK(run(1e-6, 1000, [](std::uint64_t n) { return n % 2 == 0 ? 1.0 : 3.0; }).verdict == Verdict::oscillating);
  // A cycle longer than a window.
  CHECK(run(1e-6, 1000, [](std::uint64_t n) { return n % 60 == 0 ? 0.1 : 1.0; }).verdict == Verdict::oscillating);
}

TEST_CASE("an oscillation is not detected in fewer sweeps than a window has") {
  const End end = run(1e-6, 20, [](std::uint64_t) { return 1.0; });
  CHECK(end.verdict == Verdict::out_of_sweeps);
  CHECK(end.sweeps == 20);
}

TEST_CASE("growth, fast or slow, is detected long before the numbers overflow") {
  const End fast = run(1e-6, 1000, [](std::uint64_t n) { return geometric(10.0, n); });
  CHECK(fast.verdict == Verdict::diverging);
  CHECK(fast.sweeps < 20);
  CHECK(run(1e-6, 1000, [](std::uint64_t n) { return geometric(1.3, n); }).verdict == Verdict::diverging);
  CHECK(run(1e-6, 1000, [](std::uint64_t n) { return geometric(1.02, n); }).verdict == Verdict::diverging);
}

TEST_CASE("a difference that is not finite counts as divergence in every sweep, also the first") {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const End first = run(1e-6, 1000, [bad](std::uint64_t) { return bad; });
    CHECK(first.verdict == Verdict::diverging);
    CHECK(first.sweeps == 1);
    const End later = run(1e-6, 1000, [bad](std::uint64_t n) { return n < 7 ? 1.0 : bad; });
    CHECK(later.verdict == Verdict::diverging);
    CHECK(later.sweeps == 7);
  }
}
