#include "network/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <springnet/sdk/math.hpp>
#include <springnet/sdk/table.hpp>

namespace springnet {

Trajectory::Trajectory(const Motion& motion) : motion_(motion) {
  if (motion_.displacements.empty()) {
    moves_ = !motion_.amplitude.isZero(0) && motion_.frequency > 0;
    return;
  }
  moves_ = std::any_of(motion_.displacements.begin(), motion_.displacements.end(),
                       [](const Vector3& displacement) { return !displacement.isZero(0); });
  if (motion_.interpolation == Motion::Interpolation::smooth) find_slopes();
}

// The first and the last slope are 0: the motion starts and ends at rest.
void Trajectory::find_slopes() {
  const std::vector<double>& t = motion_.times;
  const std::vector<Vector3>& y = motion_.displacements;
  slopes_.assign(t.size(), Vector3::Zero());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    sdk::monotone_slopes(
        t.size(), [&](std::size_t k) { return t[k]; },
        [&](std::size_t k) { return (y[k + 1][axis] - y[k][axis]) / (t[k + 1] - t[k]); },
        [&](std::size_t k) -> double& { return slopes_[k][axis]; });
  }
}

void Trajectory::archive(Archive& archive) {
  Motion motion = motion_;
  archive.below(motion.interpolation, 2, "an interpolation");
  const std::size_t count = archive.count(motion.times.size(), 4 * sizeof(double), "entries of a motion");
  motion.times.resize(count);
  motion.displacements.resize(count, Vector3::Zero());
  archive.numbers(motion.times.data(), count);
  for (Vector3& each : motion.displacements) archive.vector(each);
  archive.vector(motion.amplitude);
  for (double* each : {&motion.frequency, &motion.phase, &motion.from, &motion.until}) archive.number(*each);
  if (!archive.reads()) return;
  bool valid = motion.amplitude.allFinite() && motion.frequency >= 0.0 && std::isfinite(motion.frequency) &&
               std::isfinite(motion.phase) && std::isfinite(motion.from) && !std::isnan(motion.until);
  for (std::size_t k = 0; k < count; ++k)
    valid = valid && std::isfinite(motion.times[k]) && motion.displacements[k].allFinite() &&
            (k == 0 || motion.times[k] > motion.times[k - 1]);
  if (!valid) Archive::refuse("a motion is none");
  *this = Trajectory(motion);
}

Trajectory::Sample Trajectory::at(double time) const {
  if (!moves_) return {};
  return motion_.displacements.empty() ? on_sinusoid(time) : on_table(time);
}

Trajectory::Sample Trajectory::on_table(double time) const {
  const std::vector<double>& t = motion_.times;
  const std::vector<Vector3>& y = motion_.displacements;
  Sample sample;
  if (time < t.front()) {
    sample.displacement = y.front();
    return sample;
  }
  const auto after = static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), time) - t.begin());
  if (after == t.size()) {
    sample.displacement = y.back();
    return sample;
  }
  const std::size_t k = after - 1;
  const double h = t[after] - t[k], s = (time - t[k]) / h;
  if (motion_.interpolation == Motion::Interpolation::linear) {
    const Vector3 step = y[after] - y[k];
    sample.displacement = y[k] + s * step;
    sample.velocity = step / h;
    return sample;
  }
  const auto [start, linear, square, cube] = piece(k);
  sample.displacement = start + s * (linear + s * (square + s * cube));
  sample.velocity = (linear + s * (2 * square + 3 * s * cube)) / h;
  sample.acceleration = (2 * square + 6 * s * cube) / (h * h);
  return sample;
}

// Hermite's cubic, y = y_k + h m_k s + (3 Δ - h (2 m_k + m_k+1)) s^2 + (h (m_k + m_k+1) - 2 Δ) s^3.
Trajectory::Cubic Trajectory::piece(std::size_t first) const {
  const std::size_t after = first + 1;
  const double h = motion_.times[after] - motion_.times[first];
  const Vector3 &start = motion_.displacements[first], step = motion_.displacements[after] - start;
  if (slopes_.empty()) return {start, step, Vector3::Zero(), Vector3::Zero()};
  return {start, h * slopes_[first], 3 * step - h * (2 * slopes_[first] + slopes_[after]),
          h * (slopes_[first] + slopes_[after]) - 2 * step};
}

// The mean of s^n between a and b is sum_i a^i b^(n-i) / (n + 1): no cancellation, however short the interval.
Vector3 Trajectory::mean(double from, double until) const {
  if (!moves_) return Vector3::Zero();
  const std::vector<double>& t = motion_.times;
  if (!(from < until)) return at(from).displacement;
  Vector3 sum = Vector3::Zero();
  const auto add = [&](double begin, double end, const Vector3& mean_of_part) {
    sum += (end - begin) / (until - from) * mean_of_part;
  };
  if (from < t.front()) add(from, std::min(until, t.front()), motion_.displacements.front());
  const auto after = std::upper_bound(t.begin(), t.end(), from) - t.begin();
  for (auto k = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - 1, 0)); k + 1 < t.size() && t[k] < until;
       ++k) {
    const double begin = std::max(from, t[k]), end = std::min(until, t[k + 1]), h = t[k + 1] - t[k];
    const double a = (begin - t[k]) / h, b = (end - t[k]) / h;
    const auto [start, linear, square, cube] = piece(k);
    add(begin, end,
        start + (a + b) / 2 * linear + (a * a + a * b + b * b) / 3 * square + (a + b) * (a * a + b * b) / 4 * cube);
  }
  if (until > t.back()) add(std::max(from, t.back()), until, motion_.displacements.back());
  return sum;
}

Trajectory::Sample Trajectory::on_sinusoid(double time) const {
  Sample sample;
  if (time < motion_.from) return sample;
  const double rate = 2 * std::numbers::pi * motion_.frequency;  // rad/s
  const bool over = time >= motion_.until;
  const double angle = rate * ((over ? motion_.until : time) - motion_.from) + motion_.phase;
  sample.displacement = motion_.amplitude * (sdk::sin(angle) - sdk::sin(motion_.phase));
  if (over) return sample;
  sample.velocity = motion_.amplitude * (rate * sdk::cos(angle));
  sample.acceleration = motion_.amplitude * (-rate * rate * sdk::sin(angle));
  return sample;
}

double Trajectory::angular_frequency(double time) const noexcept {
  const bool oscillates = moves_ && motion_.displacements.empty() && time >= motion_.from && time < motion_.until;
  return oscillates ? 2.0 * std::numbers::pi * motion_.frequency : 0.0;
}

double Trajectory::typical_speed() const noexcept {
  if (!moves_) return 0.0;
  const std::vector<Vector3>& y = motion_.displacements;
  if (y.empty()) return 2.0 * std::numbers::pi * motion_.frequency * motion_.amplitude.norm();
  double speed = 0.0;
  for (std::size_t k = 1; k < y.size(); ++k)
    speed = std::max(speed, (y[k] - y[k - 1]).norm() / (motion_.times[k] - motion_.times[k - 1]));
  return speed;
}

double Trajectory::next_change(double time) const {
  constexpr double never = std::numeric_limits<double>::infinity();
  if (!moves_) return never;
  if (motion_.displacements.empty()) {
    if (time < motion_.from) return motion_.from;
    return time < motion_.until ? motion_.until : never;
  }
  if (motion_.times.size() == 1) return never;
  const auto next = std::upper_bound(motion_.times.begin(), motion_.times.end(), time);
  return next == motion_.times.end() ? never : *next;
}

}  // namespace springnet
