// What becomes of contacts at the committed time, outside of the events of an integrator: at the begin of a step, at a
// commit, and where what is prescribed jumps. SPRINGNET_RECOVERABLE and a message where no state fits.
#pragma once

#include <cstdint>
#include <set>

#include "simulation/model.hpp"

namespace springnet {

// Decides anew which nodes stick, slide or are free, as velocities and forces have it.
springnet_status settle_contacts(Model& model);
// Stops nodes that went behind an obstacle unseen.
springnet_status stop_penetration(Model& model);
// Puts prescribed nodes where they are right after the committed time. Where the velocity of one jumps, what is rigidly
// connected to it gets the impulses of the rods, as if no obstacle acted, and who moves the node their sum. Returns the
// clusters that got any.
std::set<std::uint32_t> follow_prescribed(Model& model);
// The same, and obstacles whose velocity jumps: they break contact where it jumps in the separating direction, strike
// nodes, or carry them on. from: s, the time committed before.
springnet_status follow_jumps(Model& model, double from);
// Fails where obstacles that move have closed on a node that they touch at `state`, which no step and no force can
// mend.
springnet_status check_room(Model& model, double time, const State& state);
// The same of nodes that are behind obstacles that they touch in the committed state, where no positions fit them all.
springnet_status find_squeezed(Model& model);
// Notes obstacles that left nodes behind because the velocity of their table jumps, once each: `noted` has those of
// before. Looks at events from `first_event` on; from: s, as above.
void note_shed(Model& model, std::size_t first_event, double from, std::set<std::size_t>& noted);

}  // namespace springnet
