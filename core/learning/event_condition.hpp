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

// Of a node where the part begins that an event ends.
struct StartGradient {
  Vector3 by_position = Vector3::Zero(), by_velocity = Vector3::Zero();
  double by_time = 0.0;
};

struct EventCondition {
  Eigen::VectorXd by_position, by_velocity;  // [3 node]
  double by_time = 0.0;
  Eigen::VectorXd by_acceleration;  // of nodes without constraints, [3 node]; empty: it does not matter
  Eigen::VectorXd by_values;        // by what is learned, in itself; empty: it does not matter
  Eigen::VectorXd by_internal;      // by internal states of laws
  StartGradient by_start;           // of the event's node
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

// How the value at the end of a slip, (slip at the end) . (direction of the slip at the start), changes with the start,
// where the node is at p with velocity v; of no importance unless the slip has turned.
[[nodiscard]] StartGradient direction_gradient(const Contact& contact, const Placement& start,
                                               const LocatedEvent& event, const Vector3& p, const Vector3& v,
                                               const Vector3& slip_at_end);
// Slip of the event's node, which touches that surface alone, m/s.
[[nodiscard]] Vector3 slip_of(const Contact& contact, const Placement& at, const LocatedEvent& event);

}  // namespace springnet::learning
