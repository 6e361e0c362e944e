// The time of laws given as formulas beside the same compiled laws, ns a spring: force, and force with dT/dl, over
// batches of 4096 springs with the same parameters and rest lengths of their own. Bounds of the ratio: 3 for a
// polynomial, 1.5 where exp takes most of the time; a ratio beyond its bound gets a '!'.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <random>
#include <vector>

#include <springnet/formula.hpp>
#include <springnet/plugin_host.hpp>

#include "law_call.hpp"

namespace {

using springnet::Component;

constexpr std::uint32_t springs = 4096;

struct Rival {
  const char* name;
  const char* formula;
  std::vector<const char*> parameters;
  std::vector<double> values;
  double bound;
};

// Best of many batches, ns a spring.
double nanoseconds(const Component& component, const std::vector<double>& values, std::uint32_t set, bool tangent,
                   std::vector<double>& force, std::vector<double>& by_length) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> rests(0.5, 1.5), stretches(0.8, 1.2);
  std::vector<double> length, rest;
  for (std::uint32_t i = 0; i < springs; ++i) {
    rest.push_back(rests(random));
    length.push_back(rest.back() * stretches(random));
  }
  std::vector<const double*> parameters;
  for (const double& value : values) parameters.push_back(&value);
  const std::vector<std::uint32_t> strides(parameters.size(), 0);
  springnet_message message{};
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = springs;
  batch.instruction_set = set;
  batch.reference_stride = 1;
  batch.q = length.data();
  batch.reference = rest.data();
  batch.parameters = parameters.data();
  batch.parameter_strides = strides.data();
  batch.force = force.data();
  batch.force_by_q = tangent ? by_length.data() : nullptr;
  batch.message = &message;
  const springnet_law& law = component.law();
  double best = 1e9;
  for (int repetition = 0; repetition < 400; ++repetition) {
    const auto begin = std::chrono::steady_clock::now();
    law.evaluate(law.context, &batch);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    best = std::min(best, time.count());
  }
  return 1e9 * best / springs;
}

}  // namespace

int main() {
  const springnet::PluginHost host = springnet::PluginHost::with_default_search();
  // `nonlinear` has a third parameter, which is 0 here.
  const std::vector<Rival> rivals{{"nonlinear", "stiffness*e + cubic*e^3", {"stiffness", "cubic"}, {3.0, 2.0}, 3.0},
                                  {"exponential",
                                   "stiffness*reference/exponent*expm1(exponent*strain)",
                                   {"stiffness", "exponent"},
                                   {3.0, 10.0},
                                   1.5}};
  std::printf(
      "| law | instruction set | what | compiled, ns | formula, ns | ratio | bound |\n|---|---|---|---|---|---|---|\n");
  bool same = true;
  for (const Rival& rival : rivals) {
    springnet::LawFormula formula;
    formula.force = rival.formula;
    for (const char* name : rival.parameters) formula.parameters.push_back({name});
    const auto as_formula = springnet::component_of(formula);
    const auto compiled = host.require(springnet::ComponentKind::spring_function, rival.name);
    std::vector<double> values = rival.values;
    values.resize(compiled->description->parameter_count, 0.0);
    for (const std::uint32_t set : springnet::test::instruction_sets()) {
      for (const bool tangent : {false, true}) {
        std::vector<double> force[2], by_length[2];
        for (auto& each : force) each.resize(springs);
        for (auto& each : by_length) each.resize(springs);
        const double of_plugin = nanoseconds(*compiled, values, set, tangent, force[0], by_length[0]);
        const double of_formula = nanoseconds(*as_formula, rival.values, set, tangent, force[1], by_length[1]);
        for (std::uint32_t i = 0; i < springs; ++i) {
          same = same && std::abs(force[0][i] - force[1][i]) <= 1e-13 * (1.0 + std::abs(force[0][i])) &&
                 std::abs(by_length[0][i] - by_length[1][i]) <= 1e-12 * (1.0 + std::abs(by_length[0][i]));
        }
        const double ratio = of_formula / of_plugin;
        std::printf("| %s | %s | %s | %.3f | %.3f | %.2f%s | %g |\n", rival.name,
                    set == SPRINGNET_AVX512 ? "AVX-512" : (set == SPRINGNET_AVX2 ? "AVX2" : "SSE2"),
                    tangent ? "force and dT/dl" : "force", of_plugin, of_formula, ratio,
                    ratio > rival.bound ? " !" : "", rival.bound);
      }
    }
  }
  std::printf("%s\n", same ? "Both give the same forces." : "The forces differ.");
  return same ? 0 : 1;
}
