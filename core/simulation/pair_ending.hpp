// The end of a step for bodies in contact, in every method that takes the user's steps: pairs that touch there approach
// no more, those that bounced into each other fly apart, and the pairs that go on touching are committed, with the
// events of the others.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "constraints/pair_rows.hpp"
#include "simulation/model.hpp"

namespace springnet {

// m. What gaps have to obey, and what iterations aim at.
struct PairTolerances {
  explicit PairTolerances(const Model& model);
  double gap, accuracy;

 private:
  PairTolerances(const Model& model, double contact_tolerance);
};

// Iterations after which the tolerance of gaps is enough, and after which there are no more.
inline constexpr int pair_patience = 60, most_pair_iterations = 2000;

// [node] 1/kg; 0: fixed or moved.
[[nodiscard]] std::vector<double> pair_mobility(const Model& model);
// A row without value and lever.
[[nodiscard]] PairRow row_of(const BodyContacts& bodies, proximity::PairKind kind, proximity::Pair pair,
                             const proximity::Separation& at);
// What obstacles let a node with this contact do at this position; false: anything.
[[nodiscard]] bool is_on_obstacle(const Model& model, const Placement& at, std::uint32_t node, const Touch& touch,
                                  const Vector3& position, OnObstacle& on);

struct EndingPair {
  PairRow row;
  Vector3 impulse = Vector3::Zero();  // N s, within the step
  bool bounced = false;               // within it
  bool touched = false;               // at its start
  double rebound = 0.0;               // m/s, at which they fly apart
};
using EndingPairs = std::map<std::pair<proximity::PairKind, proximity::Pair>, EndingPair>;

struct PairEnding {
  double until, length;  // s
  MovedNodes nodes;      // at the end
  springnet_const_vectors start_velocity;
  // Whether the impulse of a pair that touches all the time comes in two equal parts, within the step and at its end.
  bool in_halves;
  std::set<std::uint32_t> loose{};  // clusters that answer as if no obstacles held them
};
// SPRINGNET_RECOVERABLE, without a message, if iterations do not converge. pairs: with impulses within the step.
springnet_status end_pairs(Model& model, const PairEnding& step, EndingPairs pairs);

}  // namespace springnet
