#include "force_rounding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "columns.hpp"

namespace springnet::recurrent {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr int draws = 5;
// Sweeps accumulate several roundings. (Measured: steps of stiff bodies stall at a fifth to a half of the result.)
constexpr double several = 2.0;

}  // namespace

void ForceRounding::find_sizes(const springnet_network& network, const springnet_state& at) {
  const std::uint32_t n = network.node_count;
  const auto norm = [](const springnet_vectors& v, std::uint32_t k) {
    return std::sqrt(v.x[k] * v.x[k] + v.y[k] * v.y[k] + v.z[k] * v.z[k]);
  };
  image_.resize(3 * std::size_t{n});
  double *sizes = image_.data(), *speeds = sizes + n;
  for (std::uint32_t k = 0; k < n; ++k) {
    sizes[k] = norm(at.position, k);
    speeds[k] = norm(at.velocity, k);
  }
  size_.assign(sizes, sizes + n);
  speed_.assign(speeds, speeds + n);
  for (std::uint32_t k = 0; k < n; ++k) {
    for (std::uint32_t i = network.neighbour_start[k]; i < network.neighbour_start[k + 1]; ++i) {
      size_[k] = std::max(size_[k], sizes[network.neighbours[i]]);
      speed_[k] = std::max(speed_[k], speeds[network.neighbours[i]]);
    }
  }
}

void ForceRounding::estimate(const Step& step, const springnet_state& at) {
  force_ = 0.0;
  node_ = no_node;
  const springnet_network& network = host_.network_with_neighbours();
  const std::size_t n = network.node_count;
  try {
    host_.linearise(sdk::evaluation_at(step.from, at));
  } catch (const sdk::Failure&) {
    return;
  }
  find_sizes(network, at);
  position_.resize(3 * n);
  velocity_.resize(3 * n);
  Greatest greatest;
  std::uint64_t bits = 0x9e3779b97f4a7c15u;  // the same in every run (xorshift; Marsaglia 2003)
  for (int draw = 0; draw < draws; ++draw) {
    for (std::size_t i = 0; i < 3 * n; ++i) {
      bits ^= bits << 13;
      bits ^= bits >> 7;
      bits ^= bits << 17;
      const double share = static_cast<double>(bits >> 11) * 0x1p-52 - 1.0;
      const std::size_t k = i % n;
      const bool is_pinned = network.fixed[k] != 0 || network.held[k] != 0;
      // First scale all lengths and volumes by eps: their own evaluation rounds, too.
      position_[i] = is_pinned ? 0.0 : draw == 0 ? eps * axes(at.position)[i / n][k] : share * eps * size_[k];
      velocity_[i] = is_pinned || draw == 0 ? 0.0 : share * eps * speed_[k];
    }
    host_.jacobian_times(position_.data(), velocity_.data(), image_.data());
    for (std::uint32_t k = 0; k < n; ++k) {
      const double x = image_[k], y = image_[n + k], z = image_[2 * n + k], m = network.mass[k];
      greatest.offer(m * m * (x * x + y * y + z * z), k, network.user_number);
    }
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    if (network.fixed[k] != 0) continue;
    const double inertia = network.mass[k] * eps * speed_[k] / step.time_constant;
    greatest.offer(inertia * inertia, k, network.user_number);
  }
  if (!std::isfinite(greatest.square)) return;
  force_ = several * std::sqrt(greatest.square);
  node_ = greatest.node;
}

}  // namespace springnet::recurrent
