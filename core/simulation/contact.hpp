// Unilateral contact without restitution of nodes with planes, spheres and capsules that may move. The paper's rule: a
// node that crosses is held where it touched until a reverse force occurs; without friction, or with Coulomb's, it
// slides. The same state and decisions serve the sweeps of the recurrent network and the events of the reference.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

#include "simulation/friction.hpp"
#include "simulation/prescribed.hpp"
#include "simulation/state.hpp"
#include "simulation/surface.hpp"

namespace springnet {

// How one node is in contact.
struct Touch {
  std::int32_t surface = -1;  // -1: none
  bool slides = false;        // else the surface takes it along
  std::int32_t second = -1;   // the reference: it slid on this one until it met the other, and is held by both
  friend bool operator==(const Touch&, const Touch&) = default;
};

// What moved nodes did between two commits, by node.
struct ContactChanges {
  std::vector<std::uint32_t> touched, released, slipped, stuck;
};

class Contact {
 public:
  Contact(const Network& network, const std::vector<std::uint32_t>& user_number,
          const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass);

  [[nodiscard]] const std::vector<Surface>& surfaces() const noexcept { return surfaces_; }
  // Whether a surface holds what touches it.
  [[nodiscard]] bool any_holds() const noexcept;
  // For messages, as "plane 'floor' (number 0)".
  [[nodiscard]] std::string name_of(std::size_t surface) const;
  void set_trajectory(std::size_t surface, Trajectory trajectory);
  [[nodiscard]] Prescribed& prescribed() noexcept { return prescribed_; }
  [[nodiscard]] const Prescribed& prescribed() const noexcept { return prescribed_; }

  // Where surfaces and moved nodes are from now on, for all functions below.
  void set_time(const SampleTime& time);
  // The next time after `time` at which something that moves changes its velocity or acceleration by a jump; s.
  [[nodiscard]] double next_change(double time) const;

  // 1: fixed or moved by the scene; as committed held by a surface; held or sliding.
  [[nodiscard]] const std::vector<std::uint8_t>& fixed() const noexcept { return fixed_; }
  [[nodiscard]] const std::vector<std::uint8_t>& held() const noexcept { return held_; }
  [[nodiscard]] const std::vector<std::uint8_t>& touching() const noexcept { return touching_; }
  // Fixed, or held by a surface as the last sweep of a step, or the last commit, left it.
  [[nodiscard]] const std::vector<std::uint8_t>& constrained() const noexcept { return constrained_; }
  [[nodiscard]] const Touch& committed(std::uint32_t node) const noexcept { return committed_[node]; }
  [[nodiscard]] const Touch& now(std::uint32_t node) const noexcept { return now_[node]; }
  [[nodiscard]] Vector3 impulse(std::uint32_t node) const;

  // Of a surface at the time set. Distance > 0 on the free side, m.
  [[nodiscard]] double distance(std::size_t surface, const Vector3& position) const {
    return surfaces_[surface].distance(position - placement_[surface].displacement);
  }
  [[nodiscard]] Vector3 normal(std::size_t surface, const Vector3& position) const {
    return surfaces_[surface].normal(position - placement_[surface].displacement);
  }
  [[nodiscard]] const Trajectory::Sample& placement(std::size_t surface) const { return placement_[surface]; }
  // How fast the distance of a node that moves with the surface's velocity + `relative` (m/s) grows faster and faster,
  // m/s^2: the part of its second derivative that is none of the accelerations'.
  [[nodiscard]] double turning(std::size_t surface, const Vector3& position, const Vector3& relative) const;
  // Onto the surface, along its normal.
  [[nodiscard]] Vector3 onto(std::size_t surface, const Vector3& position) const;

  void set_fixed(std::uint32_t node, bool fixed);
  // Makes or changes a contact, of the committed state; the impulse (N s) counts.
  void touch(std::uint32_t node, const Touch& touch, const Vector3& impulse);
  void release(std::uint32_t node);
  // Slip that is slower counts as none, m/s.
  [[nodiscard]] double rest_speed() const noexcept { return rest_speed_; }
  void set_rest_speed(double speed) noexcept { rest_speed_ = speed; }
  // Where a sliding node goes, or began to go: the direction that friction acts against when it is at rest.
  [[nodiscard]] const Vector3& slip(std::uint32_t node) const { return slip_[node]; }
  // That of the nodes that slide now, at these velocities.
  void note_slips(const springnet_const_vectors& position, const springnet_const_vectors& velocity);
  void set_slip(std::uint32_t node, const Vector3& direction) { slip_[node] = direction; }

  // ---- within a step ----
  // The step starts from the committed contacts, at the time set.
  void begin_step();
  // Puts the outputs of nodes [first, first + count) where fixation and surfaces allow; nodes of `cluster` (null: none)
  // other than 0xffffffff are left to those that know their rigid connections. `acceleration` is [count], their
  // neurons' at the outputs that the sweep reads, m/s^2; the sweep's arrays are of all nodes. The decisions become the
  // state of the contacts with commit_sweep().
  void constrain(std::uint32_t first, std::uint32_t count, const double* const acceleration[3],
                 const springnet_sweep& sweep, const std::uint32_t* cluster);
  // For those: where a node that the scene moves or fixes is, its velocity there; true if it is such a node.
  bool constrain_fixed(std::uint32_t node, const springnet_sweep& sweep) const;
  // The earliest surface that a node meets on its way through the step, and at what share of it.
  struct Meeting {
    std::int32_t surface = -1;
    double share = 0.0;
  };
  [[nodiscard]] Meeting first_meeting(const Vector3& start, const Vector3& end, std::int32_t except = -1) const;
  // A node that slides on `surface` to `end`, with its velocity there: the other surface that it runs into; -1: none.
  // It is held there, having nowhere to go but along both.
  [[nodiscard]] Meeting second_meeting(const Vector3& start, const Vector3& end, const Vector3& velocity,
                                       std::int32_t surface) const;
  // Whether a node that was undecided may be held at its last surface, though it does not meet it on its way.
  [[nodiscard]] bool could_reach(std::uint32_t node, const Vector3& start, const Vector3& end) const;
  [[nodiscard]] bool leaves(std::int32_t surface, const Vector3& velocity, const Vector3& position) const;
  // Where a node that met a surface is, at the end of the step, if it is taken along from there on.
  [[nodiscard]] Vector3 taken_along(const Vector3& start, const Vector3& end, const Meeting& meeting) const;
  // Where a node is at the end of a step that started in contact and was taken along.
  [[nodiscard]] Vector3 carried(const Vector3& start, std::int32_t surface) const;
  // The rule is discontinuous: a node that touches stops, which changes the forces on it by what dampers did, so that
  // it may not touch any more; then it moves, and touches. No state is a fixed point of that. Tells what is decided
  // for a node; true: it changed its mind too often in this step and stays in contact.
  bool undecided(std::uint32_t node, bool stays);
  [[nodiscard]] bool is_undecided(std::uint32_t node) const noexcept;
  void decide(std::uint32_t node, const Touch& touch, const Vector3& impulse);
  [[nodiscard]] std::int32_t last_surface(std::uint32_t node) const noexcept { return last_surface_[node]; }

  // The decisions of the last sweep become the contacts.
  void commit_sweep(ContactChanges& changes);
  // The decisions of sweeps that were not committed are forgotten.
  void forget_sweep();

  // Takes out of accelerations (m/s^2, arrays from node `first`) of nodes [first, first + count) what fixation and
  // surfaces do not allow, and puts in friction; nodes of `cluster` are left.
  void accelerate(std::uint32_t first, std::uint32_t count, const springnet_const_vectors& position,
                  const springnet_const_vectors& velocity, double* const acceleration[3],
                  const std::uint32_t* cluster) const;
  // How a node slips on its surface, m/s, and the direction of that.
  [[nodiscard]] Vector3 slip_vector(std::uint32_t node, const Vector3& normal, const Vector3& relative) const;
  [[nodiscard]] Vector3 slip_direction(std::uint32_t node, const Vector3& normal, const Vector3& relative) const;

 private:
  struct Candidate;
  void constrain_node(std::uint32_t node, const Vector3& acceleration, const springnet_sweep& sweep);
  void meet(std::uint32_t node, const Candidate& candidate, const springnet_sweep& sweep);
  void slide(std::uint32_t node, std::int32_t surface, const ContactAnswer& answer, const Candidate& candidate,
             const springnet_sweep& sweep, bool is_new);
  void stop_between(std::uint32_t node, std::int32_t surface, const Meeting& second, const Vector3& end,
                    const Candidate& candidate, const springnet_sweep& sweep);
  [[nodiscard]] ContactAnswer answer(std::int32_t surface, const Candidate& candidate, const Vector3& position) const;
  void refresh(std::uint32_t node);

  std::vector<Surface> surfaces_;
  const std::vector<double>& mass_;
  Prescribed prescribed_;
  std::vector<Trajectory::Sample> placement_, start_placement_;  // [surface] at the time set, at the step's start
  double rest_speed_ = 0.0;
  SampleTime time_{std::numeric_limits<double>::quiet_NaN(), 0.0};
  std::vector<std::uint8_t> fixed_, held_, touching_, constrained_;
  std::vector<Touch> committed_, now_;
  // Without surfaces the rest is empty. Within a step: how often the sweeps changed their mind on a node, what they
  // last decided, its last surface, and how it slid.
  std::vector<std::uint8_t> changes_, stayed_;
  std::vector<std::int32_t> last_surface_;
  std::vector<Vector3> slip_;
  std::vector<Vector3> impulse_, sweep_impulse_;
};

}  // namespace springnet
