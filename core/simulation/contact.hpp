// Unilateral contact with planes, the paper's rule: a node that crosses is held where it touched until a reverse force
// occurs. The same state and decisions serve the sweeps of the recurrent network and the events of the reference.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

#include "simulation/state.hpp"

namespace springnet {

class Contact {
 public:
  Contact(const Network& network, const std::vector<std::uint32_t>& user_number, const std::vector<double>& mass);

  [[nodiscard]] const std::vector<Plane>& planes() const noexcept { return planes_; }
  [[nodiscard]] const std::vector<std::uint8_t>& fixed() const noexcept { return fixed_; }
  [[nodiscard]] const std::vector<std::uint8_t>& held() const noexcept { return held_flag_; }
  // Fixed or held.
  [[nodiscard]] const std::vector<std::uint8_t>& constrained() const noexcept { return constrained_; }
  [[nodiscard]] std::int32_t plane_of(std::uint32_t node) const noexcept { return plane_of_[node]; }  // -1: free
  [[nodiscard]] Vector3 impulse(std::uint32_t node) const;

  // Distance from a plane, > 0 on the free side; m.
  [[nodiscard]] double distance(std::size_t plane, const Vector3& position) const noexcept {
    return planes_[plane].normal.dot(position - planes_[plane].point);
  }

  void set_fixed(std::uint32_t node, bool fixed);
  void hold(std::uint32_t node, std::int32_t plane, const Vector3& impulse);
  void release(std::uint32_t node);

  // Whether a node cannot move freely: as committed, or, once a sweep was done, as that sweep left it.
  [[nodiscard]] bool stays(std::uint32_t node, bool swept) const noexcept {
    if (!swept || planes_.empty()) return constrained_[node] != 0;
    return fixed_[node] != 0 || next_plane_[node] >= 0;
  }
  // Within a sweep: puts the outputs of nodes [first, first + count) where fixation and surfaces allow. `force` is
  // [count]; the others are of all nodes. The decisions become the state of the contacts with commit_sweep().
  void constrain(std::uint32_t first, std::uint32_t count, const double* const force[3],
                 const springnet_const_vectors& start, const springnet_vectors& position,
                 const springnet_vectors& velocity);
  // Before the sweeps of a step.
  void begin_step();
  // Nodes touched and released by the last sweep; one that went from a plane to another is both.
  void commit_sweep(std::vector<std::uint32_t>& touched, std::vector<std::uint32_t>& released);

 private:
  // What a sweep decided for a node, against the sweep before. True: it cannot make up its mind, and is held.
  bool undecided(std::uint32_t node, bool stays);
  void constrain_free(std::uint32_t node, const Vector3& start, const springnet_vectors& position,
                      const springnet_vectors& velocity);

  std::vector<Plane> planes_;
  const std::vector<double>& mass_;
  std::vector<std::uint8_t> fixed_, held_flag_, constrained_;
  std::vector<std::int32_t> plane_of_, next_plane_;
  // Within a step: how often the sweeps changed their mind on a node, what they last decided, and its last plane.
  std::vector<std::uint8_t> changes_, stayed_;
  std::vector<std::int32_t> last_plane_;
  std::vector<Vector3> place_;                    // where a node that could not make up its mind is held
  std::vector<Vector3> impulse_, sweep_impulse_;  // empty without planes
};

}  // namespace springnet
