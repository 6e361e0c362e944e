// Decides contacts at one moment: of nodes that arrived at obstacles, separate, slip or came to rest, island by island:
// a node, or all nodes that rigid connections join.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "constraints/island.hpp"
#include "simulation/model.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {

// What an integrator found out about a node.
struct Finding {
  std::vector<std::int32_t> touched, released;  // surfaces
  bool slips = false;                           // sticking friction cannot hold it any more
  bool rests = false;                           // its slip has come to an end
};

using Findings = std::map<std::uint32_t, Finding>;  // by node

// Decides the contacts of these nodes, and of what is rigidly connected to them, at `time` (s); `state` changes with
// them.
springnet_status settle(Model& model, double time, State& state, const Findings& findings);

class Settling {
 public:
  Settling(Model& model, double time, State& state, const Findings& findings);
  // The island of a node, unless it was settled already.
  springnet_status settle(std::uint32_t node);
  // Makes velocities and lengths fit again, where anything changed.
  springnet_status finish();
  // The slip of a node is about to end: friction keeps a direction from now on.
  void keep_direction(std::uint32_t node);

 private:
  [[nodiscard]] const Finding& finding(std::uint32_t node) const;
  void take_along();
  [[nodiscard]] std::vector<ContactNode> gather() const;
  // Adds the obstacles that a node touches, or may touch now.
  void add_sides(ContactNode& node) const;
  // Separating, or comes to rest within the position tolerance: an impact would take the motion that the node has.
  [[nodiscard]] bool turns_round(std::uint32_t node, const ContactSide& side) const;
  // Accelerations without obstacles, at the present velocities.
  springnet_status accelerate(Island& island);
  // True once a node has touched too often in a short time; counts the touches.
  [[nodiscard]] bool chatters(const Island& island);
  // What accelerations add to speeds in a few of the user's steps, m/s; 0: the integrator chooses its own steps.
  [[nodiscard]] double fall_in_step(Island& island);
  // Speed that nodes gain while they fall through the contact tolerance; slower motions are not resolved, m/s.
  [[nodiscard]] double fall_to_touch(Island& island);
  // Nodes that arrive faster rebound, m/s.
  [[nodiscard]] double rebound_of(Island& island);
  bool stop_held(Island& island, double slow) const;
  // Impulses of the island change velocities.
  void strike(const Island& island);
  // Where no forces fit: slips with friction that are no faster than errors of integration, or rocking, come to rest
  // and stick. An obstacle that holds a node in vain takes energy; friction of a pulling contact would add some.
  springnet_status hold_on(Island& island, double negligible, std::vector<std::vector<Vector3>>& blows);
  // Which nodes slip, and where to, from their velocities.
  void find_slips(Island& island) const;
  void begin_slips(Island& island) const;
  void take(const ContactNode& node);
  void part(std::uint32_t node, const ContactSide& side);
  // acceleration, and its rounding: m/s^2.
  void find_phase(const ContactNode& node, const Vector3& acceleration, double negligible);

  Model& model_;
  double time_;
  State& state_;
  const Findings& findings_;
  std::shared_ptr<const Placement> at_;
  double depth_;                    // m
  double no_speed_;                 // m/s
  double jump_;                     // m/s: a smaller jump of an obstacle's velocity is an error of integration
  std::vector<std::uint8_t> done_;  // [cluster]
  std::vector<std::uint32_t> members_;
  std::optional<RigidConnections::WithoutContact> rods_;
  std::vector<std::uint32_t> contact_nodes_;
  std::vector<std::uint32_t> stopped_;
  Rebounds rebounds_;
  bool struck_ = false;
};

}  // namespace springnet
