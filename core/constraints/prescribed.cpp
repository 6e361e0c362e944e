#include "constraints/prescribed.hpp"

#include <algorithm>
#include <limits>

namespace springnet {

Prescribed::Prescribed(const Network& network, const std::vector<std::uint32_t>& engine_number)
    : node_count_(engine_number.size()) {
  for (const Move& move : network.moves()) {
    trajectories_.emplace_back(move.motion);
    for (const NodeIndex user : move.nodes) {
      motion_of_.resize(node_count_, none);
      start_.resize(node_count_);
      const std::uint32_t k = engine_number[user];
      motion_of_[k] = static_cast<std::uint32_t>(trajectories_.size() - 1);
      start_[k] = network.nodes()[user].position;
    }
  }
  if (motion_of_.empty()) trajectories_.clear();  // no motion has a node
  told_.assign(trajectories_.size(), 0);
}

Prescribed::Samples Prescribed::at(const SampleTime& time) const {
  Samples samples;
  samples.reserve(trajectories_.size());
  for (const Trajectory& trajectory : trajectories_) samples.push_back(sample(trajectory, time));
  return samples;
}

double Prescribed::typical_speed() const noexcept {
  double speed = 0.0;
  for (const Trajectory& trajectory : trajectories_) speed = std::max(speed, trajectory.typical_speed());
  return speed;
}

double Prescribed::next_change(double time) const {
  double next = std::numeric_limits<double>::infinity();
  for (const Trajectory& trajectory : trajectories_) next = std::min(next, trajectory.next_change(time));
  return next;
}

double Prescribed::next_change_of_scene(double time) const {
  double next = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < trajectories_.size(); ++i)
    if (told_[i] == 0) next = std::min(next, trajectories_[i].next_change(time));
  return next;
}

void Prescribed::set(std::uint32_t node, const Vector3& start, Trajectory trajectory) {
  motion_of_.resize(node_count_, none);
  start_.resize(node_count_);
  // Reuse the slot of the node's last motion: a host may move a node at every frame.
  const std::uint32_t old = motion_of_[node];
  const bool alone = old != none && std::count(motion_of_.begin(), motion_of_.end(), old) == 1;
  if (!alone) {
    motion_of_[node] = static_cast<std::uint32_t>(trajectories_.size());
    trajectories_.emplace_back();
    told_.push_back(1);
  }
  told_[motion_of_[node]] = 1;
  trajectories_[motion_of_[node]] = std::move(trajectory);
  start_[node] = start;
}

void Prescribed::stop(std::uint32_t node) {
  if (any()) motion_of_[node] = none;
}

}  // namespace springnet
