// Random points at which laws are evaluated.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "jacobian_call.hpp"

namespace springnet::test {

// Lengths and the volume of a tetrahedron, or the lengths of a triangle, by a law's list.
inline std::vector<double> scalars(const springnet_law& law, const std::vector<std::array<double, 3>>& p) {
  const auto minus = [&](std::uint32_t a, std::uint32_t b) {
    return std::array{p[a][0] - p[b][0], p[a][1] - p[b][1], p[a][2] - p[b][2]};
  };
  std::vector<double> values;
  for (std::uint32_t i = 0; i < law.invariant_count; ++i) {
    const springnet_invariant& one = *law.invariants[i];
    const auto u = minus(one.corners[1], one.corners[0]);
    if (one.kind == SPRINGNET_LENGTH) {
      values.push_back(std::hypot(u[0], u[1], u[2]));
    } else if (one.kind == SPRINGNET_VOLUME) {
      const auto v = minus(one.corners[2], one.corners[0]), w = minus(one.corners[3], one.corners[0]);
      values.push_back((u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
                        u[2] * (v[0] * w[1] - v[1] * w[0])) /
                       6.0);
    } else {
      values.push_back(0.3);  // an angle
    }
  }
  return values;
}

// A random point of all columns: values near the references, parameters within their bounds.
inline std::vector<double> random_point(const JacobianCall& call, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<double> at(call.layout.columns(true), 0.0);
  const auto sides = [&](double spread) {
    std::vector<std::array<double, 3>> corners{{0, 0, 0}, {1, 0.1, 0}, {0.2, 1.1, 0.1}, {0.3, 0.2, 0.9}};
    for (auto& corner : corners)
      for (double& x : corner) x += spread * (unit(random) - 0.5);
    return scalars(*call.law, corners);
  };
  if (call.several) {
    const std::vector<double> rest = sides(0.2), now = sides(0.5), start = sides(0.5);
    for (std::size_t i = 0; i < call.layout.invariants; ++i) {
      at[call.layout.reference(i)] = rest[i];
      at[call.layout.value(i)] = now[i];
      at[call.layout.start_value(i)] = start[i];
      at[call.layout.rate(i)] = unit(random) - 0.5;
      at[call.layout.start_rate(i)] = unit(random) - 0.5;
    }
  } else {
    at[call.layout.reference()] = 1.0 + 0.2 * unit(random);
    at[call.layout.value()] = 1.05 + 0.4 * unit(random);
    at[call.layout.start_value()] = 1.0 + 0.4 * unit(random);
    at[call.layout.rate()] = 0.1 + 0.3 * unit(random);
    at[call.layout.start_rate()] = 0.1 + 0.3 * unit(random);
  }
  const auto within = [&](const springnet_parameter& p) {
    const double low = std::max(p.smallest, -0.8), high = std::min(p.largest, low + 1.5);
    return low + (0.15 + 0.7 * unit(random)) * (high - low);
  };
  for (std::size_t i = 0; i < call.layout.parameters; ++i) {
    const springnet_parameter& parameter = *call.component->parameters[i];
    double& value = at[call.layout.parameter(i)];
    value = within(parameter);
    if (parameter.type != SPRINGNET_NUMBER) value = unit(random) < 0.5 ? 0.0 : 1.0;
    if (std::string(parameter.name) == "poisson_ratio") value = -0.4 + 0.85 * unit(random);
  }
  for (std::size_t i = 0; i < call.layout.states; ++i) at[call.layout.state(i)] = 0.1 * within(*call.law->states[i]);
  for (std::size_t i = 0; i < call.layout.inputs; ++i) {
    at[call.layout.input(i)] = within(*call.law->inputs[i]);
    at[call.layout.start_input(i)] = within(*call.law->inputs[i]);
  }
  at[call.layout.time()] = unit(random);
  for (std::size_t i = 0; i < 3; ++i) at[call.layout.direction(i)] = 0.2 + unit(random);
  return at;
}

}  // namespace springnet::test
