#include "simulation/impact_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "constraints/least_on_way.hpp"

namespace springnet {
namespace {

// Times this near to each other are the same.
constexpr double roundings = 16.0;
// The way in so short a part of a step is the cubic through its ends: that errs there by 256^-4 of what it does over
// the step.
constexpr double shortest_part = 1.0 / 256.0;
constexpr double tenth_of_turn = 0.6;  // rad

}  // namespace

Engine::ImpactSearch::ImpactSearch(Engine& engine, const springnet_impact_search& search)
    : engine_(engine), search_(search), longest_(search.step_until - search.step_from) {
  for (const EventSource& source : engine.event_sources())
    if (source.kind == EventSource::Kind::touch) pairs_.push_back({source.index, source.surface, source.depth});
  const std::vector<Obstacle>& surfaces = engine.contact_.surfaces();
  double quickest = 0.0;  // rad/s
  for (const Obstacle& surface : surfaces) quickest = std::max(quickest, surface.swing_rate());
  // A table may turn a surface all the way round and have it rest at both ends.
  for (const double share : {0.0, 0.5, 1.0}) {
    const std::shared_ptr<const Placement> at = engine.placement(search.step_from + share * longest_);
    for (std::size_t j = 0; j < surfaces.size(); ++j)
      if (!surfaces[j].turns_in_place()) quickest = std::max(quickest, at->poses[j].spin.norm());
  }
  if (quickest > 0.0) longest_ = std::min(longest_, tenth_of_turn / quickest);
}

std::optional<Engine::ImpactSearch::Instant> Engine::ImpactSearch::instant(double time) {
  if (status_ != SPRINGNET_OK) return std::nullopt;
  const std::size_t n = engine_.layout_.node_count();
  Instant result{time, engine_.placement(time), std::vector<double>(6 * n)};
  double* const x = result.values.data();
  status_ = search_.state_at(search_.user, time, {x, x + n, x + 2 * n}, {x + 3 * n, x + 4 * n, x + 5 * n});
  if (status_ != SPRINGNET_OK) return std::nullopt;
  return result;
}

Vector3 Engine::ImpactSearch::position(const Instant& instant, std::uint32_t node) const {
  const std::size_t n = engine_.layout_.node_count();
  return {instant.values[node], instant.values[n + node], instant.values[2 * n + node]};
}

Vector3 Engine::ImpactSearch::velocity(const Instant& instant, std::uint32_t node) const {
  const std::size_t n = engine_.layout_.node_count();
  return {instant.values[3 * n + node], instant.values[4 * n + node], instant.values[5 * n + node]};
}

double Engine::ImpactSearch::value(const Instant& instant, const Pair& pair) const {
  return engine_.contact_.gap(*instant.at, pair.surface, position(instant, pair.node)) + pair.depth;
}

// Seen from the surface, Hermite's cubic through both ends leaves the straight way c by h (s (1-s)^2 (u0 - c) - s^2
// (1-s) (u1 - c)), where u are the velocities: by no more than 4/27 h (|u0 - c| + |u1 - c|). The way itself may bend
// twice as much, and the gap changes by no more than the place. In a short part the cubic is taken for the way.
bool Engine::ImpactSearch::comes_near(const Instant& from, const Instant& until, const Pair& pair,
                                      bool short_part) const {
  const double before = value(from, pair), after = value(until, pair);
  if (before <= 0.0) return false;  // it touched then, or is watched for from deeper on
  if (after <= 0.0) return true;
  const Obstacle& surface = engine_.contact_.surfaces()[pair.surface];
  const auto pose_of = [&](const Instant& instant) {
    Pose pose = instant.at->poses[pair.surface];
    pose.turns = pose.turns && !surface.turns_in_place();
    return pose;
  };
  const auto seen = [&](const Instant& instant, Vector3& place, Vector3& speed) {
    const Pose pose = pose_of(instant);
    const Vector3 x = position(instant, pair.node);
    place = pose.to_start(x);
    speed = velocity(instant, pair.node) - pose.velocity_at(x);
    if (pose.turns) speed = pose.rotation.transpose() * speed;
  };
  Vector3 a, b, u0, u1;
  seen(from, a, u0);
  seen(until, b, u1);
  const double h = until.time - from.time;
  const Vector3 way = b - a, bent0 = h * u0 - way, bent1 = h * u1 - way;
  const Pose pose = pose_of(from);
  const auto towards = [&](const Vector3& bent) {
    if (!surface.is_flat()) return bent.norm();
    const Vector3 n = surface.normal(pose, position(from, pair.node));
    return std::abs((pose.turns ? Vector3(pose.rotation.transpose() * n) : n).dot(bent));
  };
  const double bend = 2.0 * 4.0 / 27.0 * (towards(bent0) + towards(bent1));
  if (before + after - way.norm() > 2.0 * bend) return false;
  const auto gap = [&](double s) {
    Vector3 place = a + s * way;
    if (short_part) place += s * (1.0 - s) * ((1.0 - s) * bent0 - s * bent1);
    return surface.gap(pose, pose.from_start(place)) + pair.depth;
  };
  constexpr int turns = 30;  // to 5e-7 of the way, and the square of that in the gap
  const double least =
      std::min({before, after, least_on_way(gap, -std::numeric_limits<double>::infinity(), turns).value});
  return least <= (short_part ? 0.0 : bend);
}

std::optional<double> Engine::ImpactSearch::first(const Instant& from, const Instant& until,
                                                  const std::vector<Pair>& pairs, const Part& part) {
  const double length = until.time - from.time;
  if (until.time <= part.earliest || from.time >= part.latest) return std::nullopt;
  const bool swings = length > longest_, short_part = length < shortest_part * longest_;
  std::vector<Pair> near;
  bool crosses = false;
  for (const Pair& pair : pairs) {
    if (!swings && !comes_near(from, until, pair, short_part)) continue;
    near.push_back(pair);
    crosses = crosses || (value(from, pair) > 0.0 && value(until, pair) <= 0.0);
  }
  if (near.empty()) return std::nullopt;
  const double epsilon = roundings * std::numeric_limits<double>::epsilon();
  if (length <= epsilon * std::max(std::abs(until.time), search_.step_until - search_.step_from))
    return crosses ? std::optional(until.time) : std::nullopt;
  const std::optional<Instant> middle = instant(from.time + 0.5 * length);
  if (!middle) return std::nullopt;
  const std::optional<double> early = first(from, *middle, near, part);
  return early ? early : first(*middle, until, near, part);
}

// What goes deep enough is sought first, then where that began.
springnet_status Engine::ImpactSearch::find(double& time) {
  time = std::numeric_limits<double>::quiet_NaN();
  if (pairs_.empty()) return SPRINGNET_OK;
  const std::optional<Instant> start = instant(search_.step_from), end = instant(search_.step_until);
  if (!start || !end) return status_;
  std::vector<Pair> deep = pairs_;
  for (Pair& pair : deep) pair.depth += search_.depth;
  const std::optional<double> inside = first(*start, *end, deep, {search_.from, search_.until});
  const std::optional<Instant> then = inside ? instant(*inside) : std::nullopt;
  if (!then) return status_;
  std::vector<Pair> there;
  for (std::size_t i = 0; i < pairs_.size(); ++i)
    if (value(*then, deep[i]) <= 0.0) there.push_back(pairs_[i]);
  // No earlier than where another search found nothing: what it left is less deep.
  const std::optional<double> begins = first(*start, *then, there, {search_.step_from, *inside});
  if (status_ == SPRINGNET_OK) time = std::max(search_.from, begins.value_or(*inside));
  return status_;
}

springnet_status Engine::time_of_impact(const springnet_impact_search& search, double& time) {
  return ImpactSearch(*this, search).find(time);
}

}  // namespace springnet
