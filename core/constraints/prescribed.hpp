// Nodes whose position the scene prescribes over time.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/network.hpp>

#include "constraints/sample_time.hpp"
#include "network/trajectory.hpp"

namespace springnet {

class Prescribed {
 public:
  Prescribed(const Network& network, const std::vector<std::uint32_t>& engine_number);

  [[nodiscard]] bool any() const noexcept { return !trajectories_.empty(); }
  [[nodiscard]] bool moves(std::uint32_t node) const noexcept { return any() && motion_of_[node] != none; }
  // All motions at a time, for the functions below.
  using Samples = std::vector<Trajectory::Sample>;
  [[nodiscard]] Samples at(const SampleTime& time) const;
  // For nodes with moves() only; m, m/s, m/s^2.
  [[nodiscard]] Vector3 position(const Samples& at, std::uint32_t node) const {
    return start_[node] + at[motion_of_[node]].displacement;
  }
  [[nodiscard]] const Vector3& velocity(const Samples& at, std::uint32_t node) const {
    return at[motion_of_[node]].velocity;
  }
  [[nodiscard]] const Vector3& acceleration(const Samples& at, std::uint32_t node) const {
    return at[motion_of_[node]].acceleration;
  }
  // The greatest of Trajectory::typical_speed(), m/s.
  [[nodiscard]] double typical_speed() const noexcept;
  // The next time after `time` at which a velocity or acceleration may jump; s.
  [[nodiscard]] double next_change(double time) const;
  // The next such time of a motion of the scene, not set by set().
  [[nodiscard]] double next_change_of_scene(double time) const;
  // set(): from now on the node follows `trajectory`, relative to `start` (m). stop(): its motion ends.
  void set(std::uint32_t node, const Vector3& start, Trajectory trajectory);
  void stop(std::uint32_t node);

 private:
  static constexpr std::uint32_t none = 0xffffffffu;

  std::size_t node_count_;
  std::vector<Trajectory> trajectories_;
  std::vector<std::uint8_t> told_;        // [trajectory] 1: set by set()
  std::vector<std::uint32_t> motion_of_;  // [node], empty without motions
  std::vector<Vector3> start_;            // [node] m, likewise
};

}  // namespace springnet
