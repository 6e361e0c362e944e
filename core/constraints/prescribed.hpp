// Nodes whose position the scene prescribes over time.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <springnet/network.hpp>

#include "constraints/sample_time.hpp"
#include "layers/numbers_before.hpp"
#include "network/trajectory.hpp"
#include "text/archive.hpp"

namespace springnet {

class Prescribed {
 public:
  Prescribed(const Network& network, const std::vector<std::uint32_t>& engine_number);

  [[nodiscard]] bool any() const noexcept { return !now_.trajectories.empty(); }
  [[nodiscard]] bool moves(std::uint32_t node) const noexcept { return any() && now_.motion_of[node] != none; }
  // All motions at a time, for the functions below.
  using Samples = std::vector<Trajectory::Sample>;
  [[nodiscard]] Samples at(const SampleTime& time) const;
  // For nodes with moves() only; m, m/s, m/s^2.
  [[nodiscard]] Vector3 position(const Samples& at, std::uint32_t node) const {
    return now_.start[node] + at[now_.motion_of[node]].displacement;
  }
  [[nodiscard]] const Vector3& velocity(const Samples& at, std::uint32_t node) const {
    return at[now_.motion_of[node]].velocity;
  }
  [[nodiscard]] const Vector3& acceleration(const Samples& at, std::uint32_t node) const {
    return at[now_.motion_of[node]].acceleration;
  }
  // The motion of a node with moves(): nodes with the same number follow the same.
  [[nodiscard]] std::uint32_t number_of(std::uint32_t node) const noexcept { return now_.motion_of[node]; }
  [[nodiscard]] const Trajectory& trajectory(std::uint32_t number) const { return now_.trajectories[number]; }
  // The greatest of Trajectory::typical_speed(), m/s.
  [[nodiscard]] double typical_speed() const noexcept;
  // The next time after `time` at which a velocity or acceleration may jump; s.
  [[nodiscard]] double next_change(double time) const;
  // The next such time of a motion of the scene, not set by set().
  [[nodiscard]] double next_change_of_scene(double time) const;
  // set(): from now on the node follows `trajectory`, relative to `start` (m). stop(): its motion ends.
  void set(std::uint32_t node, const Vector3& start, Trajectory trajectory);
  void stop(std::uint32_t node);
  // Motions in progress, and where they began, of the network before it was extended.
  void take_over(const Prescribed& before, const layers::NumbersBefore& numbers);
  // Motions set by set(), and which node follows which.
  void archive(Archive& archive);

 private:
  static constexpr std::uint32_t none = 0xffffffffu;

  struct Motions {
    std::vector<Trajectory> trajectories;
    std::vector<std::uint8_t> told;        // [trajectory] 1: set by set()
    std::vector<std::uint32_t> motion_of;  // [node], empty without motions
    std::vector<Vector3> start;            // [node] m, likewise
  };
  void change();

  std::size_t node_count_;
  Motions now_;
  std::unique_ptr<const Motions> of_scene_;  // null: nothing has changed since the start
};

}  // namespace springnet
