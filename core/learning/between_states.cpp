#include "learning/between_states.hpp"

#include <algorithm>
#include <cmath>

namespace springnet::learning {

namespace {

// States and observations at the same time differ by the rounding of their sums.
constexpr double same_time = 1e-9;  // of a step

// Cubic Hermite polynomials at a share s of a step of length h: of x, h x', x and h x' of its ends.
void set_weights(double s, double h, bool rate, double (&p)[2], double (&v)[2]) {
  if (rate) {
    p[0] = 6.0 * s * (s - 1.0) / h;
    p[1] = -p[0];
    v[0] = (1.0 - s) * (1.0 - 3.0 * s);
    v[1] = s * (3.0 * s - 2.0);
    return;
  }
  p[0] = (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s);
  p[1] = s * s * (3.0 - 2.0 * s);
  v[0] = h * s * (1.0 - s) * (1.0 - s);
  v[1] = h * s * s * (s - 1.0);
}

}  // namespace

Between between_states(const std::vector<double>& state_times, double time, bool rate) {
  const auto after = std::upper_bound(state_times.begin(), state_times.end(), time);
  const auto last = static_cast<std::ptrdiff_t>(state_times.size()) - 2;
  Between at;
  at.state = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - state_times.begin() - 1, 0, last));
  const double h = state_times[at.state + 1] - state_times[at.state];
  at.share = (time - state_times[at.state]) / h;
  if (std::abs(at.share - std::round(at.share)) <= same_time) at.share = std::round(at.share);
  set_weights(at.share, h, rate, at.p, at.v);
  return at;
}

Eigen::Matrix3Xd vectors_at(const MotionDerivatives& motion, const Between& at) {
  Eigen::Matrix3Xd result = at.p[0] * motion.positions(at.state);
  result += at.p[1] * motion.positions(at.state + 1);
  result += at.v[0] * motion.velocities(at.state);
  result += at.v[1] * motion.velocities(at.state + 1);
  return result;
}

}  // namespace springnet::learning
