// Steps of internal state through the C ABI: the SDK's own methods and a law's update(), their derivatives, start().
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <springnet/sdk/law.hpp>

#include "law_call.hpp"

namespace {
using namespace springnet::sdk;
using namespace springnet::test;

// A Maxwell element: Q = k (q - z), dz/dt = (q - z) / tau. It begins relaxed.
struct Relaxing : SpringFunction {
  using has = Has<Start>;
  static constexpr const char* id = "relaxing";
  static constexpr const char* summary = "relaxes";
  static constexpr bool smooth_rates = true;
  static constexpr Parameter parameters[] = {number("stiffness", "N/m", "k"), number("time", "s", "tau")};
  static constexpr Parameter states[] = {number("creep", "m", "z").preset(0)};
  static auto force(const auto& e, const auto& p) { return p[0] * (e.q - e.state(0)); }
  static auto state_rates(const auto& e, const auto& p) { return std::array{(e.q - e.state(0)) / p[1]}; }
  static auto start(const auto& e, const auto&) { return std::array{e.q}; }
};

// Two states, nonlinear, with the rate and an input: u' = s q u - u^3, w' = |q'| + u - w; u stays above 0.
struct Coupled : SpringFunction {
  static constexpr const char* id = "coupled";
  static constexpr const char* summary = "has two states";
  static constexpr bool reads_rate = true;
  static constexpr Parameter parameters[] = {number("gain", "N", "of the force")};
  static constexpr Parameter states[] = {number("u", "1", "").preset(1).at_least(0).at_most(5),
                                         number("w", "1", "").preset(0)};
  static constexpr Parameter inputs[] = {number("s", "1/m", "signal").preset(1)};
  static auto force(const auto& e, const auto& p) { return p[0] * e.state(0) * e.state(1) * e.q; }
  static auto state_rates(const auto& e, const auto&) {
    const auto u = e.state(0), w = e.state(1);
    return std::array{e.input(0) * e.q * u - u * u * u, e.rate * e.rate + u - w};
  }
};

// By its own update(): Z = z + h (mean of q).
struct Summing : SpringFunction {
  using has = Has<Update>;
  static constexpr const char* id = "summing";
  static constexpr const char* summary = "integrates its length";
  static constexpr int update_order = 2;
  static constexpr Parameter states[] = {number("sum", "m s", "").preset(0)};
  static auto force(const auto& e, const auto&) { return e.state(0); }
  static auto state_rates(const auto& e, const auto&) { return std::array{e.q}; }
  static auto update(const auto& e, const auto&, const auto& step) {
    return std::array{e.state(0) + step.duration * 0.5 * (e.q + step.start_q)};
  }
};

// Does not heal: z' = max(q - z, 0) / tau, with z at most 2.
struct Ratchet : SpringFunction {
  static constexpr const char* id = "ratchet";
  static constexpr const char* summary = "goes one way";
  static constexpr Parameter parameters[] = {number("time", "s", "tau")};
  static constexpr Parameter states[] = {number("z", "1", "").preset(0).at_most(2)};
  static auto force(const auto& e, const auto&) { return e.q - e.state(0); }
  static auto state_rates(const auto& e, const auto& p) { return std::array{max(e.q - e.state(0), 0.0) / p[0]}; }
};

// Nothing within the bounds solves z = z0 + h: the rate is 1, and z may not be above 1.
struct Stuck : SpringFunction {
  static constexpr const char* id = "stuck";
  static constexpr const char* summary = "leaves its bounds";
  static constexpr Parameter states[] = {number("z", "1", "").preset(0).at_least(0).at_most(1)};
  static auto force(const auto& e, const auto&) { return e.q * e.state(0); }
  static auto state_rates(const auto& e, const auto&) { return std::array{0.0 * e.q + 1.0}; }
};

// A step of one element.
struct Call {
  double q = 1.5, rate = 0.4, start_q = 1.2, start_rate = 0.1, input = 0.8, start_input = 0.6, time_step = 0.25;
  Array z, parameters;
  std::uint32_t order = 1, set = SPRINGNET_GENERIC, count = 1;

  // Answers of the last element.
  double force = 0.0, by_q = 0.0, by_rate = 0.0;
  Array by_states, by_parameters, next, next_by_q, next_by_rate, next_by_states, next_by_parameters;
  springnet_message message{};

  springnet_status run(const springnet_component& component) {
    const springnet_law& law = law_of(component);
    const std::size_t S = law.state_count, P = component.parameter_count;
    const auto many = [this](double value) { return Array(count, value); };
    const Array qs = many(q), rates = many(rate), start_qs = many(start_q), start_rates = many(start_rate);
    std::vector<Array> states;
    for (const double each : z) states.push_back(many(each));
    std::vector<const double*> state_list, parameter_list;
    for (const Array& each : states) state_list.push_back(each.data());
    for (const double& each : parameters) parameter_list.push_back(&each);
    const std::vector<std::uint32_t> strides(P, 0);
    const std::uint32_t input_stride = 0;
    const double *input_list = &input, *start_input_list = &start_input;
    std::vector<Array> out(S + P + S + S + S + S * S + S * P, many(0.0));
    std::vector<double*> lists;
    for (Array& each : out) lists.push_back(each.data());
    Array forces = many(0.0), by_qs = many(0.0), by_rates = many(0.0);
    springnet_law_batch batch{};
    batch.struct_size = sizeof batch;
    batch.count = count;
    batch.instruction_set = set;
    batch.time = 1.0;
    batch.q = qs.data();
    const bool reads_rate = (component.capabilities & SPRINGNET_READS_RATE) != 0;
    batch.rate = reads_rate ? rates.data() : nullptr;
    batch.parameters = parameter_list.data();
    batch.parameter_strides = strides.data();
    batch.states = state_list.data();
    batch.inputs = &input_list;
    batch.input_strides = &input_stride;
    batch.force = forces.data();
    batch.force_by_q = by_qs.data();
    batch.force_by_rate = by_rates.data();
    double** at = lists.data();
    const auto take = [&at](std::size_t size) { return (at += size) - size; };
    batch.force_by_states = take(S);
    batch.force_by_parameters = take(P);
    batch.message = &message;
    springnet_law_update update{};
    update.struct_size = sizeof update;
    update.order = order;
    update.batch = &batch;
    update.time_step = time_step;
    update.start_q = start_qs.data();
    update.start_rate = reads_rate ? start_rates.data() : nullptr;
    update.start_inputs = &start_input_list;
    update.next = take(S);
    update.next_by_q = take(S);
    update.next_by_rate = take(S);
    update.next_by_states = take(S * S);
    update.next_by_parameters = take(S * P);
    const springnet_status status = law.update(law.context, &update);
    const auto last = [this](double* const* arrays, std::size_t size) {
      Array result;
      for (std::size_t i = 0; i < size; ++i) result.push_back(arrays[i][count - 1]);
      return result;
    };
    force = forces.back();
    by_q = by_qs.back();
    by_rate = by_rates.back();
    by_states = last(batch.force_by_states, S);
    by_parameters = last(batch.force_by_parameters, P);
    next = last(update.next, S);
    next_by_q = last(update.next_by_q, S);
    next_by_rate = last(update.next_by_rate, S);
    next_by_states = last(update.next_by_states, S * S);
    next_by_parameters = last(update.next_by_parameters, S * P);
    return status;
  }
};

Call relaxing_call(std::uint32_t order) {
  Call call;
  call.order = order;
  call.z = {0.3};
  call.parameters = {20.0, 0.5};
  return call;
}
Call coupled_call(std::uint32_t order) {
  Call call;
  call.order = order;
  call.z = {0.7, -0.2};
  call.parameters = {3.0};
  return call;
}

Call ratchet_call(std::uint32_t order) {
  Call call;
  call.order = order;
  call.z = {0.3};
  call.parameters = {0.5};
  return call;
}

constexpr const springnet_component& ratchet = ComponentEntry<Ratchet>::value;
constexpr const springnet_component& relaxing = ComponentEntry<Relaxing>::value;
constexpr const springnet_component& coupled = ComponentEntry<Coupled>::value;
constexpr const springnet_component& summing = ComponentEntry<Summing>::value;
constexpr const springnet_component& stuck = ComponentEntry<Stuck>::value;

}  // namespace

TEST_CASE("a step of order 1 is backward Euler; force and derivatives are those at its end") {
  Call call = relaxing_call(1);
  REQUIRE(call.run(relaxing) == SPRINGNET_OK);
  const double a = 0.25 / 0.5, z = (0.3 + a * 1.5) / (1.0 + a);
  CHECK(call.next[0] == doctest::Approx(z).epsilon(1e-14));
  CHECK(call.next_by_q[0] == doctest::Approx(a / (1.0 + a)).epsilon(1e-14));
  CHECK(call.next_by_states[0] == doctest::Approx(1.0 / (1.0 + a)).epsilon(1e-14));
  CHECK(call.next_by_rate[0] == 0.0);
  CHECK(call.force == doctest::Approx(20.0 * (1.5 - z)).epsilon(1e-14));
  CHECK(call.by_q == doctest::Approx(20.0 / (1.0 + a)).epsilon(1e-14));
  CHECK(call.by_states[0] == doctest::Approx(-20.0 / (1.0 + a)).epsilon(1e-14));
  CHECK(call.by_parameters[0] == doctest::Approx(1.5 - z).epsilon(1e-14));
}

TEST_CASE("a step of order 2 is Alexander's method, and its error falls with the third power of the step") {
  Call call = relaxing_call(2);
  REQUIRE(call.run(relaxing) == SPRINGNET_OK);
  const double g = 1.0 - std::sqrt(0.5), a = g * 0.25 / 0.5;
  const double q1 = 1.2 + g * 0.3, z1 = (0.3 + a * q1) / (1.0 + a);
  const double base = 0.3 + (1.0 - g) / g * (z1 - 0.3);
  CHECK(call.next[0] == doctest::Approx((base + a * 1.5) / (1.0 + a)).epsilon(1e-13));

  // q = 1.2 + t, dz/dt = (q - z) / tau.
  const auto error = [](double h) {
    Call each = relaxing_call(2);
    each.time_step = h;
    each.q = 1.2 + h;
    REQUIRE(each.run(relaxing) == SPRINGNET_OK);
    const double tau = 0.5, exact = 1.2 + h - tau + (0.3 - 1.2 + tau) * std::exp(-h / tau);
    return std::abs(each.next[0] - exact);
  };
  CHECK(error(0.02) / error(0.01) == doctest::Approx(8.0).epsilon(0.05));
}

TEST_CASE("a state that relaxes in a millionth of the step follows without ringing") {
  for (const std::uint32_t order : {1u, 2u}) {
    for (const bool one_way : {false, true}) {
      Call call = one_way ? ratchet_call(order) : relaxing_call(order);
      call.parameters.back() = 0.25e-6;
      REQUIRE(call.run(one_way ? ratchet : relaxing) == SPRINGNET_OK);
      CHECK(call.next[0] == doctest::Approx(1.5).epsilon(1e-5));
    }
  }
}

TEST_CASE("rates with a kink: a step of order 2 is extrapolated from half steps, and does not go too far for good") {
  // q = 1.2 + t, z' = max(q - z, 0) / tau from 0.3 on: as without the kink, which is not reached.
  const auto error = [](double h) {
    Call each = ratchet_call(2);
    each.time_step = h;
    each.q = 1.2 + h;
    REQUIRE(each.run(ratchet) == SPRINGNET_OK);
    const double tau = 0.5, exact = 1.2 + h - tau + (0.3 - 1.2 + tau) * std::exp(-h / tau);
    return std::abs(each.next[0] - exact);
  };
  CHECK(error(0.02) / error(0.01) == doctest::Approx(8.0).epsilon(0.05));

  // A constant q = 1.5, of which the state is 1.2 away: 1 - 2 / (1 + s/2)^2 + 1 / (1 + s) of the way in s relaxation
  // times, which is 1.0362 at most.
  double most = 0.0;
  for (double s = 1.0 / 64.0; s <= 65536.0; s *= std::sqrt(2.0)) {
    Call call = ratchet_call(2);
    call.start_q = call.q;
    call.parameters[0] = call.time_step / s;
    REQUIRE(call.run(ratchet) == SPRINGNET_OK);
    const double share = 1.0 - 2.0 / ((1.0 + 0.5 * s) * (1.0 + 0.5 * s)) + 1.0 / (1.0 + s);
    CHECK(call.next[0] == doctest::Approx(0.3 + 1.2 * share).epsilon(1e-14));
    most = std::max(most, share);
  }
  CHECK(most == doctest::Approx(1.0361).epsilon(2e-4));

  // On the kink, but for rounding: a fast relaxation multiplies that of the drive, which is no reason to fail. The
  // path is that of a spring that yields, is held, and yields again.
  for (double s = 1e6; s <= 1e13; s *= 1.7) {
    for (const double off : {0.0, 1e-17, -1e-17, 3e-16, -3e-16, 7e-10, -7e-10, 1e-7}) {
      Call call = ratchet_call(2);
      call.q = call.start_q = 0.28121420912345 + 1.0;
      call.z = {call.q - off};
      call.parameters[0] = call.time_step / s;
      REQUIRE(call.run(ratchet) == SPRINGNET_OK);
      CHECK(call.next[0] == doctest::Approx(call.q).epsilon(1e-9));
    }
  }

  // Where that is beyond a bound, the state is at the bound, and stays there.
  Call call = ratchet_call(2);
  call.start_q = call.q = 2.0;
  call.parameters[0] = call.time_step / 16.0;
  REQUIRE(call.run(ratchet) == SPRINGNET_OK);
  CHECK(call.next[0] == 2.0);
  CHECK(call.next_by_q[0] == 0.0);
  CHECK(call.next_by_states[0] == 0.0);
}

TEST_CASE("total derivatives of a step against differences") {
  for (const std::uint32_t order : {1u, 2u}) {
    CAPTURE(order);
    Call at = coupled_call(order);
    REQUIRE(at.run(coupled) == SPRINGNET_OK);
    CHECK(at.next[0] > 0.0);
    // Truncation below 1e-13, rounding of an equation solved to 1e-15: 1e-15 / 1e-2.
    const auto check = [&](double Call::*field, double* element, const auto& answer, double expected) {
      const auto f = [&](double value) {
        Call moved = coupled_call(order);
        if (element != nullptr)
          (element >= at.z.data() && element < at.z.data() + 2
               ? moved.z[static_cast<std::size_t>(element - at.z.data())]
               : moved.parameters[0]) = value;
        else
          moved.*field = value;
        REQUIRE(moved.run(coupled) == SPRINGNET_OK);
        return answer(moved);
      };
      const double centre = element != nullptr ? *element : at.*field;
      CHECK(std::abs(springnet::test::derivative(f, centre, 1e-2) - expected) < 1e-10);
    };
    const auto force = [](const Call& call) { return call.force; };
    check(&Call::q, nullptr, force, at.by_q);
    check(&Call::rate, nullptr, force, at.by_rate);
    check(nullptr, &at.parameters[0], force, at.by_parameters[0]);
    for (std::size_t j = 0; j < 2; ++j) check(nullptr, &at.z[j], force, at.by_states[j]);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto next = [i](const Call& call) { return call.next[i]; };
      check(&Call::q, nullptr, next, at.next_by_q[i]);
      check(&Call::rate, nullptr, next, at.next_by_rate[i]);
      check(nullptr, &at.parameters[0], next, at.next_by_parameters[i]);
      for (std::size_t j = 0; j < 2; ++j) check(nullptr, &at.z[j], next, at.next_by_states[2 * i + j]);
    }
  }
}

TEST_CASE("a step gives the same bits for every instruction set and number of elements") {
  for (const std::uint32_t order : {1u, 2u}) {
    Call one = coupled_call(order);
    REQUIRE(one.run(coupled) == SPRINGNET_OK);
    for (const std::uint32_t set : instruction_sets()) {
      for (const std::uint32_t count : {2u, 7u, 256u, 300u}) {
        CAPTURE(set);
        CAPTURE(count);
        Call call = coupled_call(order);
        call.set = set;
        call.count = count;
        REQUIRE(call.run(coupled) == SPRINGNET_OK);
        CHECK(same_bits(call.next, one.next));
        CHECK(same_bits({call.force, call.by_q, call.by_rate}, {one.force, one.by_q, one.by_rate}));
        CHECK(same_bits(call.next_by_states, one.next_by_states));
      }
    }
  }
}

TEST_CASE("a law's own update() is used in place of the SDK's, with its derivatives") {
  CHECK(law_of(summing).update_order == 2);
  CHECK(law_of(summing).reads_start == 1);
  Call call;
  call.z = {0.3};
  call.order = 2;
  REQUIRE(call.run(summing) == SPRINGNET_OK);
  CHECK(call.next[0] == doctest::Approx(0.3 + 0.25 * 1.35).epsilon(1e-15));
  CHECK(call.force == call.next[0]);
  CHECK(call.next_by_q[0] == 0.125);
  CHECK(call.next_by_states[0] == 1.0);
  CHECK(call.by_q == 0.125);
}

TEST_CASE("start() gives the states at the start") {
  const springnet_law& law = law_of(relaxing);
  REQUIRE((law.start != nullptr));
  const double q[] = {1.5, 0.25}, declared[] = {0.0, 0.0};
  double states[] = {7.0, 7.0};
  const double* state_list = declared;
  double* out = states;
  const double parameters[] = {20.0, 0.5};
  const double* const parameter_list[] = {&parameters[0], &parameters[1]};
  const std::uint32_t strides[] = {0, 0};
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 2;
  batch.q = q;
  batch.states = &state_list;
  batch.parameters = parameter_list;
  batch.parameter_strides = strides;
  const springnet_law_start start{sizeof start, 0, &batch, &out};
  REQUIRE(law.start(law.context, &start) == SPRINGNET_OK);
  CHECK(states[0] == 1.5);
  CHECK(states[1] == 0.25);
}

TEST_CASE("steps that cannot be made: no state within the bounds, no time, no start") {
  Call call;
  call.z = {0.5};
  call.time_step = 0.75;
  CHECK(call.run(stuck) == SPRINGNET_RECOVERABLE);
  CHECK(std::string(call.message.text).find("within the bounds") != std::string::npos);
  call.time_step = 0.25;  // a smaller step succeeds
  REQUIRE(call.run(stuck) == SPRINGNET_OK);
  CHECK(call.next[0] == doctest::Approx(0.75).epsilon(1e-15));

  for (const double no_time : {0.0, -1.0, std::nan("")}) {
    call.time_step = no_time;
    CHECK(call.run(stuck) == SPRINGNET_FAILED);
    CHECK(std::string(call.message.text) == "the host asked for a step that takes no time");
  }

  const double q = 1.0, z = 0.5;
  const double* state_list = &z;
  springnet_message message{};
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.q = &q;
  batch.states = &state_list;
  batch.message = &message;
  springnet_law_update update{};
  update.struct_size = sizeof update;
  update.order = 2;
  update.batch = &batch;
  update.time_step = 0.1;
  CHECK(law_of(stuck).update(nullptr, &update) == SPRINGNET_FAILED);
  CHECK(std::string(message.text) == "the host did not give the invariant at the start of the step");
  update.struct_size = 8;
  CHECK(law_of(stuck).update(nullptr, &update) == SPRINGNET_FAILED);
}
