// What an event does to the state of its node, differentiated: where it is put on the surface, the impact, the rest of
// a slip. Of rigidly connected nodes: see cluster_event.hpp.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "constraints/contact.hpp"
#include "learning/step_parts.hpp"

namespace springnet::learning {

// Of positions of some nodes, and then of their velocities, [6 node].
struct EventJump {
  Eigen::MatrixXd by_state;              // by these, as the event found them
  Eigen::VectorXd by_time, by_friction;  // by the time of the event, by the friction of its surface
  Eigen::MatrixXd by_mass;               // [6 node][node]; empty: they do not matter
};

// None if no formula gives where the node was after the event, and its velocity: to 1e-5 of its speed, and of the way
// at that speed in a time step (s). at: at the time of the event.
[[nodiscard]] std::optional<EventJump> jump_of(const Contact& contact, const Placement& at, const LocatedEvent& event,
                                               double time_step);

}  // namespace springnet::learning
