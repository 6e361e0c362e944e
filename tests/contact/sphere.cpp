// A node that slides on spheres and capsules: the constrained motion says when it leaves.

#include <doctest/doctest.h>

#include <cmath>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double rounding = 1e-9;  // N: what a reaction may pull where it is zero

// How deep a node may be that a step has just let go, m: as far as the error of the flight takes it, until the flight,
// which leaves the surface with the third power of time, is farther away. Theta 1 falls g t h / 2 too far, which it
// makes up for in a time of the order of sqrt(h).
double depth(const Scheme& scheme, double h) { return scheme.order == 1.0 ? h * std::sqrt(h) : 2.0 * h * h * h; }

}  // namespace

TEST_CASE("on a sphere a node slides with the order of its integrator") {
  const Truth truth(on_sphere(), 2.7);
  for (const Scheme& scheme : stepping_schemes(1e-10)) {
    INFO(scheme.name);
    const Run coarse = follow(truth, scheme.integrator, 0.01), fine = follow(truth, scheme.integrator, 0.005);
    const double order = std::log2(coarse.error / fine.error);
    CAPTURE(coarse.error);
    CAPTURE(fine.error);
    CHECK(order > scheme.order - 0.2);
    CHECK(order < scheme.order + 0.5);
    CHECK(fine.released == 0);
    CHECK(fine.sink <= 1e-12);
  }
}

TEST_CASE("a node leaves a sphere once, where the closed form says, and no reaction pulls") {
  const Truth truth(on_sphere(), 3.0);
  const double release_time = sphere_release_time();
  for (const Scheme& scheme : stepping_schemes(1e-10)) {
    INFO(scheme.name);
    double error[2];
    for (const int halving : {0, 1}) {
      const double h = halving == 0 ? 0.004 : 0.002;
      const Run run = follow(truth, scheme.integrator, h);
      CHECK(run.released == 1);
      CHECK(run.touched == 1);
      // Theta 1 slides down the sphere late by its error before, 1.4 h at 0.8 m/s; then a step or two.
      CHECK(std::abs(run.time_of(Event::Kind::released) - release_time) <= (scheme.order == 1.0 ? 3.5 : 2.0) * h);
      CHECK(run.pull <= rounding);
      CHECK(run.sink <= depth(scheme, h));
      // A release that comes up to a step late leaves a velocity of the order of h^2 behind: second order goes on.
      CHECK(run.error <= (scheme.order == 1.0 ? 1.6 * h : 2.0 * h * h));
      error[halving] = run.error;
    }
    CHECK(std::log2(error[0] / error[1]) > scheme.order - 0.3);
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

TEST_CASE("nodes land on a sphere or a capsule, slide round it and leave it once") {
  struct Example {
    std::string name;
    Network net;
  };
  const Friction rough{Friction::Kind::coulomb, 0.2};
  const Example examples[] = {{"sphere", thrown_on_sphere(frictionless)},
                              {"sphere with friction", thrown_on_sphere(rough)},
                              {"capsule, side to end", thrown_on_capsule(frictionless)},
                              {"capsule, side to end, with friction", thrown_on_capsule(rough)}};
  for (const Example& example : examples) {
    const Truth truth(example.net, 1.2);
    const double release_time = truth.reference.time_of(Reference::Change::released);
    REQUIRE(truth.reference.events().size() == 2);
    for (const double tolerance : {1e-6, 1e-7, 1e-8, 1e-9}) {
      INFO(example.name << ", tolerance " << tolerance);
      const Run run = follow(truth, cvode(tolerance), 0.05);
      CHECK(run.error <= 200.0 * tolerance);
      if (tolerance <= 1e-7) {  // coarser, it may graze the surface once more within the tolerance
        CHECK(run.touched == 1);
        CHECK(run.released == 1);
      }
      CHECK(std::abs(run.time_of(Event::Kind::released) - release_time) <= 200.0 * tolerance);
      CHECK(run.pull <= rounding);
      CHECK(run.impulse_error <= 20.0 * tolerance);
    }
    for (const Scheme& scheme : stepping_schemes(1e-10)) {
      constexpr double h = 0.002;
      INFO(example.name << ": " << scheme.name);
      const Run run = follow(truth, scheme.integrator, h);
      // The touch falls within a step, at 1.7 m/s; what lands a step late flies off elsewhere.
      CHECK(run.error <= 2.5 * h);
      CHECK(run.touched == 1);
      CHECK(run.released == 1);
      CHECK(std::abs(run.time_of(Event::Kind::released) - release_time) <= 4.0 * h);
      CHECK(run.pull <= rounding);
      CHECK(run.sink <= depth(scheme, h));
    }
  }
}
