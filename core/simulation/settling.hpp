// What becomes of contacts at one moment: nodes that arrived at surfaces, were let go, slip or came to rest, with all
// that hangs on them rigidly.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "constraints/island.hpp"
#include "simulation/engine.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {

// What was found of a node.
struct Engine::Finding {
  std::vector<std::int32_t> touched, released;  // surfaces
  bool slips = false;                           // friction cannot hold it any more
  bool rests = false;                           // its slip has no speed left
};

class Engine::Settling {
 public:
  using Findings = std::map<std::uint32_t, Finding>;

  // Of the engine's contacts and of `state` at `time`, s.
  Settling(Engine& engine, double time, State& state, const Findings& findings);
  // A node with all that hangs rigidly on it, unless that was settled already.
  springnet_status settle(std::uint32_t node);
  // Velocities and lengths that fit again, where anything changed.
  springnet_status finish();
  // The slip of a node is about to end.
  void keep_direction(std::uint32_t node);

 private:
  [[nodiscard]] const Finding& finding(std::uint32_t node) const;
  void take_along();
  [[nodiscard]] std::vector<ContactNode> gather() const;
  // Adds the surfaces that a node touches, or may.
  void add_sides(ContactNode& node) const;
  // Where the gap of a node that was seen to meet a surface opens again by itself within what positions are uncertain
  // by: stopping it would take the motion that it has.
  [[nodiscard]] bool turns_round(std::uint32_t node, const ContactSide& side) const;
  // Accelerations without surfaces, at the present velocities.
  springnet_status accelerate(Island& island);
  // Whether a node touches again and again.
  [[nodiscard]] bool chatters(const Island& island);
  // What accelerations add to speeds in a few steps of a method with steps of its user's, m/s; 0: it has its own.
  [[nodiscard]] double fall_in_step(Island& island);
  // Speeds below are not resolved, because nodes that fall through the tolerance of touching have them, m/s.
  [[nodiscard]] double fall_to_touch(Island& island);
  // Speed from which nodes rebound, m/s.
  [[nodiscard]] double rebound_of(Island& island);
  bool stop_held(Island& island, double slow) const;
  // Impulses of the island change velocities.
  void strike(const Island& island);
  // Where no forces fit: what slips with friction comes to rest if it slips no faster than errors of integration or
  // rocking, and stays. A surface that holds a node in vain takes energy; friction of a pull gives some.
  springnet_status hold_on(Island& island, double negligible, std::vector<std::vector<Vector3>>& blows);
  // Whether and where nodes slip, from their velocities.
  void find_slips(Island& island) const;
  void begin_slips(Island& island) const;
  void take(const ContactNode& node);
  void part(std::uint32_t node, const ContactSide& side);
  // acceleration, and what of it is rounding: m/s^2.
  void find_phase(const ContactNode& node, const Vector3& acceleration, double negligible);
  void tell(Event::Kind kind, std::uint32_t node, std::int32_t surface, const Vector3& impulse = Vector3::Zero());

  Engine& engine_;
  double time_;
  State& state_;
  const Findings& findings_;
  std::shared_ptr<const Placement> at_;
  double depth_;                    // m
  double no_speed_;                 // m/s
  std::vector<std::uint8_t> done_;  // [cluster]
  std::vector<std::uint32_t> members_;
  std::optional<RigidConnections::WithoutContact> rods_;
  std::vector<std::uint32_t> contact_nodes_;
  std::vector<std::uint32_t> stopped_;
  Rebounds rebounds_;
  bool struck_ = false;
};

}  // namespace springnet
