// Contact in a step of velocity Verlet, which knows forces only at the two ends of the step. Bodies (single nodes, or
// all nodes that rigid connections join) in contact follow RATTLE with one-sided constraints: with h the step, F and F'
// the forces at its ends, W the inverse masses,
//
//   drift   u = v + W (h/2 F + J),    P = p + h u,    lengths(P) = l,    gaps(P) >= 0,
//   kick    V = u + W (h/2 F' + K),   rates of lengths = 0,   rates of gaps >= 0,
//
// J along the directions at p, K along those at P. An obstacle gives an impulse only if its gap, or the rate of its
// gap, is zero, and never pulls. Friction lies in Coulomb's cone: against the slip at p in the drift, against the
// remaining slip in the kick. So a node separates if its path without the obstacle ends outside. That is decided once
// per step, even if the reaction jumps within it, as at the edge of a face. Andersen, J. Comput. Phys. 52 (1983) 24;
// Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235.
//
// An impact is an impulse by Newton's and Coulomb's laws between drift and kick. For a node without rigid connections
// it acts where the path meets the obstacle; only bodies of several nodes lose a part of the step at each impact.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "constraints/island.hpp"
#include "simulation/model.hpp"

namespace springnet {

class VerletContact {
 public:
  // What bodies in contact give a node in the drift: a velocity, m/s, and how much less that moves it than if it had it
  // from the start, m.
  struct Push {
    Vector3 velocity = Vector3::Zero(), shift = Vector3::Zero();
  };
  using Pushes = std::map<std::uint32_t, Push>;

  // From the committed state, in a step of this length (s). `last`: the step before, or null.
  VerletContact(Model& model, double until, double length, const VerletContact* last);
  // step.next_position, next_velocity: P and u without contact, replaced for bodies in contact; step.force: F, N.
  // pushes: in them already.
  springnet_status drift(const springnet_sweep& step, const Pushes& pushes = {});
  // Whether this is the step between these times (s), and its kick is still to come.
  [[nodiscard]] bool is_of(double from, double until) const noexcept {
    return !kicked_ && from == from_ && until == until_;
  }
  // step.next_velocity: V without contact, replaced for bodies in contact; step.force: F' at P, N. Commits the contacts
  // at the end of the step.
  springnet_status kick(const springnet_sweep& step);

 private:
  struct Member {
    std::uint32_t node;
    bool fixed;
    Vector3 start, start_velocity;             // m, m/s
    Vector3 half = Vector3::Zero();            // m/s: velocity gained from the force in half a step
    Vector3 velocity, position;                // u, P, then V; m/s, m
    Vector3 fitted = Vector3::Zero();          // m/s: what u lacks of the way to P, where obstacles stopped it
    Vector3 place = Vector3::Zero();           // of a fixed or moved node, m
    Vector3 place_velocity = Vector3::Zero();  // m/s, likewise
  };
  struct Side {
    std::int32_t surface;
    bool is_new = false;
    bool active = true;
    double came = 0.0;                  // m/s, of a new contact: approach speed
    Vector3 impulse = Vector3::Zero();  // N s, in half a step, as last known
    Vector3 arrival = Vector3::Zero();  // N s, of an impact within the step
  };
  struct Toucher {
    std::size_t member;
    std::vector<Side> sides;
    bool sticks = false;
    Vector3 slip = Vector3::Zero();  // unit, where it slides
    bool bounced = false;            // within the step
  };
  // A node, or all nodes that rigid connections join.
  struct Body {
    std::vector<Member> members;
    std::vector<std::uint32_t> nodes;  // of the members
    std::optional<std::size_t> cluster;
    std::vector<Toucher> touchers;
    bool is_pushed = false;  // by bodies
  };
  using Rods = RigidConnections::WithoutContact;

  [[nodiscard]] Body body_of(const springnet_sweep& step, const std::vector<std::uint32_t>& nodes) const;
  springnet_status evaluate_forces(Body& body, const springnet_sweep& step, double time,
                                   const springnet_const_vectors& position, const springnet_const_vectors& velocity);
  [[nodiscard]] bool is_near(const springnet_sweep& step, std::uint32_t node, bool alone) const;
  springnet_status drift(Body& body);
  // Moves the members under these impulses on the touchers, N s. False if lengths cannot be kept.
  [[nodiscard]] bool go(Body& body, const std::optional<Rods>& rods, const std::vector<Vector3>& impulses) const;
  void push(Body& body, const std::optional<Rods>& rods, const std::vector<Vector3>& impulses) const;
  [[nodiscard]] Island island_at_start(const Body& body, const std::optional<Rods>& rods) const;
  // m, of a member that touched an obstacle with this normal when the step began. Where bodies push it through a thin
  // obstacle, it is behind where it began, not in front of the other side.
  [[nodiscard]] double gap_of(const Body& body, const Member& m, const ContactSide& side) const;
  // Finds the impulses of the body's contacts, and moves it with them.
  springnet_status hold(Body& body, const std::optional<Rods>& rods);
  [[nodiscard]] bool reaches(const Member& m, std::size_t surface) const;
  // Adds obstacles that members meet on their paths. Returns whether there are any.
  bool meet(Body& body);
  // A free node without rigid connections stops at the obstacle, or bounces from obstacle to obstacle within the step.
  // Impulses of several bounces off one obstacle add up.
  void arrive(Body& body, const Contact::Meeting& first);
  // Puts nodes that arrived onto their obstacles, subject to the other constraints.
  springnet_status fit(Body& body);
  void decide(const Body& body) const;
  springnet_status kick(Body& body, const springnet_vectors& position, const springnet_vectors& velocity);
  void commit_contacts(const Body& body, const Island& island, const springnet_vectors& position,
                       const springnet_vectors& velocity);
  void record_event(Event::Kind kind, std::uint32_t node, std::int32_t surface, const Model::NodeAt& state,
                    const Vector3& impulse = Vector3::Zero());
  [[nodiscard]] springnet_status fail_lengths(const Body& body) const;
  [[nodiscard]] ContactSide side_of(const Body& body, const Toucher& toucher, const Side& side) const;
  [[nodiscard]] Eigen::MatrixXd mobility(const Body& body, const std::optional<Rods>& rods) const;
  [[nodiscard]] double negligible(const Body& body) const;  // N
  // Impulses if no forces were found, starting from the last ones of each side.
  void apply_impulses(Island& island, const Body& body) const;
  // Remembers the impulses of the sides.
  void remember(const Island& island, bool struck, Body& body) const;

  Model& model_;
  Contact& contact_;
  double from_, until_, h_;  // s
  bool kicked_ = false;
  std::shared_ptr<const Placement> from_at_, at_;  // obstacles at both ends
  std::vector<Body> bodies_;
  // [node, obstacle] N s, of the last kick: the starting point if a body has redundant contacts.
  std::map<std::pair<std::uint32_t, std::int32_t>, Vector3> last_;
  double last_h_ = 0.0;  // s, length of that step
};

class VerletPairs;
// Contact in the last step of velocity Verlet.
struct VerletStep {
  std::shared_ptr<VerletContact> obstacles;  // null: none
  std::shared_ptr<VerletPairs> bodies;       // likewise
};
// A drift or a kick, as springnet_host::constrain has them. `last`: the last step, null: none.
springnet_status constrain_verlet(Model& model, const springnet_sweep& step, std::unique_ptr<VerletStep>& last);

// ---- of a node in contact ----
[[nodiscard]] inline bool is_rough(const ContactSide& side) { return coefficient_of(side.friction) > 0.0; }

// The part of `v` along all surfaces that act on a node.
[[nodiscard]] inline Vector3 along_surfaces(const ContactNode& node, const Vector3& v) {
  std::vector<Vector3> normals;
  for (const ContactSide& side : node.sides)
    if (side.active) normals.push_back(side.normal);
  return normals.empty() ? v : split_reaction(normals, v).tangential;
}
[[nodiscard]] inline const ContactSide* first_acting(const ContactNode& node) {
  const auto found = std::find_if(node.sides.begin(), node.sides.end(), [](const auto& s) { return s.active; });
  return found == node.sides.end() ? nullptr : &*found;
}
[[nodiscard]] inline bool has_friction(const ContactNode& node) {
  return std::any_of(node.sides.begin(), node.sides.end(), [](const auto& s) { return s.active && is_rough(s); });
}
[[nodiscard]] inline Vector3 sum_of(const std::vector<Vector3>& impulses) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& impulse : impulses) sum += impulse;
  return sum;
}

}  // namespace springnet
