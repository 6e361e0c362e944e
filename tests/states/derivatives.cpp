// Every derivative that a shipped law returns, of its evaluation and of its steps, against central differences of
// sixth order at random parameters, states and places within their bounds.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

// Laws that read a table need one: those of this list have tests of their own (tests/law_tables/curves.cpp). A law with
// tables that is not in it fails the test.
const std::vector<std::string> without_a_table_here{"table"};

// Bits of an error that a derivative of this size, relative, must show.
constexpr double broken_by = 1e-6, tolerance = 1e-7;

// What a law computes from. Variables are numbered: q, rate, states, parameters.
struct Place {
  double q, rate, reference, start_q, start_rate, time_step;
  std::vector<double> states, parameters, inputs, start_inputs;

  double& variable(std::size_t index) {
    if (index < 2) return index == 0 ? q : rate;
    return index < 2 + states.size() ? states[index - 2] : parameters[index - 2 - states.size()];
  }
};

// Outputs are numbered: force, energy (nan: none), then the rates of the states, or in a step the states that follow.
struct Answer {
  springnet_status status;
  std::vector<double> values;
  std::vector<std::vector<double>> derivatives;  // [output][variable]; nan: the ABI has none
};

class Law {
 public:
  explicit Law(const Component& component) : component_(component), law_(component.law()) {}

  [[nodiscard]] std::size_t states() const { return law_.state_count; }
  [[nodiscard]] std::size_t variables() const { return 2 + law_.state_count + component_.description->parameter_count; }
  [[nodiscard]] std::size_t outputs() const { return 2 + law_.state_count; }
  [[nodiscard]] bool can(std::uint64_t what) const { return (component_.description->capabilities & what) != 0; }
  [[nodiscard]] bool reads_rate() const { return can(SPRINGNET_READS_RATE); }
  // Whole numbers have no derivative.
  [[nodiscard]] bool varies(std::size_t variable) const {
    if (variable == 1) return reads_rate();
    return variable < 2 + states() || parameter(variable - 2 - states()).type == SPRINGNET_NUMBER;
  }
  // The distance of the differences' places: a thousandth of what the variable is usually.
  [[nodiscard]] double step(Place place, std::size_t variable) const {
    const double share = 1e-3;
    if (variable == 0) return share * place.reference;
    if (variable == 1) return share;
    if (variable < 2 + states()) return share * law_.states[variable - 2]->scale;
    return share * std::abs(place.variable(variable));
  }
  [[nodiscard]] std::string name(std::size_t variable) const {
    if (variable < 2) return variable == 0 ? "q" : "rate";
    return variable < 2 + states() ? law_.states[variable - 2]->name : parameter(variable - 2 - states()).name;
  }

  [[nodiscard]] Place random_place(std::mt19937_64& random) const {
    const auto between = [&random](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
    const auto value = [&](const springnet_parameter& p) {
      if (p.type != SPRINGNET_NUMBER) return std::floor(between(p.smallest, p.largest + 1.0 - 1e-9));
      const bool below = std::isfinite(p.smallest), above = std::isfinite(p.largest);
      const double width = above && below ? p.largest - p.smallest : 2.0 * p.scale;
      if (below) return p.smallest + width * between(0.1, 0.9);
      return above ? p.largest - width * between(0.1, 0.9) : width * between(-1.0, 1.0);
    };
    Place place{};
    place.reference = between(0.5, 2.0);
    place.q = place.reference * between(0.6, 1.6);
    place.rate = between(-2.0, 2.0);
    place.time_step = between(0.02, 0.5);
    place.start_q = place.q - place.time_step * between(-1.0, 1.0);
    place.start_rate = place.rate + between(-1.0, 1.0);
    for (std::uint32_t j = 0; j < law_.state_count; ++j) place.states.push_back(value(*law_.states[j]));
    for (std::uint32_t j = 0; j < law_.input_count; ++j) {
      place.inputs.push_back(value(*law_.inputs[j]));
      place.start_inputs.push_back(value(*law_.inputs[j]));
    }
    for (std::uint32_t j = 0; j < component_.description->parameter_count; ++j)
      place.parameters.push_back(value(parameter(j)));
    return place;
  }

  // order 0: as it is; else a step of that order.
  [[nodiscard]] Answer at(const Place& place, std::uint32_t order) const {
    const double none = std::numeric_limits<double>::quiet_NaN();
    const std::size_t S = states(), P = place.parameters.size();
    const bool energy = can(SPRINGNET_HAS_ENERGY);
    Answer answer{SPRINGNET_FAILED, std::vector(outputs(), none),
                  std::vector(outputs(), std::vector<double>(variables(), none))};
    const auto pointers = [](const std::vector<double>& from) {
      std::vector<const double*> list;
      for (const double& each : from) list.push_back(&each);
      return list;
    };
    // Rows `first` to `last` of the derivatives, columns likewise.
    const auto block = [&answer](std::size_t first, std::size_t rows, std::size_t begin, std::size_t columns) {
      std::vector<double*> list;
      for (std::size_t i = first; i < first + rows; ++i)
        for (std::size_t j = begin; j < begin + columns; ++j) list.push_back(&answer.derivatives[i][j]);
      return list;
    };
    const auto parameters = pointers(place.parameters), state = pointers(place.states), input = pointers(place.inputs),
               start_input = pointers(place.start_inputs);
    const std::vector<std::uint32_t> strides(std::max(P, place.inputs.size()) + 1, 0);
    std::vector<double*> next;
    for (std::size_t j = 0; j < S; ++j) next.push_back(&answer.values[2 + j]);
    auto force_by_states = block(0, 1, 2, S), force_by_parameters = block(0, 1, 2 + S, P),
         energy_by_states = block(1, 1, 2, S), by_q = block(2, S, 0, 1), by_rate = block(2, S, 1, 1),
         by_states = block(2, S, 2, S), by_parameters = block(2, S, 2 + S, P);
    springnet_message message{};
    springnet_law_batch batch{};
    batch.struct_size = sizeof batch;
    batch.count = 1;
    batch.q = &place.q;
    batch.rate = reads_rate() ? &place.rate : nullptr;
    batch.reference = &place.reference;
    batch.parameters = parameters.data();
    batch.parameter_strides = strides.data();
    batch.states = state.data();
    batch.inputs = input.data();
    batch.input_strides = strides.data();
    batch.force = &answer.values[0];
    batch.force_by_q = &answer.derivatives[0][0];
    batch.force_by_rate = &answer.derivatives[0][1];
    batch.force_by_states = force_by_states.data();
    batch.force_by_parameters = force_by_parameters.data();
    batch.energy = energy ? &answer.values[1] : nullptr;
    batch.message = &message;
    if (order == 0) {
      batch.energy_by_q = energy ? &answer.derivatives[1][0] : nullptr;
      batch.energy_by_states = energy ? energy_by_states.data() : nullptr;
      batch.state_rates = next.data();
      batch.rates_by_q = by_q.data();
      batch.rates_by_rate = by_rate.data();
      batch.rates_by_states = by_states.data();
      batch.rates_by_parameters = by_parameters.data();
      answer.status = law_.evaluate(law_.context, &batch);
      return answer;
    }
    springnet_law_update update{};
    update.struct_size = sizeof update;
    update.order = order;
    update.batch = &batch;
    update.time_step = place.time_step;
    update.start_q = &place.start_q;
    update.start_rate = reads_rate() ? &place.start_rate : nullptr;
    update.start_inputs = start_input.data();
    update.next = next.data();
    update.next_by_q = by_q.data();
    update.next_by_rate = by_rate.data();
    update.next_by_states = by_states.data();
    update.next_by_parameters = by_parameters.data();
    answer.status = law_.update(law_.context, &update);
    return answer;
  }

 private:
  [[nodiscard]] const springnet_parameter& parameter(std::size_t index) const {
    return *component_.description->parameters[index];
  }
  const Component& component_;
  const springnet_law& law_;
};

struct Difference {
  std::vector<double> slopes, largest;  // [output]; values of the places in magnitude
  bool exists = true;
};

// f' = (45 (f1 - f-1) - 9 (f2 - f-2) + (f3 - f-3)) / (60 h) + O(h^6)
Difference difference(const Law& law, Place place, std::uint32_t order, std::size_t variable, double h) {
  constexpr std::array<double, 3> weights{45.0 / 60, -9.0 / 60, 1.0 / 60};
  Difference result{std::vector<double>(law.outputs()), std::vector<double>(law.outputs())};
  const double middle = place.variable(variable);
  for (int k = -3; k <= 3; ++k) {
    if (k == 0) continue;
    place.variable(variable) = middle + k * h;
    const Answer answer = law.at(place, order);
    result.exists = result.exists && answer.status == SPRINGNET_OK;
    for (std::size_t o = 0; o < law.outputs(); ++o) {
      result.slopes[o] += (k > 0 ? 1.0 : -1.0) * weights[static_cast<std::size_t>(std::abs(k) - 1)] * answer.values[o];
      result.largest[o] = std::max(result.largest[o], std::abs(answer.values[o]));
    }
  }
  for (double& slope : result.slopes) slope /= h;
  return result;
}

struct Tally {
  int compared = 0, at_kinks = 0;
  bool zero = true;       // everywhere
  bool is_sharp = false;  // somewhere an error of `broken_by` would fail
};

constexpr int places = 150;

void check(const Law& law, std::uint32_t order, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::map<std::pair<std::size_t, std::size_t>, Tally> tallies;
  int valid = 0;
  for (int k = 0; k < places; ++k) {
    const Place place = law.random_place(random);
    const Answer answer = law.at(place, order);
    if (answer.status != SPRINGNET_OK) continue;  // no state within the bounds follows
    ++valid;
    for (std::size_t v = 0; v < law.variables(); ++v) {
      if (!law.varies(v)) {
        if (v == 1) CHECK(answer.derivatives[0][1] == 0.0);
        continue;
      }
      const double h = law.step(place, v);
      const Difference coarse = difference(law, place, order, v, h), fine = difference(law, place, order, v, h / 2);
      for (std::size_t o = 0; o < law.outputs(); ++o) {
        const double given = answer.derivatives[o][v], slope = fine.slopes[o];
        // The energy has derivatives by q and states alone, and none in a step.
        const bool in_abi = o != 1 || (law.can(SPRINGNET_HAS_ENERGY) && order == 0 && v != 1 && v < 2 + law.states());
        if (!in_abi) continue;
        Tally& tally = tallies[{o, v}];
        // Rounding of the values, which a step's solution has a hundred times.
        const double allowed = tolerance * std::abs(slope) + 1e-14 * fine.largest[o] / h;
        // Both differences agree unless a kink lies between their places.
        const bool smooth = fine.exists && coarse.exists && std::abs(coarse.slopes[o] - slope) <= 0.3 * allowed;
        ++(smooth ? tally.compared : tally.at_kinks);
        if (!smooth) continue;
        tally.zero = tally.zero && given == 0.0;
        tally.is_sharp = tally.is_sharp || broken_by * std::abs(slope) > 2.0 * allowed;
        if (std::abs(given - slope) <= allowed) continue;
        FAIL_CHECK(fmt::format("order {}: output {} by {} is {:.17g}, by differences {:.17g} +- {:.2g}", order, o,
                               law.name(v), given, slope, allowed));
        return;
      }
    }
  }
  CHECK(valid > places / 2);
  for (const auto& [key, tally] : tallies) {
    CAPTURE(key.first);
    CAPTURE(law.name(key.second));
    CHECK(tally.compared > 2 * tally.at_kinks);
    CHECK((tally.zero || tally.is_sharp));
  }
}

}  // namespace

TEST_CASE("derivatives of every shipped law are those of its values, as it is and in its steps") {
  int laws = 0;
  for (const auto& component : plugins()->components()) {
    if (component->kind() != ComponentKind::spring_function && component->kind() != ComponentKind::viscosity_function)
      continue;
    const std::string id(component->id());
    CAPTURE(id);
    if (component->law().invariant == SPRINGNET_SEVERAL) continue;  // tests/plugins/laws/test_jacobians.cpp
    if (component->law().table_count > 0) {
      // Give it a table here, or name it above.
      CHECK(std::count(without_a_table_here.begin(), without_a_table_here.end(), id) == 1);
      continue;
    }
    ++laws;
    const Law law(*component);
    for (std::uint32_t order = 0; order <= (law.states() > 0 ? component->law().update_order : 0); ++order)
      check(law, order, 7u + order);
  }
  CHECK(laws >= 11);
}
