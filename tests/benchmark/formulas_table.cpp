// The time of laws given as formulas beside the same laws compiled with the SDK, ns a spring: force, and force with
// dT/dl, over batches as large as those of the engine with the same parameters and rest lengths of their own. Both give
// the same bits. Bounds of the ratio: 3 for a polynomial, 1.5 where exp takes most of the time; a ratio beyond its
// bound gets a '!'.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <random>
#include <vector>

#include <springnet/formula.hpp>
#include <springnet/host_laws.hpp>

#include "law_call.hpp"
#include "layers/kernels.hpp"

namespace {

constexpr std::uint32_t springs = springnet::layers::max_segment;  // arrays are aligned like the engine's

struct Cubic : springnet::sdk::SpringFunction {
  static constexpr const char *id = "cubic", *summary = "stiffness x + cubic x^3";
  static constexpr springnet::sdk::Parameter parameters[] = {springnet::sdk::number("stiffness", "N/m", ""),
                                                             springnet::sdk::number("cubic", "N/m^3", "")};
  static auto force(const auto& e, const auto& p) {
    const auto x = e.elongation();
    return p[0] * x + p[1] * (x * x * x);
  }
};
struct Quintic : springnet::sdk::SpringFunction {
  static constexpr const char *id = "quintic", *summary = "by Horner's rule";
  static constexpr springnet::sdk::Parameter parameters[] = {springnet::sdk::number("stiffness", "N/m", ""),
                                                             springnet::sdk::number("cubic", "N/m^3", ""),
                                                             springnet::sdk::number("quintic", "N/m^5", "")};
  static auto force(const auto& e, const auto& p) {
    const auto x = e.elongation();
    const auto x2 = x * x;
    return x * (p[0] + x2 * (p[1] + x2 * p[2]));
  }
};
struct Tissue : springnet::sdk::SpringFunction {
  static constexpr const char *id = "tissue", *summary = "stiffness l0 / exponent (exp(exponent x / l0) - 1)";
  static constexpr bool divides_by_reference = true;
  static constexpr springnet::sdk::Parameter parameters[] = {springnet::sdk::number("stiffness", "N/m", ""),
                                                             springnet::sdk::number("exponent", "1", "")};
  static auto force(const auto& e, const auto& p) { return p[0] * e.reference / p[1] * expm1(p[1] * e.strain()); }
};

struct Rival {
  const char* name;
  springnet::HostComponent compiled;
  const char* formula;
  std::vector<const char*> parameters;
  std::vector<double> values;
  double bound;
};

struct Results {
  alignas(64) double force[springs], by_length[springs];
};

// Best of many batches of each of two laws in turn, so that both have the machine's better and worse times, ns a
// spring.
std::array<double, 2> nanoseconds(const std::array<const springnet_law*, 2>& laws, const std::vector<double>& values,
                                  std::uint32_t set, bool tangent, Results (&results)[2]) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> rests(0.5, 1.5), stretches(0.8, 1.2);
  alignas(64) static double length[springs], rest[springs];
  for (std::uint32_t i = 0; i < springs; ++i) {
    rest[i] = rests(random);
    length[i] = rest[i] * stretches(random);
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
  batch.q = length;
  batch.reference = rest;
  batch.parameters = parameters.data();
  batch.parameter_strides = strides.data();
  batch.message = &message;
  constexpr int calls = 16;  // that one look at the clock covers
  std::array<double, 2> best{1e9, 1e9};
  for (int repetition = 0; repetition < 800; ++repetition) {
    const std::size_t which = repetition % 2;
    batch.force = results[which].force;
    batch.force_by_q = tangent ? results[which].by_length : nullptr;
    const auto begin = std::chrono::steady_clock::now();
    for (int call = 0; call < calls; ++call) laws[which]->evaluate(laws[which]->context, &batch);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    best[which] = std::min(best[which], time.count());
  }
  for (double& each : best) each *= 1e9 / (calls * springs);
  return best;
}

}  // namespace

int main() {
  using springnet::spring_function;
  const std::vector<Rival> rivals{
      {"cubic", spring_function(Cubic()), "stiffness*e + cubic*e^3", {"stiffness", "cubic"}, {3.0, 2.0}, 3.0},
      {"quintic",
       spring_function(Quintic()),
       "e*(stiffness + e^2*(cubic + e^2*quintic))",
       {"stiffness", "cubic", "quintic"},
       {3.0, 2.0, 1.0},
       3.0},
      {"exponential",
       spring_function(Tissue()),
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
    const auto& compiled = *static_cast<const springnet_law*>(rival.compiled.description().implementation);
    for (const std::uint32_t set : springnet::test::instruction_sets()) {
      for (const bool tangent : {false, true}) {
        static Results results[2];
        const auto [of_plugin, of_formula] =
            nanoseconds({&compiled, &as_formula->law()}, rival.values, set, tangent, results);
        for (std::uint32_t i = 0; i < springs; ++i)
          same =
              same && results[0].force[i] == results[1].force[i] && results[0].by_length[i] == results[1].by_length[i];
        const double ratio = of_formula / of_plugin;
        std::printf("| %s | %s | %s | %.3f | %.3f | %.2f%s | %g |\n", rival.name,
                    set == SPRINGNET_AVX512 ? "AVX-512" : (set == SPRINGNET_AVX2 ? "AVX2" : "SSE2"),
                    tangent ? "force and dT/dl" : "force", of_plugin, of_formula, ratio,
                    ratio > rival.bound ? " !" : "", rival.bound);
      }
    }
  }
  std::printf("%s\n", same ? "Both give the same bits." : "The results differ.");
  return same ? 0 : 1;
}
