// Events of pairs of bodies, and the pairs that are about to have some.
#pragma once

#include <vector>

#include "constraints/pair_motion.hpp"
#include "simulation/model.hpp"

namespace springnet {

// m/s: of the point of a pair's first primitive.
[[nodiscard]] Vector3 first_velocity(const PairMotion& pair, const springnet_const_vectors& velocity);
// came: m/s, of that point before the event. impulse: N s, on the first.
void record_pair(Model& model, Event::Kind kind, double time, const PairMotion& pair,
                 const springnet_const_vectors& position, const Vector3& came, const Vector3& impulse);
// Pairs that do not touch at the committed state, but whose gap is at most `gap` (m) at these positions. Throws as
// proximity::PairSearch::find.
[[nodiscard]] std::vector<proximity::NearPair> pairs_apart_within(Model& model, const springnet_const_vectors& position,
                                                                  double gap);

}  // namespace springnet
