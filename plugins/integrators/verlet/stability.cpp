#include "stability.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

double Stability::limit(bool restarts) {
  mode_.clear();
  springnet::sdk::LinearisedNetwork network(host_);
  const std::optional<double> guess = network.first_guess();
  if (!guess) return std::numeric_limits<double>::infinity();
  if (!restarts) return limit_of(network, Form::lagging, *guess, std::numeric_limits<double>::infinity());
  const double damped = limit_of(network, Form::restarting_damping, *guess, std::numeric_limits<double>::infinity());
  const double both = limit_of(network, Form::restarting, *guess, damped);
  return std::isnan(both) ? both : std::min(both, damped);
}

std::uint32_t Stability::node() const {
  return mode_.empty() ? springnet::sdk::no_limit_node : springnet::sdk::LinearisedNetwork(host_).node_of(mode_);
}

double Stability::limit_of(springnet::sdk::LinearisedNetwork& network, Form form, double guess, double other) {
  std::vector<double> x = network.start(), damped(network.size());
  const auto apply = [&](double h, double* values) {
    // -(quadratic + linear), from products with dp and dv.
    const auto times = [&](double position_weight, double velocity_weight) {
      network.times(-position_weight, -velocity_weight, values);
    };
    switch (form) {
      case Form::lagging:
        times(0.25 * h * h, h);
        return;
      case Form::restarting_damping:
        times(0.0, 0.5 * h);
        return;
      case Form::restarting:
        break;
    }
    // h^2 (k - c^2) / 4 + h c / 2 with c = -da/dv: c is applied to h x / 2 - h^2 c x / 4.
    std::copy_n(values, network.size(), damped.data());
    network.times(0.0, -1.0, damped.data());
    for (std::size_t i = 0; i < damped.size(); ++i) damped[i] = 0.5 * h * values[i] - 0.25 * h * h * damped[i];
    network.times(0.0, -1.0, damped.data());
    network.times(-0.25 * h * h, 0.0, values);
    for (std::size_t i = 0; i < damped.size(); ++i) values[i] += damped[i];
  };
  const double h = springnet::sdk::critical_step(host_, guess, x, network.max_vectors(), apply);
  if (h < other) mode_ = std::move(x);
  return h;
}
