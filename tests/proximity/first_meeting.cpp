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
  double aimed = 2.0;  // time at which they meet for certain; beyond the step if that is not known
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
    if (way == 1 && shape != 5) made.aimed = time;  // far from the origin they miss each other by the rounding there
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

// Exact: whether the segment from p by `path` meets the triangle, edges and corners included. Whole numbers below 100,
// so that products of three fit many times over.
using Whole = std::array<std::int64_t, 3>;
Whole operator-(const Whole& a, const Whole& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Whole cross(const Whole& a, const Whole& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::int64_t dot(const Whole& a, const Whole& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
bool is_zero(const Whole& a) { return a[0] == 0 && a[1] == 0 && a[2] == 0; }

bool is_on_segment(const Whole& p, const Whole& a, const Whole& b) {
  return is_zero(cross(b - a, p - a)) && dot(p - a, p - b) <= 0;
}

bool segments_meet(const Whole& a, const Whole& b, const Whole& c, const Whole& d) {
  if (is_on_segment(a, c, d) || is_on_segment(b, c, d) || is_on_segment(c, a, b) || is_on_segment(d, a, b)) return true;
  const Whole normal = cross(b - a, d - c);
  if (is_zero(normal) || dot(normal, c - a) != 0) return false;  // parallel, or not in one plane
  const auto side = [&](const Whole& p, const Whole& q, const Whole& r) { return dot(cross(q - p, r - p), normal); };
  return (side(a, b, c) > 0) != (side(a, b, d) > 0) && (side(c, d, a) > 0) != (side(c, d, b) > 0);
}

bool is_in_triangle(const Whole& p, const Whole& a, const Whole& b, const Whole& c) {
  const Whole normal = cross(b - a, c - a);
  if (is_zero(normal)) return is_on_segment(p, a, b) || is_on_segment(p, b, c) || is_on_segment(p, c, a);
  if (dot(normal, p - a) != 0) return false;
  return dot(cross(b - a, p - a), normal) >= 0 && dot(cross(c - b, p - b), normal) >= 0 &&
         dot(cross(a - c, p - c), normal) >= 0;
}

bool meets_triangle(const Whole& p, const Whole& q, const Whole& a, const Whole& b, const Whole& c) {
  if (is_in_triangle(p, a, b, c) || is_in_triangle(q, a, b, c)) return true;
  if (segments_meet(p, q, a, b) || segments_meet(p, q, b, c) || segments_meet(p, q, c, a)) return true;
  const Whole normal = cross(b - a, c - a), path = q - p;
  const std::int64_t from = dot(normal, p - a), to = dot(normal, q - a);
  if ((from > 0 && to > 0) || (from < 0 && to < 0) || from == to) return false;
  // Through the inside: the volumes with the three edges have one sign.
  const std::int64_t u = dot(path, cross(a - p, b - p)), v = dot(path, cross(b - p, c - p)),
                     w = dot(path, cross(c - p, a - p));
  return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

Vector3 real(const Whole& a) {
  return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
}

}  // namespace

TEST_CASE("motions of whole numbers meet exactly where integers say so") {
  PairDice dice(4);
  const auto whole = [&](int size) -> Whole {
    return {dice.whole(-size, size), dice.whole(-size, size), dice.whole(-size, size)};
  };
  int met = 0, passed = 0, touching = 0;
  for (int round = 0; round < 150000; ++round) {
    const PairKind kind = round % 2 == 0 ? PairKind::node_triangle : PairKind::edge_edge;
    const int size = round / 2 % 2 == 0 ? 2 : 6;
    const std::array<Whole, 4> x{whole(size), whole(size), whole(size), whole(size)};
    const Whole path = whole(size), common = whole(3);
    Corners start, end;
    for (std::size_t i = 0; i < 4; ++i) {
      start[i] = real(x[i]);
      end[i] = start[i] + real(common);
      if (static_cast<int>(i) < first_nodes(kind)) end[i] += real(path);
    }
    const Whole moved{x[0][0] + path[0], x[0][1] + path[1], x[0][2] + path[2]};
    bool meets = false, meets_now = false;
    if (kind == PairKind::node_triangle) {
      meets_now = is_in_triangle(x[0], x[1], x[2], x[3]);
      meets = meets_now || meets_triangle(x[0], moved, x[1], x[2], x[3]);
    } else {
      // The edge sweeps a parallelogram, of two triangles.
      const Whole other{x[1][0] + path[0], x[1][1] + path[1], x[1][2] + path[2]};
      meets_now = segments_meet(x[0], x[1], x[2], x[3]);
      meets =
          meets_now || meets_triangle(x[2], x[3], x[0], x[1], other) || meets_triangle(x[2], x[3], x[0], other, moved);
    }
    CAPTURE(round);
    const auto found = first_meeting(kind, start, end, 0.0);
    CHECK(found.has_value() == meets);
    // The tolerance of 1e-12 is far below the distances of whole numbers that do not meet, 1e-3 here.
    if (found) CHECK(found->from_start == meets_now);
    if (found && !meets_now) CHECK(found->at.distance <= 1e-10);
    touching += meets_now;
    met += meets && !meets_now;
    passed += !meets;
  }
  CHECK(met > 5000);
  CHECK(passed > 50000);
  CHECK(touching > 1000);
}

TEST_CASE("times of meetings in closed form") {
  // Balls: |d + v t| = r, in long double.
  PairDice dice(5);
  int met = 0;
  for (int round = 0; round < 20000; ++round) {
    const Vector3 a = dice.vector(1.0), b = dice.vector(1.0);
    const Vector3 v = dice.number(0.5, 2.0) * (b - a) + dice.vector(0.3);
    const double thickness = dice.number(0.05, 0.3);
    const auto found = first_meeting(PairKind::node_node, {a, b, a, a}, {a + v, b, a, a}, thickness);
    const auto square = [](const Vector3& p, const Vector3& q) {
      long double sum = 0.0L;
      for (int i = 0; i < 3; ++i) sum += static_cast<long double>(p[i]) * q[i];
      return sum;
    };
    const Vector3 d = a - b;
    if (d.norm() < thickness * 1.01) continue;  // in contact at the start
    const long double vv = square(v, v), dv = square(d, v),
                      c = square(d, d) - thickness * static_cast<long double>(thickness);
    const long double root = dv * dv - vv * c;
    if (std::abs(static_cast<double>(root)) < 1e-2) continue;  // it grazes: the time is ill-conditioned
    const long double time = (-dv - std::sqrt(std::max(root, 0.0L))) / vv;
    const bool meets = root > 0.0L && time >= 0.0L && time <= 1.0L;
    if (root > 0.0L && std::abs(static_cast<double>(time - 1.0L)) < 1e-2) continue;
    CHECK(found.has_value() == meets);
    if (!found || !meets) continue;
    ++met;
    CHECK(found->time <= static_cast<double>(time));
    // 1e-4 of the thickness early, at an approach of sqrt(root) / thickness >= 0.1 / 0.3
    CHECK(found->time >= static_cast<double>(time) - 1e-4 * thickness * thickness / 0.1);
  }
  CHECK(met > 2000);
  // A node falls through a triangle at a third of the step, and a hundred thicknesses beyond.
  const Vector3 p(0.2, 0.2, 1.0), q(0.2, 0.2, -2.0), a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  CHECK(first_meeting(PairKind::node_triangle, {p, a, b, c}, {q, a, b, c}, 0.0)->time ==
        doctest::Approx(1.0 / 3.0).epsilon(1e-11));
  CHECK(first_meeting(PairKind::node_triangle, {p, a, b, c}, {q, a, b, c}, 0.02)->time ==
        doctest::Approx(0.98 / 3.0).epsilon(1e-5));
}

TEST_CASE("a pair in contact may separate, slide and approach, but not go through") {
  const Vector3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto meet = [&](const Vector3& from, const Vector3& to) {
    return first_meeting(PairKind::node_triangle, {from, a, b, c}, {to, a, b, c}, 0.1);
  };
  CHECK(!meet({0.2, 0.2, 0.05}, {0.2, 0.2, 0.4}));
  CHECK(!meet({0.2, 0.2, 0.1}, {0.2, 0.2, 0.4}));
  CHECK(!meet({0.2, 0.2, 0.1}, {0.5, 0.2, 0.1}));
  CHECK(!meet({0.2, 0.2, 0.08}, {0.2, 0.2, 0.06}));
  CHECK(meet({0.2, 0.2, 0.08}, {0.2, 0.2, -0.06}));
  CHECK(!meet({0.2, 0.2, 0.08}, {0.2, 0.2, -0.06})->from_start);
  CHECK(meet({0.2, 0.2, 0.08}, {0.2, 0.2, 0.03})->at.distance == doctest::Approx(0.04).epsilon(1e-4));
  CHECK(meet({0.2, 0.2, 0.0}, {0.2, 0.2, 0.3})->from_start);  // on which side?
  // Positions that are not finite meet nothing; the search for pairs refuses them.
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  CHECK(!meet({nan, 0.2, 0.08}, {0.2, 0.2, 0.06}));
  CHECK(!meet({0.2, 0.2, 0.08}, {0.2, infinity, 0.06}));
}

TEST_CASE("no meeting is missed, and none is reported that is none, beside dense samples") {
  PairDice dice(3);
  int meetings = 0, from_start = 0, within = 0, aimed = 0;
  for (int round = 0; round < 126000; ++round) {
    const Case made = random_case(dice, round);
    const Watched level = watched(made.kind, made.start, made.end, made.thickness);
    const auto met = first_meeting(made.kind, made.start, made.end, made.thickness);
    const double extent = extent_of(made.kind, made.start, made.end);
    const int shape = round / 3 % PairDice::shapes;
    // Distances of samples are rounded: far from the origin, by the coordinates there.
    const double rounding = 1e-13 * extent + (shape == 5 ? 3e-12 : 1e-15);
    CAPTURE(round);
    if (met && met->from_start) {
      ++from_start;
      CHECK(met->time == 0.0);
      CHECK(separation(made.kind, made.start).distance <= 2e-12 * extent + rounding);
      continue;
    }
    if (made.aimed <= 1.0 && level.distance == made.thickness) {
      // Without thickness, samples would see nothing of it: what passes through is at distance 0 for no time.
      ++aimed;
      REQUIRE(met.has_value());
      CHECK(met->time <= made.aimed + 1e-14);  // nodes are aimed up to rounding
    }
    within += level.distance < made.thickness;
    const double until = met ? met->time : 1.0;
    CHECK(least_before(made.kind, made.start, made.end, until) > level.distance - rounding);
    if (!met) continue;
    ++meetings;
    const double then = separation(made.kind, between(made.start, made.end, met->time)).distance;
    CHECK(std::abs(then - met->at.distance) <= rounding);
    CHECK(then <= level.distance + level.tolerance + rounding);
  }
  CHECK(meetings > 30000);
  CHECK(aimed > 5000);
  CHECK(from_start > 1000);
  CHECK(within > 1000);
}
