// A node that slides on spheres and capsules: the constrained motion says when it leaves.

#include <doctest/doctest.h>

#include <cmath>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double rounding = 1e-9;  // N: what a reaction may pull where it is zero

}  // namespace

TEST_CASE("on a sphere a node slides with the order of its integrator") {
  const Truth truth(on_sphere(), 2.7);
  for (const Way& way : stepping_ways(1e-10)) {
    INFO(way.name);
    const Run coarse = follow(truth, way.integrator, 0.01), fine = follow(truth, way.integrator, 0.005);
    const double order = std::log2(coarse.error / fine.error);
    CAPTURE(coarse.error);
    CAPTURE(fine.error);
    CHECK(order > way.order - 0.2);
    CHECK(order < way.order + 0.5);
    CHECK(fine.released == 0);
    CHECK(fine.sink <= 1e-12);
  }
}

TEST_CASE("the reference finds the release from a sphere to its tolerance") {
  const Truth truth(on_sphere(), 3.0);
  for (const double solver : {1.0, 2.0}) {
    for (const double tolerance : {1e-6, 1e-7, 1e-8, 1e-9}) {
      CAPTURE(tolerance);
      const Run run = follow(truth, cvode(tolerance, {{"linear_solver", solver}}), 0.1);
      CHECK(run.error <= 100.0 * tolerance);  // the start at 0.1 of the height grows tenfold
      CHECK(std::abs(run.time_of(Event::Kind::released) - sphere_release_time()) <= 100.0 * tolerance);
      CHECK(run.released == 1);
      CHECK(run.pull <= rounding);
    }
  }
}
