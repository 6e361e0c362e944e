// Calls of a law through the C ABI, as a host makes them: arrays in, every output that the law declares out.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <springnet/sdk/plugin.h>

namespace springnet::test {

using Array = std::vector<double>;

// Arrays of `count` values, or of one value, which is then passed with stride 0.
struct LawInput {
  std::uint32_t count = 0;
  Array q, rate, reference;
  std::vector<Array> parameters, inputs, states;
  double time = 0.0;
  const void* table = nullptr;
};

struct LawAnswer {
  springnet_status status = SPRINGNET_OK;
  std::string message;
  Array force, energy, by_q, by_rate, margin;
  Array energy_by_q;
  std::vector<Array> by_parameters, by_states, state_rates, energy_by_states;
  std::vector<Array> rates_by_q, rates_by_rate, rates_by_states, rates_by_parameters;
};

inline const springnet_law& law_of(const springnet_component& component) {
  return *static_cast<const springnet_law*>(component.implementation);
}

// The instruction sets that processor and build support, SPRINGNET_GENERIC first; ctest lists the others
// (tests/layers).
inline std::vector<std::uint32_t> instruction_sets() {
  std::vector<std::uint32_t> sets{SPRINGNET_GENERIC};
#if defined(__x86_64__) && !defined(SPRINGNET_GENERIC_ONLY)
  if (__builtin_cpu_supports("avx2")) sets.push_back(SPRINGNET_AVX2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd")) {
    sets.push_back(SPRINGNET_AVX512);
  }
#endif
  return sets;
}

// All elements, in tiles of `tile` elements (0: one tile).
inline LawAnswer evaluate(const springnet_component& component, const LawInput& input,
                          std::uint32_t set = SPRINGNET_GENERIC, std::uint32_t tile = 0) {
  const springnet_law& law = law_of(component);
  const bool has_energy = (component.capabilities & SPRINGNET_HAS_ENERGY) != 0;
  const bool has_margin = (component.capabilities & SPRINGNET_HAS_RUPTURE) != 0;
  LawAnswer answer;
  answer.force.resize(input.count);
  answer.by_q.resize(input.count);
  answer.by_rate.resize(input.count);
  if (has_energy) answer.energy.resize(input.count);
  if (has_energy) answer.energy_by_q.resize(input.count);
  if (has_margin) answer.margin.resize(input.count);
  answer.by_parameters.assign(component.parameter_count, Array(input.count));
  answer.by_states.assign(law.state_count, Array(input.count));
  answer.state_rates.assign(law.state_count, Array(input.count));
  if (has_energy) answer.energy_by_states.assign(law.state_count, Array(input.count));
  answer.rates_by_q.assign(law.state_count, Array(input.count));
  answer.rates_by_rate.assign(law.state_count, Array(input.count));
  answer.rates_by_states.assign(std::size_t{law.state_count} * law.state_count, Array(input.count));
  answer.rates_by_parameters.assign(std::size_t{law.state_count} * component.parameter_count, Array(input.count));

  if (tile == 0) tile = input.count;
  for (std::uint32_t first = 0; first < input.count; first += tile) {
    const auto at = [first](const Array& array) { return array.data() + (array.size() == 1 ? 0 : first); };
    const auto stride = [&input](const Array& array) { return array.size() == 1 && input.count != 1 ? 0u : 1u; };
    std::vector<const double*> parameters, inputs, states;
    std::vector<std::uint32_t> parameter_strides, input_strides;
    for (const Array& each : input.parameters) {
      parameters.push_back(at(each));
      parameter_strides.push_back(stride(each));
    }
    for (const Array& each : input.inputs) {
      inputs.push_back(at(each));
      input_strides.push_back(stride(each));
    }
    for (const Array& each : input.states) states.push_back(each.data() + first);
    const auto list = [first](std::vector<Array>& arrays) {
      std::vector<double*> result;
      for (Array& each : arrays) result.push_back(each.data() + first);
      return result;
    };
    const auto by_parameters = list(answer.by_parameters), by_states = list(answer.by_states);
    const auto state_rates = list(answer.state_rates), energy_by_states = list(answer.energy_by_states);
    const auto rates_by_q = list(answer.rates_by_q), rates_by_rate = list(answer.rates_by_rate);
    const auto rates_by_states = list(answer.rates_by_states);
    const auto rates_by_parameters = list(answer.rates_by_parameters);

    springnet_message message{};
    springnet_law_batch batch{};
    batch.struct_size = sizeof batch;
    batch.count = std::min(tile, input.count - first);
    batch.instruction_set = set;
    batch.time = input.time;
    batch.q = input.q.data() + first;
    batch.rate = (component.capabilities & SPRINGNET_READS_RATE) != 0 ? input.rate.data() + first : nullptr;
    batch.reference = input.reference.empty() ? nullptr : at(input.reference);
    batch.reference_stride = input.reference.empty() ? 0 : stride(input.reference);
    batch.parameters = parameters.data();
    batch.parameter_strides = parameter_strides.data();
    batch.states = states.data();
    batch.inputs = inputs.data();
    batch.input_strides = input_strides.data();
    batch.table = input.table;
    batch.force = answer.force.data() + first;
    batch.energy = has_energy ? answer.energy.data() + first : nullptr;
    batch.force_by_q = answer.by_q.data() + first;
    batch.force_by_rate = answer.by_rate.data() + first;
    batch.force_by_parameters = by_parameters.data();
    batch.margin = has_margin ? answer.margin.data() + first : nullptr;
    batch.state_rates = state_rates.data();
    batch.force_by_states = by_states.data();
    batch.energy_by_q = has_energy ? answer.energy_by_q.data() + first : nullptr;
    batch.energy_by_states = energy_by_states.data();
    batch.rates_by_q = rates_by_q.data();
    batch.rates_by_rate = rates_by_rate.data();
    batch.rates_by_states = rates_by_states.data();
    batch.rates_by_parameters = rates_by_parameters.data();
    batch.message = &message;
    answer.status = law.evaluate(law.context, &batch);
    answer.message = message.text;
    if (answer.status != SPRINGNET_OK) break;
  }
  return answer;
}

// Bit for bit, so that NaN equals NaN and 0 differs from -0.
// One nan is as good as another: IEEE 754 leaves their signs open, and compilers swap the factors of products.
inline bool same_bits(const Array& a, const Array& b) {
  const auto same = [](double x, double y) {
    return std::memcmp(&x, &y, sizeof x) == 0 || (std::isnan(x) && std::isnan(y));
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}
inline bool same_bits(const LawAnswer& a, const LawAnswer& b) {
  const auto same = [](const std::vector<Array>& x, const std::vector<Array>& y) {
    bool result = x.size() == y.size();
    for (std::size_t j = 0; result && j < x.size(); ++j) result = same_bits(x[j], y[j]);
    return result;
  };
  return same_bits(a.force, b.force) && same_bits(a.energy, b.energy) && same_bits(a.by_q, b.by_q) &&
         same_bits(a.by_rate, b.by_rate) && same_bits(a.margin, b.margin) && same(a.by_parameters, b.by_parameters) &&
         same(a.by_states, b.by_states) && same(a.state_rates, b.state_rates) &&
         same_bits(a.energy_by_q, b.energy_by_q) && same(a.energy_by_states, b.energy_by_states) &&
         same(a.rates_by_q, b.rates_by_q) && same(a.rates_by_rate, b.rates_by_rate) &&
         same(a.rates_by_states, b.rates_by_states) && same(a.rates_by_parameters, b.rates_by_parameters);
}

// f'(x) by the central difference of eighth order: truncation error h^8 f^(9) / 630, rounding error about
// 2e-16 |f| / h.
template <class Function>
double derivative(const Function& f, double x, double h) {
  constexpr std::array<double, 4> weights{4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  double sum = 0.0;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const double step = static_cast<double>(k + 1) * h;
    sum += weights[k] * (f(x + step) - f(x - step));
  }
  return sum / h;
}

}  // namespace springnet::test
