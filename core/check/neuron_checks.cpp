#include "check/neuron_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "check/child.hpp"
#include "check/points.hpp"
#include "check/quadrature.hpp"

namespace springnet::check {
namespace {

// What a neuron reads of one node: force, position, velocity (3 each), mass, time, parameters.
enum : std::size_t { force = 0, position = 3, velocity = 6, mass = 9, time_column = 10, parameter = 11 };

struct NeuronAnswer {
  std::array<double, 3> acceleration{};
  std::vector<std::array<double, 3>> by;  // [column], where derivatives are wanted
};

bool has(const Component& component, std::uint64_t capability) {
  return (component.description->capabilities & capability) != 0;
}

NeuronAnswer answer_of(const Component& component, const std::vector<double>& at, bool derivatives) {
  const std::size_t P = component.description->parameter_count;
  std::vector<const double*> parameters;
  for (std::size_t j = 0; j < P; ++j) parameters.push_back(&at[parameter + j]);
  parameters.push_back(nullptr);
  const std::vector<std::uint32_t> strides(P + 1, 0);
  springnet_message message{};
  springnet_neuron_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.time = at[time_column];
  batch.force = {&at[force], &at[force + 1], &at[force + 2]};
  batch.position = {&at[position], &at[position + 1], &at[position + 2]};
  batch.velocity = {&at[velocity], &at[velocity + 1], &at[velocity + 2]};
  batch.mass = &at[mass];
  batch.parameters = parameters.data();
  batch.parameter_strides = strides.data();
  batch.message = &message;
  NeuronAnswer answer;
  batch.acceleration = {&answer.acceleration[0], &answer.acceleration[1], &answer.acceleration[2]};
  std::array<std::array<double, 9>, 3> blocks{};  // [axis of the acceleration][axis of the vector]
  std::array<double, 3> by_mass{}, by_time{};
  std::vector<std::array<double, 3>> by_parameters(P);
  std::vector<double*> lists;
  for (auto& each : by_parameters) lists.push_back(each.data());
  lists.push_back(nullptr);
  const bool first = derivatives && has(component, SPRINGNET_HAS_DERIVATIVES);
  const bool more = derivatives && has(component, SPRINGNET_HAS_PARAMETER_DERIVATIVES);
  if (first) {
    batch.acceleration_by_force = blocks[0].data();
    batch.acceleration_by_position = blocks[1].data();
    batch.acceleration_by_velocity = blocks[2].data();
  }
  if (more) {
    batch.acceleration_by_mass = by_mass.data();
    batch.acceleration_by_time = by_time.data();
    batch.acceleration_by_parameters = lists.data();
  }
  const springnet_status status = component.neuron().evaluate(component.neuron().context, &batch);
  if (status != SPRINGNET_OK) throw std::runtime_error(fmt::format("it fails with the status {}", status));
  if (first)
    for (const auto& block : blocks)
      for (std::size_t j = 0; j < 3; ++j) answer.by.push_back({block[j], block[3 + j], block[6 + j]});
  if (first && more) {
    answer.by.push_back(by_mass);
    answer.by.push_back(by_time);
    answer.by.insert(answer.by.end(), by_parameters.begin(), by_parameters.end());
  }
  return answer;
}

std::vector<double> any_node(const Component& component, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<double> at;
  for (std::size_t k = force; k < mass; ++k) at.push_back(unit(random));
  at.push_back(std::pow(3.0, unit(random)));
  at.push_back(1.0 + unit(random));
  const std::vector<double> typical = typical_parameters(*component.description);
  for (std::size_t j = 0; j < typical.size(); ++j) {
    const springnet_parameter& p = *component.description->parameters[j];
    const double value = typical[j] * std::pow(3.0, unit(random));
    at.push_back(p.type == SPRINGNET_NUMBER ? std::clamp(value, p.smallest, p.largest) : typical[j]);
  }
  return at;
}

std::string column_name(const Component& component, std::size_t column) {
  if (column < position) return "the force";
  if (column < velocity) return "the position";
  if (column < mass) return "the velocity";
  if (column == mass) return "the mass";
  if (column == time_column) return "the time";
  return fmt::format("parameter '{}'", component.description->parameters[column - parameter]->name);
}

}  // namespace

Outcome check_neuron_call(const Component& component, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  now_doing("evaluating one node");
  static_cast<void>(answer_of(component, any_node(component, random), false));
  now_doing("evaluating the derivatives of one node");
  static_cast<void>(answer_of(component, any_node(component, random), true));
  return {};
}

Outcome check_neuron_finite(const Component& component, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (int k = 0; k < 200; ++k) {
    std::vector<double> at = any_node(component, random);
    if (k % 4 == 0) std::fill_n(at.begin() + velocity, 3, 0.0);  // a node at rest
    for (const double a : answer_of(component, at, false).acceleration)
      if (!std::isfinite(a))
        return {Result::failed,
                fmt::format("the acceleration is {} at a mass of {:.4g} kg and the velocity {:.4g}, {:.4g}, "
                            "{:.4g} m/s",
                            a, at[mass], at[velocity], at[velocity + 1], at[velocity + 2])};
  }
  return {};
}

Outcome check_neuron_derivatives(const Component& component, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (int k = 0; k < 40; ++k) {
    const std::vector<double> at = any_node(component, random);
    const std::size_t declared = answer_of(component, at, true).by.size();
    for (std::size_t column = 0; column < at.size(); ++column) {
      const bool is_force = column < position;
      if (column >= parameter && component.description->parameters[column - parameter]->type != SPRINGNET_NUMBER)
        continue;
      if (!is_force && column >= declared) continue;
      // Of each axis the declared derivative, then 1 / mass.
      const Pairs pairs = [&](const std::vector<double>& xs) {
        std::vector<Pair> result(is_force ? 6 : 3);
        std::vector<double> moved = at;
        for (const double x : xs) {
          moved[column] = x;
          const NeuronAnswer answer = answer_of(component, moved, true);
          for (std::size_t axis = 0; axis < 3; ++axis) {
            result[axis].values.push_back(answer.acceleration[axis]);
            if (column < answer.by.size()) result[axis].derivatives.push_back(answer.by[column][axis]);
            if (!is_force) continue;
            result[3 + axis].values.push_back(answer.acceleration[axis]);
            result[3 + axis].derivatives.push_back(column == axis ? 1.0 / at[mass] : 0.0);
          }
        }
        return result;
      };
      double step = 0.05 * std::max(std::abs(at[column]), 1e-2);
      if (column >= parameter) {
        const springnet_parameter& p = *component.description->parameters[column - parameter];
        step = std::min({step, 0.5 * (at[column] - p.smallest), 0.5 * (p.largest - at[column])});
      }
      if (!(step > 0.0)) continue;
      const std::vector<Comparison> found = compare_over(pairs, at[column] - step, at[column] + step);
      for (std::size_t pair = found.size(); pair-- > 0;) {  // F / m first
        if (found[pair].verdict != Verdict::differs) continue;
        const double slope = found[pair].change / (2.0 * step), claimed = found[pair].integral / (2.0 * step);
        if (pair >= 3)
          return {Result::failed,
                  fmt::format("the acceleration grows by {:.9g} with the force, not by 1 / mass, {:.9g}: constraints "
                              "rely on F / m",
                              slope, claimed)};
        return {
            Result::failed,
            fmt::format("the derivative of the acceleration by {} is {:.9g}, its change gives {:.9g} (within {:.1e})",
                        column_name(component, column), claimed, slope, found[pair].error / (2.0 * step))};
      }
    }
  }
  return {};
}

}  // namespace springnet::check
