// Turns over time, against closed forms.
#include <limits>

#include <doctest/doctest.h>

#include "network/turning.hpp"

#include "not_finite.hpp"

using springnet::Motion;
using springnet::Turn;
using springnet::Turning;
using springnet::testing::inf;

namespace {

void check(const Turning::Sample& sample, double angle, double rate, double acceleration) {
  // Rounding of a few operations on numbers up to 10.
  CHECK(std::abs(sample.angle - angle) <= 1e-14);
  CHECK(std::abs(sample.rate - rate) <= 1e-14);
  CHECK(std::abs(sample.acceleration - acceleration) <= 1e-14);
}

}  // namespace

TEST_CASE("without a turn the angle is zero") {
  const Turning rests;
  CHECK_FALSE(rests.turns());
  for (const double time : {-inf, -1.0, 0.0, 1e9}) check(rests.at(time), 0, 0, 0);
  CHECK(rests.next_change(0) == inf);
}

TEST_CASE("a constant rate within a window") {
  Turn turn;
  turn.rate = -2.5;
  turn.from = 1;
  turn.until = 3;
  const Turning turning(turn);
  CHECK(turning.turns());
  check(turning.at(0.5), 0, 0, 0);
  check(turning.at(1), 0, -2.5, 0);
  check(turning.at(2.5), -3.75, -2.5, 0);
  check(turning.at(3), -5, 0, 0);  // just after: it has stopped
  check(turning.at(9), -5, 0, 0);
  CHECK(turning.next_change(0) == 1);
  CHECK(turning.next_change(1) == 3);
  CHECK(turning.next_change(3) == inf);

  turn.until = inf;
  const Turning on_and_on(turn);
  check(on_and_on.at(4), -7.5, -2.5, 0);
  CHECK(on_and_on.next_change(1) == inf);
}

TEST_CASE("a table of angles: straight, and 3 s^2 - 2 s^3 between two entries") {
  Turn turn;
  turn.times = {2, 4};
  turn.angles = {1, 5};
  const Turning smooth(turn);
  CHECK(smooth.turns());
  for (const double s : {0.0, 0.25, 0.9}) {
    check(smooth.at(2 + 2 * s), 1 + (3 * s * s - 2 * s * s * s) * 4, (6 * s - 6 * s * s) * 2, (6 - 12 * s));
  }
  check(smooth.at(1), 1, 0, 0);
  check(smooth.at(4), 5, 0, 0);
  turn.interpolation = Motion::Interpolation::linear;
  const Turning linear(turn);
  check(linear.at(2.5), 2, 2, 0);
  CHECK(linear.next_change(0) == 2);
  CHECK(linear.next_change(2) == 4);
  CHECK(linear.next_change(4) == inf);
}
