#include "network/turning.hpp"

#include <algorithm>

namespace springnet {

Turning::Turning(const Turn& turn) : rate_(turn.rate), from_(turn.from), until_(turn.until) {
  if (turn.angles.empty()) return;
  Motion motion;
  motion.interpolation = turn.interpolation;
  motion.times = turn.times;
  for (const double angle : turn.angles) motion.displacements.emplace_back(angle, 0.0, 0.0);
  table_ = Trajectory(motion);
}

Turning::Sample Turning::at(double time) const {
  if (rate_ == 0.0) {
    const Trajectory::Sample sample = table_.at(time);
    return {sample.displacement[0], sample.velocity[0], sample.acceleration[0]};
  }
  const bool now = time >= from_ && time < until_;
  return {rate_ * (std::clamp(time, from_, until_) - from_), now ? rate_ : 0.0, 0.0};
}

double Turning::next_change(double time) const {
  if (rate_ == 0.0) return table_.next_change(time);
  if (time < from_) return from_;
  return time < until_ ? until_ : std::numeric_limits<double>::infinity();
}

}  // namespace springnet
