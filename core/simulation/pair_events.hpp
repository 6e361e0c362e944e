// Events of pairs of bodies, and the pairs that are about to have some.
#pragma once

#include <array>
#include <vector>

#include "constraints/pair_motion.hpp"
#include "simulation/model.hpp"

namespace springnet {

// m/s: of the point of a pair's first primitive.
[[nodiscard]] Vector3 first_velocity(const PairMotion& pair, const springnet_const_vectors& velocity);
// came: m/s, of that point before the event. impulse: N s, on the first.
void record_pair(Model& model, Event::Kind kind, double time, const PairMotion& pair,
                 const springnet_const_vectors& position, const Vector3& came, const Vector3& impulse);
// Whether a node that has weight can move; pairs of others are left to what moves them.
[[nodiscard]] bool can_move(const Model& model, const std::array<NodeIndex, 4>& nodes,
                            const std::array<double, 4>& weights);
// Pairs, some of whose nodes can move, that do not touch at the committed state, but whose gap is at most `gap` (m) at
// these positions. Throws as proximity::PairSearch::find.
[[nodiscard]] std::vector<proximity::NearPair> pairs_apart_within(Model& model, const springnet_const_vectors& position,
                                                                  double gap);

// Friction of a pair that touches keeps the direction in which it ends the whole slip of this state at one time, as
// Settling::keep_direction() has it for nodes; that of the slip itself where there is none.
void keep_direction_of_pair(Model& model, double time, const State& state, PairTouch& touching);

}  // namespace springnet
