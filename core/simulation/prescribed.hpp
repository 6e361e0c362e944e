// Nodes whose position the scene prescribes over time.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <springnet/network.hpp>

#include "network/trajectory.hpp"
#include "simulation/sample_time.hpp"

namespace springnet {

class Prescribed {
 public:
  Prescribed(const Network& network, const std::vector<std::uint32_t>& engine_number);

  [[nodiscard]] bool any() const noexcept { return !trajectories_.empty(); }
  [[nodiscard]] bool moves(std::uint32_t node) const noexcept { return any() && motion_of_[node] != none; }
  // Samples all motions; position(), velocity(), acceleration() are then those at that time.
  void set_time(const SampleTime& time);
  // Of a node that moves(); m, m/s, m/s^2.
  [[nodiscard]] Vector3 position(std::uint32_t node) const {
    return start_[node] + samples_[motion_of_[node]].displacement;
  }
  [[nodiscard]] const Vector3& velocity(std::uint32_t node) const { return samples_[motion_of_[node]].velocity; }
  [[nodiscard]] const Vector3& acceleration(std::uint32_t node) const {
    return samples_[motion_of_[node]].acceleration;
  }
  // The next time after `time` at which a velocity or acceleration may jump; s.
  [[nodiscard]] double next_change(double time) const;
  // From now on the node moves as `trajectory` says, from `start`; or it does not move any more.
  void set(std::uint32_t node, const Vector3& start, Trajectory trajectory);
  void stop(std::uint32_t node);

 private:
  static constexpr std::uint32_t none = 0xffffffffu;

  std::size_t node_count_;
  std::vector<Trajectory> trajectories_;
  std::vector<Trajectory::Sample> samples_;
  std::vector<std::uint32_t> motion_of_;  // [node], empty without motions
  std::vector<Vector3> start_;            // [node] m, likewise
  SampleTime time_{std::numeric_limits<double>::quiet_NaN(), 0.0};
};

}  // namespace springnet
