// Contact in a step of velocity Verlet, where forces are known at the two ends of the step alone. What touches a
// surface goes, with all that hangs on it rigidly, by RATTLE with one-sided constraints: with h the step, F and F' the
// forces at its ends, W the inverse masses,
//
//   drift   u = v + W (h/2 F + J),    P = p + h u,    lengths(P) = l,    gaps(P) >= 0,
//   kick    V = u + W (h/2 F' + K),   rates of lengths = 0,   rates of gaps >= 0,
//
// J along the directions at p, K along those at P; a surface gives an impulse only where its gap, or the rate of that,
// is zero, and never pulls. Friction is in Coulomb's cone, in the drift against the slip at p, in the kick against the
// slip that is left. So a surface lets a node go where the node's way without it ends outside, whatever it does to the
// reaction that the step crosses the end of a face, or the place where the force turns: decided once per step.
// Andersen, J. Comput. Phys. 52 (1983) 24; Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235.
//
// A touch is an impulse, Newton's and Coulomb's, between drift and kick. A lone node's is put where its way meets the
// surface, so that only what hangs rigidly on others loses a part of a step at each touch.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "constraints/island.hpp"
#include "simulation/engine.hpp"

namespace springnet {

class Engine::Stepping {
 public:
  // Of the committed state, in a step of this length (s). `last`: the step before, or null.
  Stepping(Engine& engine, double until, double length, const Stepping* last);
  // step.next_position, next_velocity: P and u as if there were no contact, changed where there is; step.force: F, N.
  springnet_status drift(const springnet_sweep& step);
  // Whether a kick is to come, of the step between these times, s.
  [[nodiscard]] bool is_of(double from, double until) const noexcept {
    return !kicked_ && from == from_ && until == until_;
  }
  // step.next_velocity: V, which is replaced for what touches; step.force: F' at P, N. Contacts become what they are
  // at the end of the step.
  springnet_status kick(const springnet_sweep& step);

 private:
  struct Member {
    std::uint32_t node;
    bool fixed;
    Vector3 start, start_velocity;             // m, m/s
    Vector3 half = Vector3::Zero();            // m/s: what the force adds in half a step
    Vector3 velocity, position;                // u, P, then V; m/s, m
    Vector3 place = Vector3::Zero();           // of one that is fixed or moved, m
    Vector3 place_velocity = Vector3::Zero();  // m/s, likewise
  };
  struct Side {
    std::int32_t surface;
    bool is_new = false;
    bool touches = true;
    double came = 0.0;                  // m/s, of a new one: how fast the node came
    Vector3 impulse = Vector3::Zero();  // N s, as last known, of half a step
    Vector3 arrival = Vector3::Zero();  // N s, of a touch within the step
  };
  struct Toucher {
    std::size_t member;
    std::vector<Side> sides;
    bool sticks = false;
    Vector3 slip = Vector3::Zero();  // unit, where it slides
    bool bounced = false;            // within the step
  };
  // A node, or nodes that hang together rigidly.
  struct Body {
    std::vector<Member> members;
    std::vector<std::uint32_t> nodes;  // of the members
    std::optional<std::size_t> cluster;
    std::vector<Toucher> touchers;
  };
  using Rods = RigidConnections::WithoutContact;

  [[nodiscard]] Body body_of(const springnet_sweep& step, const std::vector<std::uint32_t>& nodes) const;
  springnet_status know_forces(Body& body, const springnet_sweep& step, double time,
                               const springnet_const_vectors& position, const springnet_const_vectors& velocity);
  [[nodiscard]] bool is_near(const springnet_sweep& step, std::uint32_t node, bool alone) const;
  springnet_status drift(Body& body);
  // Where members go with these impulses on the touchers, N s. False if lengths cannot be kept.
  [[nodiscard]] bool go(Body& body, const std::optional<Rods>& rods, const std::vector<Vector3>& impulses) const;
  void push(Body& body, const std::optional<Rods>& rods, const std::vector<Vector3>& impulses) const;
  [[nodiscard]] Island island_at_start(const Body& body, const std::optional<Rods>& rods) const;
  // Impulses of the contacts that the body has; the body goes with them.
  springnet_status hold(Body& body, const std::optional<Rods>& rods);
  [[nodiscard]] bool reaches(const Member& m, std::size_t surface) const;
  // Surfaces that members meet on their way. Returns whether there are any.
  bool meet(Body& body);
  // A lone node that was free stops at the surface, or bounces, from there to the next, within the step. Impulses of
  // several bounces off one surface add up.
  void arrive(Body& body, const Contact::Meeting& first);
  // Positions of what arrived fit again.
  springnet_status fit(Body& body);
  void decide(const Body& body) const;
  springnet_status kick(Body& body, const springnet_vectors& position, const springnet_vectors& velocity);
  void take(const Body& body, const Island& island, const springnet_vectors& position,
            const springnet_vectors& velocity);
  void tell(Event::Kind kind, std::uint32_t node, std::int32_t surface, const Vector3& impulse = Vector3::Zero());
  [[nodiscard]] springnet_status cannot_keep(const Body& body) const;
  [[nodiscard]] ContactSide side_of(const Body& body, const Toucher& toucher, const Side& side) const;
  [[nodiscard]] Eigen::MatrixXd mobility(const Body& body, const std::optional<Rods>& rods) const;
  [[nodiscard]] double negligible(const Body& body) const;  // N
  // Impulses where no forces were found, begun with what the sides had last.
  void strike(Island& island, const Body& body) const;
  // Notes what the sides of the touchers had.
  void remember(const Island& island, bool struck, Body& body) const;

  Engine& engine_;
  Contact& contact_;
  double from_, until_, h_;  // s
  bool kicked_ = false;
  std::shared_ptr<const Placement> from_at_, at_;  // where surfaces are at both ends
  std::vector<Body> bodies_;
  // [node, surface] of the last kick, N s: where bodies rest on more contacts than bear them, what bears them is found
  // from this.
  std::map<std::pair<std::uint32_t, std::int32_t>, Vector3> last_;
  double last_h_ = 0.0;  // s, the step of that
};

// Of nodes in contact, by what acts on them.
[[nodiscard]] inline bool is_rough(const ContactSide& side) { return coefficient_of(side.friction) > 0.0; }

// What of `v` lies along all surfaces that act on a node.
[[nodiscard]] inline Vector3 along_surfaces(const ContactNode& node, const Vector3& v) {
  std::vector<Vector3> normals;
  for (const ContactSide& side : node.sides)
    if (side.touches) normals.push_back(side.normal);
  return normals.empty() ? v : split_reaction(normals, v).along;
}
[[nodiscard]] inline const ContactSide* first_acting(const ContactNode& node) {
  const auto found = std::find_if(node.sides.begin(), node.sides.end(), [](const auto& s) { return s.touches; });
  return found == node.sides.end() ? nullptr : &*found;
}
[[nodiscard]] inline bool has_friction(const ContactNode& node) {
  return std::any_of(node.sides.begin(), node.sides.end(), [](const auto& s) { return s.touches && is_rough(s); });
}
[[nodiscard]] inline Vector3 sum_of(const std::vector<Vector3>& impulses) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& impulse : impulses) sum += impulse;
  return sum;
}

}  // namespace springnet
