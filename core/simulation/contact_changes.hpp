// Changes of contacts at the committed time, beside the events of an integrator: at the beginning of a step, at a
// commit, and where a prescribed motion jumps. Statuses: SPRINGNET_RECOVERABLE and a message if no state satisfies the
// contacts.
#pragma once

#include <cstdint>
#include <set>

#include "simulation/model.hpp"

namespace springnet {

// Decides anew which nodes stick, slide or are free, from velocities and forces.
springnet_status settle_contacts(Model& model);
// Stops nodes that got behind an obstacle without an event.
springnet_status stop_penetration(Model& model);
// Sets prescribed nodes to their motion right after the committed time. If the velocity of one jumps, the nodes rigidly
// connected to it get the impulses of the rods, as if there were no obstacles, and the reaction on the node their sum.
// Returns the clusters that got any.
std::set<std::uint32_t> follow_prescribed(Model& model);
struct Followed {
  springnet_status status;
  bool pulled;  // rigidly connected nodes were carried along
};
// The same, and obstacles whose velocity jumps: they break contact if it jumps in the separating direction; otherwise
// they strike nodes, or carry them on. from: s, the time committed before. leave_told: not those of obstacles whose
// motion the embedding program told, for the sweeps of the coming step decide their contacts.
Followed follow_jumps(Model& model, double from, bool leave_told);
// Fails if moving obstacles have closed on a node that they touch at `state`: no step and no force resolves that.
springnet_status check_room(Model& model, double time, const State& state);
// The same for the committed state: fails if a node is behind an obstacle that it touches.
springnet_status find_squeezed(Model& model);
// Notes, once each, obstacles that separated from nodes because the velocity of their table jumps: `noted` has the
// earlier ones. Reads events from `first_event` on; from: s, as above.
void note_left_behind(Model& model, std::size_t first_event, double from, std::set<std::size_t>& noted);

}  // namespace springnet
