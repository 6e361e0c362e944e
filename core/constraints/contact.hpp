// Unilateral contact of nodes with planes, spheres, capsules and boxes that may move and turn, with restitution. The
// paper's rule: a node that crosses is held where it touched until a reverse force occurs; without friction, or with
// Coulomb's, it slides. The same state and decisions serve the sweeps of the recurrent network and the events of the
// reference.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

#include "constraints/contact_state.hpp"
#include "constraints/friction.hpp"
#include "constraints/obstacle.hpp"
#include "constraints/placement.hpp"
#include "constraints/prescribed.hpp"

namespace springnet {

// What a node did between two commits.
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

  [[nodiscard]] const std::vector<Obstacle>& surfaces() const noexcept { return surfaces_; }
  // For messages, as "plane 'floor' (number 0)".
  [[nodiscard]] std::string name_of(std::size_t surface) const;
  void set_trajectory(std::size_t surface, Trajectory trajectory);
  // See Prescribed::set and stop.
  void set_motion(std::uint32_t node, const Vector3& start, Trajectory trajectory);
  void stop_motion(std::uint32_t node);
  [[nodiscard]] const Prescribed& prescribed() const noexcept { return prescribed_; }

  // Where surfaces and prescribed nodes are at a time. Not from several threads.
  [[nodiscard]] const std::shared_ptr<const Placement>& at(const SampleTime& time) const;
  // The next time after `time` at which something that moves changes its velocity or acceleration by a jump; s.
  [[nodiscard]] double next_change(double time) const;

  // 1: fixed or moved by the scene; as committed held by a surface; held or sliding.
  [[nodiscard]] const std::vector<std::uint8_t>& fixed() const noexcept { return fixed_; }
  [[nodiscard]] const std::vector<std::uint8_t>& held() const noexcept { return held_; }
  [[nodiscard]] const std::vector<std::uint8_t>& touching() const noexcept { return touching_; }
  // Fixed, or held by a surface as the last sweep of a step, or the last commit, left it.
  [[nodiscard]] const std::vector<std::uint8_t>& constrained() const noexcept { return constrained_; }
  // SPRINGNET_FREE …, by node, likewise.
  [[nodiscard]] const std::vector<std::uint8_t>& status() const noexcept { return status_; }
  [[nodiscard]] const Touch& committed(std::uint32_t node) const noexcept { return committed_[node]; }
  [[nodiscard]] const Touch& now(std::uint32_t node) const noexcept { return now_[node]; }
  [[nodiscard]] Vector3 impulse(std::uint32_t node) const;

  // Of a surface, see Obstacle.
  [[nodiscard]] double gap(const Placement& at, std::size_t surface, const Vector3& position) const {
    return surfaces_[surface].gap(at.poses[surface], position);
  }
  [[nodiscard]] Vector3 normal(const Placement& at, std::size_t surface, const Vector3& position) const {
    return surfaces_[surface].normal(at.poses[surface], position);
  }
  [[nodiscard]] double bias_acceleration(const Placement& at, std::size_t surface, const Vector3& position,
                                         const Vector3& relative) const {
    return surfaces_[surface].bias_acceleration(at.poses[surface], position, relative);
  }
  [[nodiscard]] Vector3 onto(const Placement& at, std::size_t surface, const Vector3& position) const {
    return surfaces_[surface].onto(at.poses[surface], position);
  }
  [[nodiscard]] static Vector3 velocity(const Placement& at, std::size_t surface, const Vector3& position) {
    return at.poses[surface].velocity_at(position);
  }
  [[nodiscard]] static Vector3 acceleration(const Placement& at, std::size_t surface, const Vector3& position) {
    return at.poses[surface].acceleration_at(position);
  }

  void set_fixed(std::uint32_t node, bool fixed);
  // Makes or changes a contact, of the committed state; the impulse (N s) counts.
  void touch(std::uint32_t node, const Touch& touch, const Vector3& impulse);
  void release(std::uint32_t node);
  // Slip that is slower may be about to end: the direction in which friction acts against it is kept, so that the slip
  // goes through zero smoothly and the time of that is found exactly. Or it has just begun: friction acts against its
  // acceleration, because the slip itself would be errors of integration; m/s.
  [[nodiscard]] double rest_speed() const noexcept { return rest_speed_; }
  void set_rest_speed(double speed) noexcept { rest_speed_ = speed; }
  // Where a sliding node goes, or began to go; friction acts against that direction while the slip ends.
  [[nodiscard]] const Vector3& slip(std::uint32_t node) const { return slip_[node]; }
  enum class Slip : std::uint8_t { goes_on, begins, ends };
  [[nodiscard]] Slip slip_phase(std::uint32_t node) const { return slip_phase_[node]; }
  void set_slip(std::uint32_t node, const Vector3& direction, Slip phase = Slip::goes_on) {
    slip_[node] = direction;
    slip_phase_[node] = phase;
  }
  // Nodes that stick although their own force would pull: connections press them on, because without the surface they
  // would go into it.
  [[nodiscard]] bool braced(std::uint32_t node) const { return braced_[node] != 0; }
  void set_braced(std::uint32_t node, bool braced) { braced_[node] = braced ? 1 : 0; }
  // Follows the slips of sliding nodes, at these velocities.
  void note_slips(const Placement& at, const springnet_const_vectors& position,
                  const springnet_const_vectors& velocity);
  // What a surface gave a node at once, beside its forces, N s.
  void add_impulse(std::uint32_t node, const Vector3& impulse) {
    impulse_.resize(mass_.size(), Vector3::Zero());
    impulse_[node] += impulse;
  }
  void add_surface_impulse(std::size_t surface, const Vector3& impulse) { surface_impulse_[surface] += impulse; }
  // What nodes gave a surface at once so far, N s.
  [[nodiscard]] const Vector3& surface_impulse(std::size_t surface) const { return surface_impulse_[surface]; }

  // ---- within a step ----
  // The step starts from the committed contacts, where surfaces are at `start`.
  void begin_step(std::shared_ptr<const Placement> start);
  // Puts the outputs of nodes [first, first + count) where fixation and surfaces allow at the end of the step; nodes of
  // `cluster` (null: none) other than 0xffffffff are left to those that know their rigid connections. The sweep's
  // arrays are of all nodes; `read` is the velocity that the update of a single node started from, m/s, null: that in
  // the sweep. The decisions become the state of the contacts with commit_sweep().
  void constrain(const Placement& end, std::uint32_t first, std::uint32_t count, const springnet_sweep& sweep,
                 const std::uint32_t* cluster, const Vector3* read = nullptr);
  // For those: where a node that the scene moves or fixes is, its velocity there; true if it is such a node.
  bool constrain_fixed(const Placement& end, std::uint32_t node, const springnet_sweep& sweep) const;
  // The earliest surface that a node meets on its way through the step, and at what share of it.
  struct Meeting {
    std::int32_t surface = -1;
    double share = 0.0;
  };
  [[nodiscard]] Meeting first_meeting(const Placement& at, const Vector3& start, const Vector3& end,
                                      std::int32_t except = -1, std::int32_t and_except = -1) const;
  // A node on its way through the step: m, m/s.
  struct Way {
    std::uint32_t node;
    Vector3 start, start_velocity, end, velocity;
  };
  // A node that slides on some surfaces: the next one that it runs into, beside those that are known; -1: none.
  [[nodiscard]] Meeting next_meeting(const Placement& at, const Way& way, const Touch& on,
                                     const std::vector<std::int32_t>& known = {}) const;
  // Whether a node whose contact oscillated may be held at its last surface, though it does not meet it on its way.
  [[nodiscard]] bool could_reach(const Placement& at, std::uint32_t node, const Vector3& start,
                                 const Vector3& end) const;
  // Whether a node goes away from a surface that its straight way crosses.
  [[nodiscard]] bool leaves(const Placement& at, std::int32_t surface, const Way& way) const;
  // Where a node that met a surface is, at the end of the step, if it is taken along from there on.
  [[nodiscard]] Vector3 taken_along(const Placement& at, const Vector3& start, const Vector3& end,
                                    const Meeting& meeting) const;
  // Where a node is at the end of a step that started in contact and was taken along.
  [[nodiscard]] Vector3 carried(const Placement& at, const Vector3& start, std::int32_t surface) const;
  // A vector at a node that is taken along, as the surface turns it within the step.
  [[nodiscard]] Vector3 turned_along(const Placement& at, std::int32_t surface, const Vector3& start,
                                     const Vector3& vector) const;
  // The rule is discontinuous: a node that touches stops, which changes the forces on it by what dampers did, so that
  // it may not touch any more; then it moves, and touches. No state is a fixed point of that. Tells what is decided
  // for a node; true: it changed its mind too often in this step and stays in contact.
  bool oscillates(std::uint32_t node, bool stays);
  [[nodiscard]] bool oscillated(std::uint32_t node) const noexcept;
  // `impulse`: N s, of the surfaces over the step (of the reaction at its start, if theta < 1, none). One that bounces
  // touches, and is let go when the step is committed.
  void decide(std::uint32_t node, const Touch& touch, const Vector3& impulse, bool bounces = false);
  // How fast a node that touches anew leaves a surface, m/s: restitution times how fast it came at the start of the
  // step; 0 where that was no more than the step's own acceleration made it. `free`: without the surface, m/s.
  [[nodiscard]] double rebound(const Placement& at, std::int32_t surface, const Vector3& position,
                               const Vector3& start_velocity, const Vector3& free) const;
  [[nodiscard]] std::int32_t last_surface(std::uint32_t node) const noexcept { return last_surface_[node]; }

  // The decisions of the last sweep become the contacts; unless sweeps `decided`, they are those committed.
  [[nodiscard]] std::vector<ContactChange> commit_sweep(bool decided);
  // Where everything was when the step began.
  [[nodiscard]] const Placement& start() const { return *start_; }
  // Of the surfaces over the step just committed, N s; see decide().
  [[nodiscard]] Vector3 sweep_impulse(std::uint32_t node) const {
    return sweep_impulse_.empty() ? Vector3(Vector3::Zero()) : sweep_impulse_[node];
  }
  // The decisions of sweeps that were not committed are forgotten.
  void forget_sweep();

  // Surfaces (two to four) that have closed so far that between them no place is left near this one, by more than
  // `tolerance` (m); none: there is one.
  [[nodiscard]] std::vector<std::int32_t> closed_around(const Placement& at, const Vector3& position,
                                                        double tolerance) const;
  // For messages: "plane 'left' (number 0) and plane 'right' (number 1)".
  [[nodiscard]] std::string names_of(const std::vector<std::int32_t>& surfaces) const;

  // Puts a lone node that slides onto its surfaces, and its velocity along them.
  void project_sliding(const Placement& at, std::uint32_t node, const springnet_vectors& position,
                       const springnet_vectors& velocity) const;
  // Takes out of accelerations (m/s^2, arrays from node `first`) of nodes [first, first + count) what fixation and
  // surfaces do not allow, and puts in friction; nodes of `cluster` are left.
  void accelerate(const Placement& at, std::uint32_t first, std::uint32_t count,
                  const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                  double* const acceleration[3], const std::uint32_t* cluster) const;
  // Of the surfaces that a node touches, at a place.
  [[nodiscard]] std::vector<Vector3> normals(const Placement& at, std::uint32_t node, const Vector3& position) const;
  // How a sliding node slips on one of its surfaces, m/s: its velocity against it, along all of them.
  [[nodiscard]] Vector3 slip_vector(const Placement& at, std::uint32_t node, std::size_t surface,
                                    const Vector3& position, const Vector3& velocity) const;
  // The direction of that which friction acts against; zero where there is none.
  [[nodiscard]] Vector3 slip_direction(const Placement& at, std::uint32_t node, std::size_t surface,
                                       const Vector3& position, const Vector3& velocity) const;

 private:
  struct Candidate;
  struct Within;  // a sweep, with where surfaces are at its end
  struct Slide;
  void constrain_node(const Within& within, std::uint32_t node, const Vector3* read);
  // Whether surfaces that a node touches as committed still do; then it is put.
  [[nodiscard]] bool stay(const Within& within, std::uint32_t node, const Candidate& candidate);
  void meet(const Within& within, std::uint32_t node, const Candidate& candidate);
  // As committed, whatever the forces.
  void follow(const Within& within, std::uint32_t node, const Candidate& candidate);
  // Along one surface, the velocity fitting it where the position ends; `normal_at`, unless null, is where it fits
  // instead. rebound: m/s.
  [[nodiscard]] Slide along(const Within& within, std::int32_t surface, const Candidate& candidate,
                            const Vector3* normal_at = nullptr, double rebound = 0.0) const;
  // Along two; rebound: off the second, m/s.
  [[nodiscard]] Slide between(const Within& within, std::int32_t first, std::int32_t second, const Candidate& candidate,
                              double rebound = 0.0) const;
  // Where three surfaces meet, which leaves no way to slide.
  [[nodiscard]] Slide at_vertex(const Within& within, const Touch& touch, const Candidate& candidate) const;
  // Of three the two that go on when the weakest lets go.
  [[nodiscard]] Slide off_vertex(const Within& within, const Slide& vertex, const Candidate& candidate) const;
  // On which surfaces a node goes that slides on some and meets others, which become all that it meets; none found: it
  // is stopped.
  [[nodiscard]] std::optional<Slide> among(const Within& within, const Slide& on, std::vector<std::int32_t>& met,
                                           const Candidate& candidate) const;
  [[nodiscard]] bool is_flush(const Placement& at, const Touch& on, std::int32_t surface,
                              const Vector3& position) const;
  void put(const Within& within, std::uint32_t node, const Slide& slide);
  // The same, unless another surface is in the way.
  void slide(const Within& within, std::uint32_t node, const Slide& slide, const Candidate& candidate);
  void stop(const Within& within, std::uint32_t node, const Touch& touch, const Vector3& place,
            const Candidate& candidate);
  void stop_between(const Within& within, std::uint32_t node, const Slide& slide, const Meeting& next,
                    const Candidate& candidate);
  [[nodiscard]] Vector3 onto_both(const Placement& at, std::int32_t first, std::int32_t second,
                                  const Vector3& position) const;
  void refresh(std::uint32_t node);
  // The acceleration of a lone node that slides, from that without surfaces.
  [[nodiscard]] Vector3 slid(const Placement& at, std::uint32_t node, const Vector3& position, const Vector3& velocity,
                             const Vector3& acceleration) const;
  void tell_status(std::uint32_t node) noexcept;  // from what was decided now

  std::vector<Obstacle> surfaces_;
  const std::vector<double>& mass_;
  Prescribed prescribed_;
  mutable std::shared_ptr<const Placement> known_;  // the last one asked for; null: none
  std::shared_ptr<const Placement> start_;          // of the step
  double rest_speed_ = 0.0;
  std::vector<std::uint8_t> fixed_, held_, touching_, constrained_, status_;
  std::vector<Touch> committed_, now_;
  // Without surfaces the rest is empty. Within a step: how often the sweeps changed their mind on a node, what they
  // last decided, its last surface, and how it slid.
  std::vector<std::uint8_t> changes_, stayed_, bounces_, braced_;
  // How often they changed their mind on which surfaces one slides, and those that it met beside.
  std::vector<std::uint8_t> slide_changes_;
  std::vector<std::vector<std::int32_t>> met_;
  std::vector<Slip> slip_phase_;
  std::vector<std::int32_t> last_surface_;
  std::vector<Vector3> slip_;
  std::vector<Vector3> impulse_, sweep_impulse_;
  std::vector<Vector3> surface_impulse_;  // [surface]
};

}  // namespace springnet
