// First meetings beside two oracles: dense sampling of the distance, for pairs of all shapes that move in all ways, and
// exact integers, for motions in which one primitive moves and the other rests.
#include "proximity/first_meeting.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "random_pairs.hpp"

using namespace springnet;
using namespace springnet::proximity;

namespace {

Corners between(const Corners& start, const Corners& end, double time) {
  Corners x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = start[i] + time * (end[i] - start[i]);
  return x;
}

// What the distance is watched against, as first_meeting.hpp says, and how far it may be above that.
struct Watched {
  double distance, tolerance;
};

double extent_of(PairKind kind, const Corners& start, const Corners& end) {
  double extent = 0.0;
  for (int i = 0; i < first_nodes(kind); ++i)
    for (int j = first_nodes(kind); j < count_of(kind); ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const Vector3 before = start[a] - start[b], after = end[a] - end[b];
      extent = std::max({extent, before.cwiseAbs().maxCoeff(), (after - before).cwiseAbs().maxCoeff()});
    }
  return extent;
}

Watched watched(PairKind kind, const Corners& start, const Corners& end, double thickness) {
  const double least = 1e-12 * extent_of(kind, start, end), first = separation(kind, start).distance;
  const double tolerance = std::max(1e-4 * thickness, least);
  if (first > thickness + tolerance) return {thickness, tolerance};
  return {kept_share * first, std::max(1e-4 * kept_share * first, least)};
}

// The least distance before `until`, by samples and a search around the least of them.
double least_before(PairKind kind, const Corners& start, const Corners& end, double until) {
  constexpr int samples = 200;
  const auto distance = [&](double time) { return separation(kind, between(start, end, time)).distance; };
  double least = std::numeric_limits<double>::infinity();
  int place = 0;
  for (int i = 0; i < samples; ++i)
    if (const double now = distance(until * i / samples); now < least) {
      least = now;
      place = i;
    }
  double low = until * std::max(place - 1, 0) / samples, high = until * std::min(place + 1, samples) / samples;
  high = std::min(high, std::nextafter(until, 0.0));
  for (int i = 0; i < 40 && low < high; ++i) {
    const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
    const double at_a = distance(a), at_b = distance(b);
    least = std::min({least, at_a, at_b});
    (at_a < at_b ? high : low) = at_a < at_b ? b : a;
  }
  return least;
}

struct Case {
  PairKind kind;
  Corners start, end;
  double thickness;
};

// Ways to move: 0 anywhere; 1 closest points meet at a time; 2 they pass at a distance near the thickness; 3 a long
// way; 4 a short one; 5 within the plane of shape 2, or on the grid; 6 one primitive turns about the middle of its own.
Case random_case(PairDice& dice, int round) {
  Case made;
  made.kind = pair_kinds[static_cast<std::size_t>(round % 3)];
  const int shape = round / 3 % PairDice::shapes, way = round / 3 / PairDice::shapes % 7;
  made.start = dice.corners(shape);
  made.thickness = dice.whole(0, 2) == 0 ? 0.0 : std::pow(10.0, dice.number(-5.0, -1.0));
  for (std::size_t i = 0; i < 4; ++i) {
    const double size = way == 3 ? 100.0 : way == 4 ? 1e-3 : 1.0;
    made.end[i] = made.start[i] + (way == 5 ? dice.grid_vector(2) : dice.vector(size));
    if (way == 5 && shape == 2) made.end[i].z() = made.start[i].z();
  }
  if (way == 1 || way == 2) {
    // The first primitive is moved so that points of both meet at `time`, or pass at about the thickness.
    const double time = dice.number(0.05, 1.0);
    const auto weights = dice.weights(made.kind);
    Vector3 offset = Vector3::Zero();
    const Corners then = between(made.start, made.end, time);
    for (std::size_t i = 0; i < 4; ++i) offset += weights[i] * then[i];
    if (way == 2) offset -= dice.vector(1.0).normalized() * made.thickness * (1.0 + dice.number(-1e-3, 1e-3));
    for (int i = 0; i < first_nodes(made.kind); ++i) made.end[static_cast<std::size_t>(i)] -= offset / time;
  }
  if (way == 6) {
    const int first = first_nodes(made.kind), second = second_nodes(made.kind);
    Vector3 middle = Vector3::Zero();
    for (int j = first; j < first + second; ++j) middle += made.start[static_cast<std::size_t>(j)] / second;
    // The first comes close to the middle and stays there, while the second turns over.
    for (int i = 0; i < first; ++i) {
      const auto k = static_cast<std::size_t>(i);
      made.start[k] = middle + (made.start[k] - middle) * 0.01 + dice.vector(made.thickness);
      made.end[k] = made.start[k] + dice.vector(1e-3);
    }
    for (int j = first; j < first + second; ++j) {
      const auto k = static_cast<std::size_t>(j);
      made.end[k] = 2.0 * middle - made.start[k] + dice.vector(0.3);
    }
  }
  return made;
}

}  // namespace

TEST_CASE("no meeting is missed, and none is reported that is none, beside dense samples") {
  PairDice dice(3);
  int meetings = 0, from_start = 0, within = 0;
  for (int round = 0; round < 126000; ++round) {
    const Case made = random_case(dice, round);
    const Watched level = watched(made.kind, made.start, made.end, made.thickness);
    const auto met = first_meeting(made.kind, made.start, made.end, made.thickness);
    const double extent = extent_of(made.kind, made.start, made.end);
    const int shape = round / 3 % PairDice::shapes;
    // Distances of samples are rounded: far from the origin, by the coordinates there.
    const double rounding = 1e-14 * extent + (shape == 5 ? 3e-12 : 1e-15);
    CAPTURE(round);
    if (met && met->from_start) {
      ++from_start;
      CHECK(met->time == 0.0);
      CHECK(separation(made.kind, made.start).distance <= 2e-12 * extent + rounding);
      continue;
    }
    within += level.distance < made.thickness;
    const double until = met ? met->time : 1.0;
    CHECK(least_before(made.kind, made.start, made.end, until) > level.distance - rounding);
    if (!met) continue;
    ++meetings;
    const double then = separation(made.kind, between(made.start, made.end, met->time)).distance;
    CHECK(std::abs(then - met->at.distance) <= rounding);
    // Degenerate primitives: 1e-9 of the extent, as the header says.
    CHECK(then <= level.distance + std::max(level.tolerance, 1e-9 * extent) + rounding);
  }
  CHECK(meetings > 30000);
  CHECK(from_start > 1000);
  CHECK(within > 1000);
}
