#include "critical_time.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace springnet::recurrent {
namespace {

constexpr int most_iterations = 60, least_iterations = 10;
constexpr double accuracy = 0.01;  // change of the result in an iteration

// The greatest eigenvalue of A is at least the quotient of a vector, so its weight is at most this: of
// w^2 stiffness + w damping = 1 the positive solution.
double weight_of(double stiffness, double damping) {
  const double root = std::sqrt(damping * damping + 4.0 * std::max(stiffness, 0.0));
  return damping + root > 0.0 ? 2.0 / (damping + root) : std::numeric_limits<double>::infinity();
}

}  // namespace

double critical_weight(const sdk::Host& host, const Step& step) {
  const springnet_network& network = step.network;
  const std::size_t n = network.node_count;
  host.linearise(sdk::evaluation_at(step.from, step.start));
  std::vector<double> x(3 * n), zero(3 * n, 0.0), by_p(3 * n), by_v(3 * n);
  // Signs that no symmetry of a net shares, the same in every run.
  std::uint64_t bits = 0x9e3779b97f4a7c15u;
  for (double& value : x) {
    bits ^= bits << 13;
    bits ^= bits >> 7;
    bits ^= bits << 17;
    value = static_cast<double>(bits >> 11) * 0x1p-53 - 0.5;
  }
  const auto product = [&](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 3 * n; ++i) sum += network.mass[i % n] * a[i] * b[i];
    return sum;
  };
  double weight = step.weight();
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    if (step.constrained()) host.project(nullptr, x.data());
    const double square = product(x, x);
    if (!(square > 0.0)) return std::numeric_limits<double>::infinity();
    for (double& value : x) value /= std::sqrt(square);
    host.jacobian_times(x.data(), zero.data(), by_p.data());
    host.jacobian_times(zero.data(), x.data(), by_v.data());
    const double last = weight;
    weight = weight_of(-product(x, by_p), std::max(0.0, -product(x, by_v)));
    const double scale = std::isfinite(weight) ? weight : last;
    for (std::size_t i = 0; i < 3 * n; ++i) x[i] = -scale * (scale * by_p[i] + by_v[i]);
    if (iteration >= least_iterations && std::abs(weight - last) <= accuracy * weight) break;
  }
  return weight;
}

}  // namespace springnet::recurrent
