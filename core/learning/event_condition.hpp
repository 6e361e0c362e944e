// What determines the time of an event, differentiated: its value (see ContactEvents), which is 0 then.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include <Eigen/Core>

#include "constraints/contact.hpp"
#include "learning/step_parts.hpp"

namespace springnet::learning {

struct EventCondition {
  Eigen::VectorXd by_position, by_velocity;  // [3 node]
  double by_time = 0.0;
  Eigen::VectorXd by_acceleration;  // of nodes without constraints, [3 node]; empty: it does not matter
  Eigen::VectorXd by_values;        // by what is learned, in itself; empty: it does not matter
  Eigen::VectorXd by_internal;      // by internal states of laws
};

// The value of an event of a node, by its own position, velocity and acceleration without constraints, and by time.
struct NodeCondition {
  Vector3 by_position = Vector3::Zero(), by_velocity = Vector3::Zero(), by_acceleration = Vector3::Zero();
  double by_time = 0.0;
  double by_friction = 0.0;  // of the surface
};
// A time, s, with the surfaces there; `placed` has them at others, and `shortest`, s, is far below their motion.
struct PlacedTime {
  double time, shortest;
  std::function<std::shared_ptr<const Placement>(double)> placed;
};
// acceleration: without constraints, m/s^2. None of an event that is not differentiated.
[[nodiscard]] std::optional<NodeCondition> condition_of(const Contact& contact, const PlacedTime& at,
                                                        const LocatedEvent& event, const Vector3& acceleration);

}  // namespace springnet::learning
