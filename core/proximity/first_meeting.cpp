#include "proximity/first_meeting.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace springnet::proximity {

namespace {

// Spans that are tried before the search gives up and reports the time it has come to. Of two million motions by
// chance, degenerate ones among them, none took 100, and the mean was 3.
constexpr int most_spans = 2000;
constexpr double least_span = 1e-16;

class MovingPair {
 public:
  MovingPair(PairKind kind, const std::array<Vector3, 4>& start, const std::array<Vector3, 4>& end) : kind_(kind) {
    const int first = first_nodes(kind), second = second_nodes(kind);
    for (int i = 0; i < first + second; ++i) {
      const auto k = static_cast<std::size_t>(i);
      start_[k] = start[k] - start[0];
      move_[k] = end[k] - start[k];
    }
    // Without what all have in common: a fast motion of both costs no digits.
    const Vector3 common = move_[0];
    for (int i = 0; i < first + second; ++i) move_[static_cast<std::size_t>(i)] -= common;
    for (int i = 0; i < first; ++i)
      for (int j = first; j < first + second; ++j) {
        const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
        difference_[count_] = start[a] - start[b];
        motion_[count_] = move_[a] - move_[b];
        extent_ = std::max({extent_, difference_[count_].cwiseAbs().maxCoeff(), motion_[count_].cwiseAbs().maxCoeff()});
        is_finite_ = is_finite_ && difference_[count_].allFinite() && motion_[count_].allFinite();
        ++count_;
      }
  }

  [[nodiscard]] bool is_finite() const noexcept { return is_finite_; }
  // Greatest component of a difference of nodes of both primitives or of its change, m.
  [[nodiscard]] double extent() const noexcept { return extent_; }

  [[nodiscard]] Separation at(double time) const {
    std::array<Vector3, 4> x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = start_[i] + time * move_[i];
    return separation(kind_, x);
  }

  // Speed at which the closest points approach, m per step.
  [[nodiscard]] double approach(const Separation& separation) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
      if (separation.weights[i] != 0.0) sum -= separation.weights[i] * separation.direction.dot(move_[i]);
    return sum;
  }

  // The time until which the distance is greater than `least` because it is along `direction`; `time` if it is not now.
  [[nodiscard]] double clear_until(double time, const Vector3& direction, double least) const {
    double until = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < count_; ++k) {
      const double speed = direction.dot(motion_[k]), room = direction.dot(difference_[k]) + time * speed - least;
      if (!(room > 0.0)) return time;
      if (speed < 0.0) until = std::min(until, time - room / speed);
    }
    return until;
  }

  // The distance is greater than `least` from `from` to `to` because it is along a direction that goes linearly from
  // `first` to `last`.
  [[nodiscard]] bool is_clear_between(double from, const Vector3& first, double to, const Vector3& last,
                                      double least) const {
    for (std::size_t k = 0; k < count_; ++k) {
      const Vector3 before = difference_[k] + from * motion_[k], after = difference_[k] + to * motion_[k];
      const double b0 = first.dot(before) - least, b2 = last.dot(after) - least;
      const double b1 = 0.5 * (first.dot(after) + last.dot(before)) - least;
      if (!(b0 > 0.0 && b2 > 0.0)) return false;
      // b0 (1-u)^2 + 2 b1 u (1-u) + b2 u^2 > 0 for all u in [0, 1]
      if (!(b1 >= 0.0 || b1 * b1 < b0 * b2)) return false;
    }
    return true;
  }

 private:
  PairKind kind_;
  std::size_t count_ = 0;
  double extent_ = 0.0;
  bool is_finite_ = true;
  std::array<Vector3, 4> start_{Vector3::Zero(), Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  std::array<Vector3, 4> move_ = start_;
  std::array<Vector3, 4> difference_, motion_;  // [count_] of nodes of both primitives
};

}  // namespace

std::optional<Meeting> first_meeting(PairKind kind, const std::array<Vector3, 4>& start,
                                     const std::array<Vector3, 4>& end, double thickness) {
  const MovingPair pair(kind, start, end);
  if (!pair.is_finite()) return std::nullopt;
  // Rounding of a product with a direction: three products and their sum, of differences that are rounded themselves.
  const double rounding = 32.0 * std::numeric_limits<double>::epsilon() * pair.extent();
  const double least_tolerance = 1e-12 * pair.extent();
  double time = 0.0, watched = thickness, tolerance = std::max(1e-4 * thickness, least_tolerance);
  Separation now = pair.at(0.0);
  if (now.distance <= thickness + tolerance) {
    watched = kept_share * now.distance;
    tolerance = std::max(1e-4 * watched, least_tolerance);
    if (!(now.distance > watched + tolerance)) return Meeting{0.0, now, true};
  }
  const double least = watched + rounding;
  double span = 1.0;  // that is tried next
  for (int spans = 0; spans < most_spans; ++spans) {
    const double clear = pair.clear_until(time, now.direction, least);
    if (clear > 1.0) return std::nullopt;
    // Where the closest points would come to within half the tolerance if they went on as they do.
    const double speed = pair.approach(now);
    double next = std::min(1.0, time + span);
    if (speed > 0.0) next = std::min(next, time + (now.distance - watched - 0.5 * tolerance) / speed);
    if (next > clear) {
      const Separation then = pair.at(next);
      if (then.distance > least && pair.is_clear_between(time, now.direction, next, then.direction, least)) {
        span = 2.0 * (next - time);
        time = next;
        now = then;
        if (now.distance <= watched + tolerance) break;
        if (time >= 1.0) return std::nullopt;
        continue;
      }
      span = 0.5 * (next - time);
      if (time + span > clear && span > least_span) continue;
    }
    if (!(clear > time)) break;  // rounding hides the plane between the primitives
    span = std::max(span, 2.0 * (clear - time));
    time = clear;
    now = pair.at(time);
    if (now.distance <= watched + tolerance) break;
  }
  return Meeting{time, now, false};
}

}  // namespace springnet::proximity
