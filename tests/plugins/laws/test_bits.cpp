// Every output of every law has the same bits for every instruction set, tile size and stride.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "shipped.hpp"

using namespace springnet::test;

namespace {

// 1000 elements with random inputs; parameter j has one value for all if bit j of `uniform` is set, the reference value
// if the highest bit is.
LawInput random_input(const springnet_component& law, std::uint32_t uniform) {
  const springnet_law& functions = law_of(law);
  std::mt19937 engine(42);
  const auto draw = [&](std::uint32_t count, double from, double to) {
    std::uniform_real_distribution<double> distribution(from, to);
    Array result(count);
    for (double& value : result) value = distribution(engine);
    return result;
  };
  LawInput input;
  input.count = 1000;
  input.q = draw(1000, 0.2, 2.5);
  input.rate = draw(1000, -2.0, 2.0);
  input.reference = draw((uniform & 0x80000000u) != 0 ? 1 : 1000, 0.5, 1.5);
  for (std::uint32_t j = 0; j < law.parameter_count; ++j) {
    const bool boolean = law.parameters[j]->type == SPRINGNET_BOOLEAN;
    Array values = draw((uniform >> j & 1u) != 0 ? 1 : 1000, 0.1, 3.0);
    if (boolean) {
      for (double& value : values) value = value < 1.5 ? 0.0 : 1.0;
    }
    input.parameters.push_back(values);
  }
  for (std::uint32_t j = 0; j < functions.state_count; ++j) input.states.push_back(draw(1000, 0.0, 0.9));
  for (std::uint32_t j = 0; j < functions.input_count; ++j)
    input.inputs.push_back(draw((uniform & 1u) != 0 ? 1 : 1000, 0.0, 1.0));
  // Corners: rest, standstill, what is not finite.
  input.q[3] = input.reference[input.reference.size() == 1 ? 0 : 3];
  input.rate[4] = 0.0;
  input.q[5] = std::nan("");
  input.rate[6] = HUGE_VAL;
  return input;
}

LawInput spread(LawInput input) {
  if (input.reference.size() == 1) input.reference.assign(input.count, input.reference[0]);
  for (Array& each : input.parameters) {
    if (each.size() == 1) each.assign(input.count, each[0]);
  }
  for (Array& each : input.inputs) {
    if (each.size() == 1) each.assign(input.count, each[0]);
  }
  return input;
}

}  // namespace

TEST_CASE("same bits for every instruction set, tile size and stride") {
  for (const springnet_plugin* plugin : shipped_plugins()) {
    const springnet_component& law = *plugin->components[0];
    if (law.kind == SPRINGNET_NEURON) continue;
    // Those over several invariants: test_jacobians.cpp.
    if (static_cast<const springnet_law*>(law.implementation)->invariant == SPRINGNET_SEVERAL) continue;
    CAPTURE(std::string(plugin->id));
    const std::uint32_t next = law.parameter_count > 5 ? 37 : 1;  // of so many, some
    for (std::uint32_t uniform = 0; uniform < 1u << law.parameter_count; uniform += next) {
      for (const std::uint32_t reference : {0u, 0x80000000u}) {
        CAPTURE(uniform);
        CAPTURE(reference);
        const LawInput input = random_input(law, uniform | reference);
        const LawAnswer whole = evaluate(law, input);
        REQUIRE(whole.status == SPRINGNET_OK);
        CHECK(same_bits(evaluate(law, spread(input)), whole));
        for (const std::uint32_t set : instruction_sets()) {
          for (const std::uint32_t tile : {1u, 2u, 7u, 64u, 255u, 256u, 257u, 512u, 999u, 1000u}) {
            CAPTURE(set);
            CAPTURE(tile);
            CHECK(same_bits(evaluate(law, input, set, tile), whole));
          }
        }
      }
    }
  }
}
