// What an event does to the state of its node, differentiated: where it is put on the surface, the impact, the rest of
// a slip.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "constraints/contact.hpp"
#include "learning/step_parts.hpp"

namespace springnet::learning {

struct NodeJump {
  Eigen::Matrix<double, 6, 6> by_state = Eigen::Matrix<double, 6, 6>::Identity();  // of position and velocity
  Eigen::Matrix<double, 6, 1> by_time = Eigen::Matrix<double, 6, 1>::Zero();       // of the event
  Eigen::Matrix<double, 6, 1> by_friction = Eigen::Matrix<double, 6, 1>::Zero();   // of its surface
};

// None if no formula gives where the node was after the event, and its velocity: to 1e-5 of its speed, and of the way
// at that speed in a time step (s). at: at the time of the event.
[[nodiscard]] std::optional<NodeJump> jump_of(const Contact& contact, const Placement& at, const LocatedEvent& event,
                                              double time_step);

}  // namespace springnet::learning
