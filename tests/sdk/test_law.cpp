// The glue of law.hpp over a law class: metadata, arrays with strides, state, inputs, time, table, errors.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include <springnet/sdk/law.hpp>

#include "law_call.hpp"

namespace {
using namespace springnet::sdk;
using namespace springnet::test;

// Everything at once: two states, two inputs, a table, time, energy, margin, rate.
//   Q = k (q - l0) (1 + a s0) + c q' + z0 z1 + table[1] t
struct Everything : SpringFunction {
  using has = Has<Energy, Margin>;
  static constexpr const char* id = "everything";
  static constexpr const char* summary = "uses all that a law may use";
  static constexpr const char* reference = "none";
  static constexpr bool reads_rate = true;
  static constexpr bool reads_time = true;
  static constexpr bool acts_in_compression = false;
  static constexpr Parameter parameters[] = {number("stiffness", "N/m", "k"), number("damping", "N s/m", "c")};
  static constexpr Parameter states[] = {number("damage", "1", "grows").preset(0).at_least(0),
                                         number("creep", "m", "").preset(1).at_least(-1).at_most(9)};
  static constexpr Parameter inputs[] = {number("activation", "1", "of a muscle").preset(0),
                                         number("temperature", "K", "").preset(300)};
  static constexpr Table tables[] = {
      table("curve", "N/s", "slope over time").at_least_values(2).within(-10, 10).increasing(),
      table("other", "1", "not read").optional().as_long_as(0)};
  struct Curve {
    std::vector<double> values;
    double stiffness;
  };
  static Curve prepare(const TableSource& source) {
    const auto curve = source[0];
    if (curve.size() != 2) throw std::runtime_error("curve: needs two numbers");
    return {{curve.begin(), curve.end()}, source.parameter(0)};
  }

  template <class Real>
  static Real force(const Element<Real, Curve>& e, const Parameters<Real>& p) {
    return p[0] * e.elongation() * (1.0 + e.input(0) * 2.0) + p[1] * e.rate + e.state(0) * e.state(1) +
           e.table.values[1] * e.time;
  }
  template <class Real>
  static Real energy(const Element<Real, Curve>& e, const Parameters<Real>& p) {
    return 0.5 * p[0] * e.elongation() * e.elongation();
  }
  template <class Real>
  static Real margin(const Element<Real, Curve>& e, const Parameters<Real>&) {
    return 1.0 - e.state(0);
  }
  template <class Real>
  static std::array<Real, 2> state_rates(const Element<Real, Curve>& e, const Parameters<Real>& p) {
    return {abs(e.rate) - e.state(0), p[0] * e.input(1) - e.state(1)};
  }
};

struct Throwing : SpringFunction {
  static constexpr const char* id = "throwing";
  static constexpr const char* summary = "throws";
  template <class Real>
  static Real force(const Element<Real>& e, const Parameters<Real>&) {
    if (e.q > 2.0) throw std::runtime_error("longer than 2 m");
    if (e.q < 0.0) throw 1;
    return e.q;
  }
};

struct Speed : ViscosityFunction {
  static constexpr const char* id = "speed";
  static constexpr const char* summary = "reads the relative speed";
  static constexpr std::uint32_t invariant = SPRINGNET_RELATIVE_SPEED;
  template <class Real>
  static Real force(const Element<Real>& e, const Parameters<Real>&) {
    return e.q * e.q;
  }
};

constexpr const springnet_component& everything = ComponentEntry<Everything>::value;
constexpr const springnet_component& throwing = ComponentEntry<Throwing>::value;
constexpr const springnet_component& speed = ComponentEntry<Speed>::value;

constexpr std::array<double, 2> curve{3.0, 7.0}, material{2.0, 0.7};

// A preparation with the curve, or without; the second table is not given.
struct Preparation {
  std::array<const double*, 2> tables{};
  std::array<std::uint64_t, 2> lengths{};
  springnet_message message{};
  springnet_preparation request{};
  explicit Preparation(bool with_curve) {
    if (with_curve) {
      tables[0] = curve.data();
      lengths[0] = curve.size();
    }
    request.struct_size = sizeof request;
    request.table_count = 2;
    request.tables = tables.data();
    request.lengths = lengths.data();
    request.parameters = material.data();
    request.message = &message;
  }
  Preparation(const Preparation&) = delete;
  Preparation& operator=(const Preparation&) = delete;
  springnet_status prepare(const springnet_law& law) { return law.prepare(law.context, &request); }
  springnet_status release(const springnet_law& law) { return law.release(law.context, &request); }
};

Array ramp(std::uint32_t count, double from, double step) {
  Array result(count);
  for (std::uint32_t i = 0; i < count; ++i) result[i] = from + step * i;
  return result;
}

LawInput input_of(std::uint32_t count, const void* table) {
  LawInput input;
  input.count = count;
  input.q = ramp(count, 0.5, 0.001);
  input.rate = ramp(count, -0.3, 0.002);
  input.reference = ramp(count, 0.9, 0.0003);
  input.parameters = {ramp(count, 2.0, 0.01), {0.7}};
  input.inputs = {{0.25}, ramp(count, 280.0, 0.1)};
  input.states = {ramp(count, 0.1, 0.0002), ramp(count, 1.0, 0.001)};
  input.time = 2.5;
  input.table = table;
  return input;
}

}  // namespace

TEST_CASE("metadata of a law come from its class") {
  CHECK(everything.kind == SPRINGNET_SPRING_FUNCTION);
  CHECK(std::string(everything.id) == "everything");
  CHECK(std::string(everything.reference) == "none");
  CHECK(everything.parameter_count == 2);
  CHECK(everything.capabilities ==
        (SPRINGNET_HAS_ENERGY | SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_ALL_DERIVATIVES |
         SPRINGNET_HAS_PARAMETER_DERIVATIVES | SPRINGNET_HAS_RUPTURE | SPRINGNET_READS_RATE | SPRINGNET_READS_TIME));
  CHECK(everything.needs == (SPRINGNET_NEEDS_STATES | SPRINGNET_NEEDS_INPUTS | SPRINGNET_NEEDS_TABLES));
  CHECK(everything.needs_minor == 0);
  const springnet_law& law = law_of(everything);
  CHECK(law.struct_size == sizeof(springnet_law));
  CHECK(law.invariant == SPRINGNET_LENGTH);
  CHECK(law.state_count == 2);
  CHECK(law.input_count == 2);
  CHECK(std::string(law.states[1]->name) == "creep");
  CHECK(law.states[1]->default_value == 1.0);
  CHECK(law.states[1]->smallest == -1.0);
  CHECK(law.states[1]->largest == 9.0);
  CHECK(std::string(law.inputs[1]->unit) == "K");
  REQUIRE(law.table_count == 2);
  CHECK(std::string(law.tables[0]->name) == "curve");
  CHECK(std::string(law.tables[0]->unit) == "N/s");
  CHECK(law.tables[0]->flags == SPRINGNET_INCREASING);
  CHECK(law.tables[0]->least == 2);
  CHECK(law.tables[0]->as_long_as == 0);
  CHECK(law.tables[0]->smallest == -10.0);
  CHECK(law.tables[0]->largest == 10.0);
  CHECK(law.tables[1]->flags == SPRINGNET_OPTIONAL);
  CHECK(law.tables[1]->as_long_as == 0);
  CHECK((law.update != nullptr));
  CHECK(law.update_order == 2);
  CHECK(law.reads_start == 0);
  CHECK((law.start == nullptr));

  CHECK(speed.kind == SPRINGNET_VISCOSITY_FUNCTION);
  CHECK(std::string(speed.reference).empty());
  CHECK(speed.parameters == nullptr);
  // A relative speed has no rate.
  CHECK(speed.capabilities ==
        (SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_ALL_DERIVATIVES | SPRINGNET_ACTS_IN_COMPRESSION));
  CHECK(law_of(speed).invariant == SPRINGNET_RELATIVE_SPEED);
  CHECK(speed.needs == 0);
  CHECK((law_of(speed).update == nullptr));
  CHECK((law_of(speed).prepare == nullptr));
  CHECK((law_of(speed).release == nullptr));
}

TEST_CASE("state, inputs, time and table reach the formula, and every output comes back") {
  const springnet_law& law = law_of(everything);
  Preparation preparation(true);
  REQUIRE(preparation.prepare(law) == SPRINGNET_OK);
  const void* const table = preparation.request.prepared;
  REQUIRE(table != nullptr);
  CHECK(static_cast<const Everything::Curve*>(table)->stiffness == 2.0);

  for (const std::uint32_t count : {1u, 2u, 255u, 256u, 257u, 1000u}) {
    CAPTURE(count);
    const LawInput in = input_of(count, table);
    const LawAnswer out = evaluate(everything, in);
    REQUIRE(out.status == SPRINGNET_OK);
    bool force = true, energy = true, margin = true, rates = true, by = true, energy_by = true, rates_by = true;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double k = in.parameters[0][i], c = in.parameters[1][0];
      const double x = in.q[i] - in.reference[i], u = in.rate[i];
      const double z0 = in.states[0][i], z1 = in.states[1][i];
      const double s0 = in.inputs[0][0], s1 = in.inputs[1][i];
      // The same operations in the same order: the same bits.
      force = force && out.force[i] == k * x * (1.0 + s0 * 2.0) + c * u + z0 * z1 + 7.0 * in.time;
      energy = energy && out.energy[i] == 0.5 * k * x * x;
      margin = margin && out.margin[i] == 1.0 - z0;
      rates = rates && out.state_rates[0][i] == std::abs(u) - z0 && out.state_rates[1][i] == k * s1 - z1;
      by = by && out.by_q[i] == k * (1.0 + s0 * 2.0) && out.by_rate[i] == c &&
           out.by_parameters[0][i] == x * (1.0 + s0 * 2.0) && out.by_parameters[1][i] == u &&
           out.by_states[0][i] == z1 && out.by_states[1][i] == z0;
      energy_by = energy_by && std::abs(out.energy_by_q[i] - k * x) <= 1e-15 * k && out.energy_by_states[0][i] == 0.0 &&
                  out.energy_by_states[1][i] == 0.0;
      const double sign = u < 0.0 ? -1.0 : 1.0;
      const auto is = [i](const std::vector<Array>& lists, std::initializer_list<double> values) {
        bool same = lists.size() == values.size();
        for (std::size_t j = 0; same && j < lists.size(); ++j) same = lists[j][i] == values.begin()[j];
        return same;
      };
      rates_by = rates_by && is(out.rates_by_q, {0.0, 0.0}) && (u == 0.0 || is(out.rates_by_rate, {sign, 0.0})) &&
                 is(out.rates_by_states, {-1.0, 0.0, 0.0, -1.0}) && is(out.rates_by_parameters, {0.0, 0.0, s1, 0.0});
    }
    CHECK(force);
    CHECK(energy);
    CHECK(margin);
    CHECK(rates);
    CHECK(by);
    CHECK(energy_by);
    CHECK(rates_by);
  }
  CHECK(preparation.release(law) == SPRINGNET_OK);
  CHECK(preparation.request.prepared == nullptr);
}

TEST_CASE("outputs that are not wanted may be null") {
  double q[] = {1.0, 3.0}, by_q[] = {0.0, 0.0};
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 2;
  batch.q = q;
  batch.force_by_q = by_q;
  REQUIRE(law_of(speed).evaluate(nullptr, &batch) == SPRINGNET_OK);
  CHECK(by_q[0] == 2.0);
  CHECK(by_q[1] == 6.0);
}

TEST_CASE("a failed prepare() gives its message") {
  Preparation preparation(false);
  preparation.request.prepared = &preparation;
  CHECK(preparation.prepare(law_of(everything)) == SPRINGNET_FAILED);
  CHECK(std::string(preparation.message.text) == "curve: needs two numbers");
  CHECK(preparation.request.prepared == nullptr);
}

TEST_CASE("no exception leaves a law") {
  LawInput input;
  input.count = 2;
  input.reference = {1.0};
  input.q = {1.0, 1.5};
  CHECK(evaluate(throwing, input).status == SPRINGNET_OK);
  input.q = {1.0, 2.5};
  const LawAnswer failed = evaluate(throwing, input);
  CHECK(failed.status == SPRINGNET_FAILED);
  CHECK(failed.message == "longer than 2 m");
  input.q = {-1.0, 1.0};
  CHECK(evaluate(throwing, input).message == "the component threw something that is not a std::exception");
}

TEST_CASE("violations of the contract by the host are reported") {
  double one = 1.0;
  springnet_message message{};
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.message = &message;
  const auto refusal = [&](const springnet_component& component) {
    message.text[0] = '\0';
    CHECK(law_of(component).evaluate(nullptr, &batch) == SPRINGNET_FAILED);
    return std::string(message.text);
  };
  CHECK(refusal(speed) == "the host gave no invariant");
  batch.q = &one;
  CHECK(refusal(everything) == "the law reads the rate, which the host did not give");
  batch.rate = &one;
  CHECK(refusal(everything) == "the host did not prepare the table of the law");
  batch.table = &one;  // not read: the batch is refused
  CHECK(refusal(everything) == "the host gave no internal state");
  batch.energy = &one;
  CHECK(refusal(speed) == "the host asked for an energy, which the law does not have");
  batch.energy = nullptr;
  batch.margin = &one;
  CHECK(refusal(speed) == "the host asked for a margin, which the law does not have");
  batch.margin = nullptr;
  batch.struct_size = 8;
  CHECK(refusal(speed).empty());  // too old to have a message
}

TEST_CASE("an unknown instruction set gives the generic result") {
  LawInput input;
  input.count = 3;
  input.q = {1.0, 2.0, 3.0};
  CHECK(same_bits(evaluate(speed, input, 77), evaluate(speed, input)));
}

TEST_CASE("the glue gives the same bits for every instruction set, tile and stride") {
  Preparation preparation(true);
  REQUIRE(preparation.prepare(law_of(everything)) == SPRINGNET_OK);
  const LawInput in = input_of(1000, preparation.request.prepared);
  const LawAnswer whole = evaluate(everything, in);
  for (const std::uint32_t set : instruction_sets()) {
    for (const std::uint32_t tile : {1u, 3u, 17u, 255u, 256u, 300u, 1000u}) {
      CAPTURE(set);
      CAPTURE(tile);
      CHECK(same_bits(evaluate(everything, in, set, tile), whole));
    }
  }
  // One value for all is the same as a thousand equal values.
  LawInput spread = in;
  spread.parameters[1].assign(1000, in.parameters[1][0]);
  spread.inputs[0].assign(1000, in.inputs[0][0]);
  CHECK(same_bits(evaluate(everything, spread), whole));
  CHECK(preparation.release(law_of(everything)) == SPRINGNET_OK);
}

TEST_CASE("messages are cut at whole characters") {
  springnet_message message{};
  std::string text(510, 'a');
  text += "\xc3\xa4\xc3\xa4";  // two characters of two bytes: 514
  detail::write_message(&message, text.c_str());
  CHECK(std::string(message.text) == std::string(510, 'a'));
  text.erase(0, 1);
  detail::write_message(&message, text.c_str());
  CHECK(std::string(message.text) == text.substr(0, 511));
}
