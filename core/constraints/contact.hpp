// Unilateral contact of nodes with planes, spheres, capsules and boxes that may move and turn, with restitution. The
// paper's rule: a node that crosses the surface is held where it touched until a reverse force occurs. Without
// friction, or with Coulomb friction, it slides. The sweeps of the recurrent network and the events of the reference
// share this state and its transitions.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

#include "constraints/contact_state.hpp"
#include "constraints/friction.hpp"
#include "constraints/obstacle.hpp"
#include "constraints/placement.hpp"
#include "constraints/prescribed.hpp"
#include "text/archive.hpp"

namespace springnet {

// A change of a node's contact between two commits.
struct ContactChange {
  enum class Kind : std::uint8_t { touched, released, slipped, stuck };
  Kind kind;
  std::uint32_t node;
  std::int32_t surface;
};

class Contact {
 public:
  Contact(const Network& network, const std::vector<std::uint32_t>& user_number,
          const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass);

  [[nodiscard]] const std::vector<Obstacle>& obstacles() const noexcept { return obstacles_; }
  // For messages, as "plane 'floor' (number 0)".
  [[nodiscard]] std::string name_of(std::size_t surface) const;
  // Of a surface with Coulomb friction.
  void set_friction(std::size_t surface, double coefficient);
  void set_trajectory(std::size_t surface, Trajectory trajectory);
  // See Prescribed::set and stop.
  void set_motion(std::uint32_t node, const Vector3& start, Trajectory trajectory);
  void stop_motion(std::uint32_t node);
  [[nodiscard]] const Prescribed& prescribed() const noexcept { return prescribed_; }

  // Poses of surfaces and prescribed nodes at a time, cached. Not thread-safe.
  [[nodiscard]] const std::shared_ptr<const Placement>& at(const SampleTime& time) const;
  // The next time after `time` at which the velocity or acceleration of a prescribed motion may jump; s.
  [[nodiscard]] double next_change(double time) const;
  // The same of motions of the scene, not those that set_trajectory() and set_motion() gave.
  [[nodiscard]] double next_change_of_scene(double time) const;

  // [node], 1 if: fixed or prescribed; held by a surface in the committed state; in contact in the committed state.
  [[nodiscard]] const std::vector<std::uint8_t>& fixed() const noexcept { return fixed_; }
  [[nodiscard]] const std::vector<std::uint8_t>& held() const noexcept { return held_; }
  [[nodiscard]] const std::vector<std::uint8_t>& touching() const noexcept { return touching_; }
  // 1 if fixed, prescribed, or held by a surface after the last sweep or commit.
  [[nodiscard]] const std::vector<std::uint8_t>& constrained() const noexcept { return constrained_; }
  // [node] SPRINGNET_FREE … after the last sweep or commit.
  [[nodiscard]] const std::vector<std::uint8_t>& status() const noexcept { return status_; }
  [[nodiscard]] const Touch& committed(std::uint32_t node) const noexcept {
    return committed_.empty() ? no_touch : committed_[node];
  }
  [[nodiscard]] const Touch& now(std::uint32_t node) const noexcept { return now_.empty() ? no_touch : now_[node]; }
  [[nodiscard]] Vector3 impulse(std::uint32_t node) const;

  // Queries of one surface, see Obstacle.
  [[nodiscard]] double gap(const Placement& at, std::size_t surface, const Vector3& position) const {
    return obstacles_[surface].gap(at.poses[surface], position);
  }
  [[nodiscard]] Vector3 normal(const Placement& at, std::size_t surface, const Vector3& position) const {
    return obstacles_[surface].normal(at.poses[surface], position);
  }
  [[nodiscard]] double bias_acceleration(const Placement& at, std::size_t surface, const Vector3& position,
                                         const Vector3& relative) const {
    return obstacles_[surface].bias_acceleration(at.poses[surface], position, relative);
  }
  [[nodiscard]] Vector3 onto(const Placement& at, std::size_t surface, const Vector3& position) const {
    return obstacles_[surface].onto(at.poses[surface], position);
  }
  [[nodiscard]] static Vector3 velocity(const Placement& at, std::size_t surface, const Vector3& position) {
    return at.poses[surface].velocity_at(position);
  }
  [[nodiscard]] static Vector3 acceleration(const Placement& at, std::size_t surface, const Vector3& position) {
    return at.poses[surface].acceleration_at(position);
  }

  void set_fixed(std::uint32_t node, bool fixed);
  // Sets a node's committed contact and adds the impulse (N s) to impulse().
  void touch(std::uint32_t node, const Touch& touch, const Vector3& impulse);
  void release(std::uint32_t node);
  // Slip below this speed, m/s, may be ending: friction keeps its direction, so that the slip passes through zero
  // smoothly and the time of sticking can be located. Or it has just begun: friction opposes the sliding acceleration,
  // because so small a slip is mostly integration error.
  [[nodiscard]] double rest_speed() const noexcept { return rest_speed_; }
  void set_rest_speed(double speed) noexcept { rest_speed_ = speed; }
  // The last slip direction of a sliding node, or the one in which slip began; friction opposes it while the slip ends.
  [[nodiscard]] const Vector3& slip(std::uint32_t node) const { return slip_[node]; }
  enum class Slip : std::uint8_t { ongoing, starting, ending };
  [[nodiscard]] Slip slip_phase(std::uint32_t node) const { return slip_phase_[node]; }
  void set_slip(std::uint32_t node, const Vector3& direction, Slip phase = Slip::ongoing) {
    slip_[node] = direction;
    slip_phase_[node] = phase;
  }
  // Braced: sticks although its own force would pull, because rigid connections press it on; without the contact it
  // would penetrate the surface.
  [[nodiscard]] bool braced(std::uint32_t node) const { return braced_[node] != 0; }
  void set_braced(std::uint32_t node, bool braced) { braced_[node] = braced ? 1 : 0; }
  // Updates the slip directions of sliding nodes from these velocities.
  void update_slip_directions(const Placement& at, const springnet_const_vectors& position,
                              const springnet_const_vectors& velocity);
  // Adds an impulse (N s) of a surface on a node, apart from contact forces.
  void add_impulse(std::uint32_t node, const Vector3& impulse) {
    impulse_.resize(mass_.size(), Vector3::Zero());
    impulse_[node] += impulse;
  }
  void add_surface_impulse(std::size_t surface, const Vector3& impulse) { surface_impulse_[surface] += impulse; }
  // Sum of the impulses of nodes on a surface so far, N s.
  [[nodiscard]] const Vector3& surface_impulse(std::size_t surface) const { return surface_impulse_[surface]; }

  // The same of the network before it was extended.
  void take_over(const Contact& before, const layers::NumbersBefore& numbers);
  // Contacts, friction, impulses and motions at a committed state.
  void archive(Archive& archive);

  // ---- within a step ----
  // Begins a step from the committed contacts, with surfaces at `start`.
  void begin_step(std::shared_ptr<const Placement> start);
  // Constrains the outputs of nodes [first, first + count) by fixation and surfaces at the end of the step. Skips nodes
  // whose `cluster` (null: none) is not 0xffffffff: RigidConnections constrains them. The sweep's arrays cover all
  // nodes. `read`: velocity that the update of a single node started from, m/s; null: the sweep's. commit_sweep() makes
  // the resulting contacts the committed ones.
  void constrain(const Placement& end, std::uint32_t first, std::uint32_t count, const springnet_sweep& sweep,
                 const std::uint32_t* cluster, const Vector3* read = nullptr);
  // The same for nodes of a list without rigid connections, [component][i] of `read` for nodes[i].
  void constrain(const Placement& end, std::span<const std::uint32_t> nodes, const springnet_sweep& sweep,
                 const springnet_const_vectors& read);
  // For sweeps that constrain all nodes at once. Before them: remembers contacts. After them: where too many sweeps of
  // the step changed contacts, lets only some nodes do so that are not in a `cluster` (null: none).
  void remember(const springnet_sweep& sweep);
  void limit_changes(const Placement& end, const springnet_sweep& sweep, const std::uint32_t* cluster);
  // Sets position and velocity of a fixed or prescribed node; false for any other node.
  bool constrain_fixed(const Placement& end, std::uint32_t node, const springnet_sweep& sweep) const;
  // The first surface that a node meets on its path through the step, and the share of the path at which it does.
  struct Meeting {
    std::int32_t surface = -1;
    double share = 0.0;
  };
  [[nodiscard]] Meeting first_meeting(const Placement& at, const Vector3& start, const Vector3& end,
                                      std::int32_t except = -1, std::int32_t and_except = -1) const;
  // A node's path through the step: m, m/s.
  struct Path {
    std::uint32_t node;
    Vector3 start, start_velocity, end, velocity;
  };
  // For a node that slides on some surfaces: the next one that it meets, except those known; -1: none.
  [[nodiscard]] Meeting next_meeting(const Placement& at, const Path& path, const Touch& on,
                                     const std::vector<std::int32_t>& known = {}) const;
  // Whether a node whose contact has chattered may be held at its last surface although its path does not meet it.
  [[nodiscard]] bool could_reach(const Placement& at, std::uint32_t node, const Vector3& start,
                                 const Vector3& end) const;
  // Whether a node is separating from a surface that its straight path crosses.
  [[nodiscard]] bool is_separating(const Placement& at, std::int32_t surface, const Path& path) const;
  // Position at the end of the step of a node that the surface carries from the meeting on.
  [[nodiscard]] Vector3 carried_from(const Placement& at, const Vector3& start, const Vector3& end,
                                     const Meeting& meeting) const;
  // Position at the end of the step of a node that a surface holds where it touched: where the path of its start
  // velocity meets the surface, or the projection of its end if it falls short. `length`: s, of the step.
  [[nodiscard]] Vector3 where_it_touched(const Placement& at, double length, const Vector3& start,
                                         const Vector3& start_velocity, std::int32_t surface) const;
  // Position at the end of the step of a node that the surface carries from the start.
  [[nodiscard]] Vector3 carried(const Placement& at, const Vector3& start, std::int32_t surface) const;
  // A vector at a node, rotated with the surface over the step.
  [[nodiscard]] Vector3 rotated_with(const Placement& at, std::int32_t surface, const Vector3& start,
                                     const Vector3& vector) const;
  // Records a sweep's decision for a node. True once the contact has chattered too often in this step; it then stays
  // active. The rule is discontinuous: touching stops the node, which changes the damping forces on it so that it may
  // not touch any more; then it moves and touches again. Such a step has no fixed point.
  bool record_decision(std::uint32_t node, bool in_contact);
  [[nodiscard]] bool has_chattered(std::uint32_t node) const noexcept;
  // Sets a node's contact within the sweep. `impulse`: N s, of the surfaces over the step, without the share of the
  // reaction at its start if theta < 1. A contact that bounces is released at the commit.
  void decide(std::uint32_t node, const Touch& touch, const Vector3& impulse, bool bounces = false);
  [[nodiscard]] bool bounces(std::uint32_t node) const noexcept { return !bounces_.empty() && bounces_[node] != 0; }
  // Rebound speed of a node in a new contact, m/s: restitution times the approach speed at the start of the step; 0 if
  // that is not more than the change of velocity over the step. `free`: velocity without the surface, m/s.
  [[nodiscard]] double rebound(const Placement& at, std::int32_t surface, const Vector3& position,
                               const Vector3& start_velocity, const Vector3& free) const;
  [[nodiscard]] std::int32_t last_surface(std::uint32_t node) const noexcept { return last_surface_[node]; }

  // Stops nodes that arrived at a surface, see arrives(); true: that changed a velocity. Before commit_sweep().
  [[nodiscard]] bool land(const springnet_vectors& velocity) const;
  // Commits the contacts of the last sweep and returns the changes; none if the sweeps did not decide contacts.
  [[nodiscard]] std::vector<ContactChange> commit_sweep(bool decided);
  // The placement at the start of the step.
  [[nodiscard]] const Placement& start() const { return *start_; }
  // Impulse of the surfaces over the step just committed, N s; see decide().
  [[nodiscard]] Vector3 sweep_impulse(std::uint32_t node) const {
    return sweep_impulse_.empty() ? Vector3(Vector3::Zero()) : sweep_impulse_[node];
  }
  // Discards the contacts of sweeps that were not committed.
  void discard_sweep();

  // Surfaces (two to four) that overlap near this position by more than `tolerance` (m), so that no room is left
  // between them; empty if there is room.
  [[nodiscard]] std::vector<std::int32_t> closed_around(const Placement& at, const Vector3& position,
                                                        double tolerance) const;
  // For messages: "plane 'left' (number 0) and plane 'right' (number 1)".
  [[nodiscard]] std::string names_of(const std::vector<std::int32_t>& surfaces) const;

  // Projects a sliding node without rigid connections onto its surfaces, in position and velocity.
  void project_sliding(const Placement& at, std::uint32_t node, const springnet_vectors& position,
                       const springnet_vectors& velocity) const;
  // Constrains accelerations (m/s^2, arrays from node `first`) of nodes [first, first + count) by fixation and
  // surfaces, and adds friction. Skips sliding nodes that belong to a `cluster`.
  void accelerate(const Placement& at, std::uint32_t first, std::uint32_t count,
                  const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                  double* const acceleration[3], const std::uint32_t* cluster) const;
  // Unit normals of the surfaces that a node touches, at `position`.
  [[nodiscard]] std::vector<Vector3> normals(const Placement& at, std::uint32_t node, const Vector3& position) const;
  // Slip velocity of a sliding node on one of its surfaces, m/s: relative to it, tangential to all of them.
  [[nodiscard]] Vector3 slip_vector(const Placement& at, std::uint32_t node, std::size_t surface,
                                    const Vector3& position, const Vector3& velocity) const;
  // The unit slip direction that friction opposes; zero if there is none.
  [[nodiscard]] Vector3 slip_direction(const Placement& at, std::uint32_t node, std::size_t surface,
                                       const Vector3& position, const Vector3& velocity) const;

 private:
  struct Candidate;
  struct Within;  // a sweep and the placement at its end
  struct Slide;
  // Whether obstacles that stand still are farther from where a node starts than its path is long, so that it meets
  // none. False if that is not certain.
  [[nodiscard]] bool is_far(std::uint32_t node, const springnet_sweep& sweep);
  // Keeps a node free that was free, and whose path is too short to meet a surface; false: that is not certain.
  [[nodiscard]] bool keep_free(const Within& within, std::uint32_t node);
  // For springnet_sweep::contacts SPRINGNET_MAY_TOUCH and SPRINGNET_AS_BEFORE.
  void constrain_between_decisions(const Placement& end, std::uint32_t first, std::uint32_t count,
                                   const springnet_sweep& sweep, const std::uint32_t* cluster, const Vector3* read);
  void constrain_node(const Within& within, std::uint32_t node, const Vector3* read);
  // Keeps the committed contact unless a surface would have to pull. True: kept, outputs are set.
  [[nodiscard]] bool try_to_keep(const Within& within, std::uint32_t node, const Candidate& candidate);
  void meet(const Within& within, std::uint32_t node, const Candidate& candidate);
  // Whether a node that has chattered stays free, though it meets this surface (-1: none).
  [[nodiscard]] bool is_left_free(const Within& within, const Candidate& candidate, std::int32_t surface) const;
  // read: as of constrain().
  [[nodiscard]] Candidate candidate_of(const Within& within, std::uint32_t node, const Vector3* read) const;
  // The contact of a node on one surface, which sticks if its slip has turned round.
  [[nodiscard]] Touch stopped_by_friction(const Placement& at, std::uint32_t node, const Candidate& candidate);
  // Keeps a contact whatever the forces.
  void keep(const Within& within, std::uint32_t node, const Touch& touch, const Candidate& candidate);
  // A node that sticks to a surface at which it arrives in this step, at a place on it.
  [[nodiscard]] Slide arrived_at(const Within& within, std::int32_t surface, const Vector3& place,
                                 const Candidate& candidate) const;
  [[nodiscard]] Vector3 where_it_sticks(const Within& within, std::uint32_t node, std::int32_t surface,
                                        const Candidate& candidate) const;
  // Whether few contacts may change in this sweep, as many did in others of the step.
  [[nodiscard]] bool limits_changes(const springnet_sweep& sweep) const noexcept;
  // Whether a node has no contact or one with a surface that does not hold it, off which it does not bounce: one that
  // can be kept whatever the forces. Where a held node stays depends on its decisions.
  [[nodiscard]] bool is_simple(std::uint32_t node, const Touch& touch) const;
  [[nodiscard]] bool holds(std::int32_t surface) const {
    return obstacles_[static_cast<std::size_t>(surface)].friction().kind == Friction::Kind::held;
  }
  // Gives a node the contact that it had before the sweep, and the outputs that go with it.
  void take_back(const Within& within, std::uint32_t node);
  // A node with the contact and the outputs that the sweep has decided.
  struct Changing {
    std::uint32_t node;
    Touch touch;
    double way;                  // m, from the outputs with the contact that it had
    Vector3 position, velocity;  // m, m/s
    Vector3 force;               // N, of the surface in the sweep
    Vector3 impulse, slip;       // N s, m/s
    std::uint8_t lands;
    Vector3 landing;  // m/s
  };
  void restore_outputs(const springnet_sweep& sweep, std::uint32_t node);
  [[nodiscard]] bool slips_first(const Changing& change) const;
  void slip_instead(const Within& within, std::uint32_t node);
  void change_as_decided(const springnet_sweep& sweep, const Changing& change);
  // Slides along one surface; the velocity is tangential at the end position, or at `normal_at` unless null. rebound:
  // m/s.
  [[nodiscard]] Slide slide_along(const Within& within, std::int32_t surface, const Candidate& candidate,
                                  const Vector3* normal_at = nullptr, double rebound = 0.0) const;
  // Whether a node that meets a surface in this step ends it with the velocity that takes it there, instead of the
  // surface's: see Arrivals in contact_slide.cpp.
  [[nodiscard]] bool arrives(std::uint32_t node, std::int32_t surface) const;
  // Slides along the edge of two surfaces; rebound: off the second, m/s.
  [[nodiscard]] Slide slide_along_edge(const Within& within, std::int32_t first, std::int32_t second,
                                       const Candidate& candidate, double rebound = 0.0) const;
  // At the vertex of three surfaces, which leaves no direction to slide in.
  [[nodiscard]] Slide at_vertex(const Within& within, const Touch& touch, const Candidate& candidate) const;
  // Slides along the two surfaces that are left when the one with the smallest normal impulse releases the node.
  [[nodiscard]] Slide leave_vertex(const Within& within, const Slide& vertex, const Candidate& candidate) const;
  // Chooses the active surfaces of a node that slides on some and meets others. `met` becomes all that it meets. Empty:
  // no choice fits.
  [[nodiscard]] std::optional<Slide> choose_active_set(const Within& within, const Slide& on,
                                                       std::vector<std::int32_t>& met,
                                                       const Candidate& candidate) const;
  [[nodiscard]] bool is_flush(const Placement& at, const Touch& on, std::int32_t surface,
                              const Vector3& position) const;
  void set_outputs(const Within& within, std::uint32_t node, const Slide& slide);
  // The same, unless the path meets another surface.
  void slide(const Within& within, std::uint32_t node, const Slide& slide, const Candidate& candidate);
  void stop(const Within& within, std::uint32_t node, const Touch& touch, const Vector3& place,
            const Candidate& candidate);
  void stop_between(const Within& within, std::uint32_t node, const Slide& slide, const Meeting& next,
                    const Candidate& candidate);
  [[nodiscard]] Vector3 onto_both(const Placement& at, std::int32_t first, std::int32_t second,
                                  const Vector3& position) const;
  void archive_contacts(Archive& archive);
  void refresh(std::uint32_t node);
  // The acceleration of a sliding node without rigid connections, from the one without surfaces.
  [[nodiscard]] Vector3 sliding_acceleration(const Placement& at, std::uint32_t node, const Vector3& position,
                                             const Vector3& velocity, const Vector3& acceleration) const;
  void update_status(std::uint32_t node) noexcept;  // from now_

  std::vector<Obstacle> obstacles_;
  const std::vector<double>& mass_;
  Prescribed prescribed_;
  mutable std::shared_ptr<const Placement> cached_placement_;  // null: none
  std::shared_ptr<const Placement> start_;                     // of the step
  double rest_speed_ = 0.0;
  bool any_fixed_ = false;  // or was
  std::vector<std::uint8_t> fixed_, held_, touching_, constrained_, status_;
  static constexpr Touch no_touch{};
  // All empty without surfaces.
  std::vector<Touch> committed_, now_;
  // Within a step, [node]: changes of decision between sweeps, and the last decision.
  std::vector<std::uint8_t> changes_, was_in_contact_, bounces_, braced_;
  std::vector<std::uint8_t> lands_;  // [node], of the last sweep: its velocity becomes landing_ at the commit
  std::vector<Vector3> landing_;     // m/s
  // Changes of the set of surfaces on which a node slides, and all surfaces that it met.
  std::vector<std::uint8_t> slide_changes_;
  std::vector<std::vector<std::int32_t>> met_;
  std::vector<Slip> slip_phase_;
  // Sweeps of the step that constrained all nodes and changed contacts, and what was before the last.
  int changed_sweeps_ = 0;
  std::vector<int> limited_changes_;  // [node] that limit_changes() let happen
  struct Before {
    std::vector<Touch> now;
    std::vector<std::uint8_t> changes, slide_changes, was_in_contact;
    std::vector<std::int32_t> last_surface;
    std::vector<Vector3> slip;
    std::vector<double> outputs;  // [6][node] without contact, m and m/s
  } before_;
  std::vector<Changing> changing_;
  // [node] where the node last started, m, and the square of the path from there that meets no obstacle, if they stand
  // still, m^2.
  struct StartGap {
    Vector3 start = Vector3::Constant(std::numeric_limits<double>::quiet_NaN());
    double square_reach = 0.0;
  };
  std::vector<StartGap> start_gap_;
  bool any_moves_ = false;  // an obstacle
  std::vector<std::int32_t> last_surface_;
  std::vector<Vector3> slip_;
  std::vector<Vector3> impulse_, sweep_impulse_;
  std::vector<Vector3> surface_impulse_;  // [surface]
};

}  // namespace springnet
