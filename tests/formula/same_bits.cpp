// Formulas against the same formulas compiled with the SDK: all outputs, to the bit, in every instruction set.
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/formula.hpp>
#include <springnet/host_laws.hpp>
#include <springnet/sdk/law.hpp>

#include "layers/instruction_set.hpp"

using namespace springnet;

namespace {

struct Worm : sdk::SpringFunction {
  using has = sdk::Has<sdk::Energy, sdk::Margin>;
  static constexpr const char *id = "worm", *summary = "a chain with a limit, a viscosity, and everything else";
  static constexpr bool reads_rate = true, reads_time = true, divides_by_reference = true;
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", ""), sdk::number("limit", "m", ""),
                                                  sdk::number("power", "1", ""), sdk::number("damping", "N s/m", "")};
  static constexpr sdk::Parameter inputs[] = {sdk::number("drive", "1", "").preset(0)};
  static auto force(const auto& e, const auto& p) {
    const auto x = e.elongation() / p[1];
    const auto stretch = e.q / e.reference;
    const auto toe = max(e.strain(), 0.0);
    return p[0] * e.elongation() / (1.0 - x * x) + 0.1 * p[0] * pow(stretch, p[2]) * exp(-0.5 * toe) +
           p[3] * e.rate * abs(e.rate) + (1.0 + sin(3.0 * e.time)) * e.input(0) - hypot(x, 0.25) * atan2(x, stretch);
  }
  static auto energy(const auto& e, const auto& p) {
    const auto x = e.elongation() / p[1];
    return -0.5 * p[0] * (p[1] * p[1]) * log1p(-(x * x)) + sqrt(e.q) * cbrt(e.reference);
  }
  static auto margin(const auto& e, const auto& p) {
    return 1.0 - tanh(e.elongation() / p[1]) * clamp(e.strain(), -0.5, 0.5);
  }
};

LawFormula worm() {
  LawFormula law;
  law.force =
      "x = e / limit; toe = max(strain, 0);\n"
      "stiffness*e/(1 - x^2) + 0.1*stiffness*stretch^power*exp(-0.5*toe)  # with a power that is a parameter\n"
      " + damping*rate*abs(rate) + (1 + sin(3*time))*drive - hypot(x, 0.25)*atan2(x, stretch)";
  law.energy = "x = e/limit; -0.5*stiffness*(limit*limit)*log1p(-(x^2)) + sqrt(length)*cbrt(rest)";
  law.margin = "1 - tanh(e/limit)*clamp(strain, -0.5, 0.5)";
  law.parameters = {{"stiffness"}, {"limit"}, {"power"}, {"damping"}};
  law.inputs = {{"drive", "", 0.0}};
  return law;
}

struct EnergyAlone : sdk::SpringFunction {
  using has = sdk::Has<sdk::Energy>;
  static constexpr const char *id = "energy_alone", *summary = "Morse's potential";
  static constexpr sdk::Parameter parameters[] = {sdk::number("depth", "J", ""), sdk::number("width", "1/m", "")};
  static auto energy(const auto& e, const auto& p) {
    const auto y = 1.0 - exp(-p[1] * e.elongation());
    return p[0] * (y * y);
  }
};
LawFormula energy_alone() {
  LawFormula law;
  law.energy = "depth*(1 - exp(-width*e))^2";
  law.parameters = {{"depth"}, {"width"}};
  return law;
}

struct Sheet : sdk::SpringFunction {
  using has = sdk::Has<sdk::Energy>;
  static constexpr const char *id = "sheet", *summary = "a triangle whose edges and area resist";
  static constexpr sdk::Shape shape = sdk::Shape::triangle;
  static constexpr sdk::Scalar invariants[] = {sdk::length_of(0, 1), sdk::length_of(0, 2), sdk::area_of(0, 1, 2),
                                               sdk::at_rest(sdk::length_of(1, 2))};
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", ""),
                                                  sdk::number("tension", "N/m", "")};
  static auto energy(const auto& e, const auto& p) {
    const auto x = e.q[0] - e.reference[0], y = e.q[1] - e.reference[1];
    const auto z = e.q[2] / e.reference[2] - 1.0;
    return 0.5 * p[0] * (x * x + y * y + 0.3 * x * y * z) + p[1] * e.reference[3] * (z * z) * sqrt(e.q[2]);
  }
};
LawFormula sheet() {
  LawFormula law;
  law.shape = Invariant::triangle;
  law.scalars = {{"a", "length(0, 1)"}, {"b", "length(0, 2)"}, {"area", "area(0, 1, 2)"}, {"c", "length(1, 2)"}};
  law.energy =
      "x = a - rest(a); y = b - rest(b); z = area/rest(area) - 1;"
      "0.5*stiffness*(x*x + y*y + 0.3*x*y*z) + tension*rest(c)*z^2*sqrt(area)";
  law.parameters = {{"stiffness"}, {"tension"}};
  return law;
}

struct Relaxing : sdk::SpringFunction {
  using has = sdk::Has<sdk::Energy>;
  static constexpr const char *id = "relaxing", *summary = "two states, an input, a viscosity";
  static constexpr bool reads_rate = true;
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", ""), sdk::number("tau", "s", "")};
  static constexpr sdk::Parameter inputs[] = {sdk::number("drive", "m", "").preset(0)};
  static constexpr sdk::Parameter states[] = {sdk::number("flow", "m", "").preset(0),
                                              sdk::number("heat", "1", "").preset(0.5).learnable(0.5)};
  static auto force(const auto& e, const auto& p) {
    return p[0] * (e.elongation() - e.state(0)) * (1.0 + 0.1 * e.state(1)) + 0.2 * e.rate;
  }
  static auto energy(const auto& e, const auto& p) {
    const auto x = e.elongation() - e.state(0);
    return 0.5 * p[0] * (x * x);
  }
  static auto state_rates(const auto& e, const auto& p) {
    const auto x = e.elongation() - e.state(0) + 0.1 * e.input(0);
    return std::array{x / p[1] * exp(e.state(1)), abs(x) - 0.3 * e.state(1) + 0.01 * e.rate};
  }
};
LawFormula relaxing() {
  LawFormula law;
  law.force = "stiffness*(e - flow)*(1 + 0.1*heat) + 0.2*rate";
  law.energy = "x = e - flow; 0.5*stiffness*(x*x)";
  law.states = {{"flow", "(e - flow + 0.1*drive)/tau*exp(heat)", 0.0},
                {"heat", "abs(e - flow + 0.1*drive) - 0.3*heat + 0.01*rate", 0.5}};
  law.parameters = {{"stiffness"}, {"tau"}};
  law.inputs = {{"drive", "", 0.0}};
  return law;
}

// Steps of a fast relaxation go beyond the end, where the bound holds the state.
struct Filling : sdk::SpringFunction {
  static constexpr const char *id = "filling", *summary = "a state that stops at its bound, and one of another size";
  static constexpr bool acts_in_compression = false, monotone = true, not_zero_at_rest = true, adds_power = true;
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", ""), sdk::number("tau", "s", "")};
  static constexpr sdk::Parameter states[] = {sdk::number("full", "1", "").preset(0).at_least(-0.5).at_most(1.0),
                                              sdk::number("heat", "1", "").preset(0).at_least(-1000).learnable(300)};
  static auto force(const auto& e, const auto& p) {
    return p[0] * e.elongation() * (1.0 - 0.5 * e.state(0)) + 0.001 * e.state(1);
  }
  static auto state_rates(const auto& e, const auto& p) {
    return std::array{(0.5 + abs(e.elongation())) * (1.0 - e.state(0)) / (0.01 * p[1]),
                      e.elongation() - 0.3 * e.state(1) * abs(e.state(1))};
  }
};
LawFormula filling() {
  LawFormula law;
  law.force = "stiffness*e*(1 - 0.5*full) + 0.001*heat";
  law.states = {{"full", "(0.5 + abs(e))*(1 - full)/(0.01*tau)"}, {"heat", "e - 0.3*heat*abs(heat)"}};
  law.states[0].smallest = -0.5;
  law.states[0].largest = 1.0;
  law.states[1].smallest = -1000;
  law.states[1].scale = 300;
  law.parameters = {{"stiffness"}, {"tau"}};
  law.pulls_only = law.monotone = law.not_zero_at_rest = law.adds_power = true;
  return law;
}

struct Smooth : sdk::SpringFunction {
  static constexpr const char *id = "smooth", *summary = "Maxwell's element";
  static constexpr bool smooth_rates = true;
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", ""), sdk::number("tau", "s", "")};
  static constexpr sdk::Parameter states[] = {sdk::number("flow", "m", "").preset(0)};
  static auto force(const auto& e, const auto& p) { return p[0] * (e.elongation() - e.state(0)); }
  static auto state_rates(const auto& e, const auto& p) { return std::array{(e.elongation() - e.state(0)) / p[1]}; }
};
LawFormula smooth() {
  LawFormula law;
  law.force = "stiffness*(e - flow)";
  law.states = {{"flow", "(e - flow)/tau"}};
  law.parameters = {{"stiffness"}, {"tau"}};
  law.smooth_rates = true;
  return law;
}

// Products that only a sum, a difference or a product reads, which programs do in one loop with it; e^x - 1 with its
// slope. abs keeps the parts apart.
struct Joined : sdk::SpringFunction {
  static constexpr const char *id = "joined", *summary = "products, sums and differences";
  static constexpr sdk::Parameter parameters[] = {sdk::number("a", "1", ""), sdk::number("b", "1", ""),
                                                  sdk::number("c", "1", ""), sdk::number("d", "1", "")};
  static auto force(const auto& e, const auto& p) {
    const auto x = e.elongation(), y = e.q;
    return abs(x * p[0] * y + p[1]) + abs((p[0] * x + p[1]) * y) + abs((x * y + p[2]) * p[3]) +
           abs(x * p[0] + y * p[1]) + abs(p[2] * p[3] * x - y * p[0]) + abs(x * x - y * y) + abs(p[1] - x * y) +
           abs(x * y - p[2]) + abs(x * p[2] * y) + abs(p[0] * p[1] * p[2]) + abs(p[0] * p[1] + p[2] * p[3]) +
           abs((x + x) * y + p[3]) + abs(expm1(p[0] * x)) + expm1(p[3]);
  }
};
LawFormula joined() {
  LawFormula law;
  law.force =
      "x = e; y = length; abs(x*a*y + b) + abs((a*x + b)*y) + abs((x*y + c)*d) + abs(x*a + y*b) + abs(c*d*x - y*a)"
      " + abs(x*x - y*y) + abs(b - x*y) + abs(x*y - c) + abs(x*c*y) + abs(a*b*c) + abs(a*b + c*d) + abs((x + x)*y + d)"
      " + abs(expm1(a*x)) + expm1(d)";
  law.parameters = {{"a"}, {"b"}, {"c"}, {"d"}};
  return law;
}

// What an author writes with 0 is computed: its sign counts.
struct Nothing : sdk::SpringFunction {
  using has = sdk::Has<sdk::Energy>;
  static constexpr const char *id = "nothing", *summary = "terms and factors of 0";
  static constexpr sdk::Parameter parameters[] = {sdk::number("a", "1", "")};
  static auto force(const auto& e, const auto& p) {
    const auto x = e.q - 1.0, zero = 0.0 * x;
    return p[0] * atan2(zero, -1.0) + atan2(0.0 - zero, -1.0) + 2.0 * atan2(0.0 + zero, -1.0) +
           3.0 * atan2(0.0 / x, -1.0) + 4.0 * atan2(zero - 0.0, -1.0) + x * 0.0;
  }
  static auto energy(const auto& e, const auto& p) { return (0.0 - p[0]) * (0.0 * e.q + e.q * e.q); }
};
LawFormula nothing() {
  LawFormula law;
  law.force =
      "x = length - 1; zero = 0*x; a*atan2(zero, 0 - 1) + atan2(0 - zero, -1) + 2*atan2(0 + zero, -1) + "
      "3*atan2(0/x, -1) + 4*atan2(zero - 0, -1) + x*0";
  law.energy = "(0 - a)*(0*length + length^2)";
  law.parameters = {{"a"}};
  return law;
}

// Which arguments are the same for all: no one, the reference and all parameters and inputs, or every second of them.
enum class Uniform { nothing, all, some };

// What a law answers to a batch of random arguments, all arrays of all outputs.
class Answers {
 public:
  Answers(const springnet_component& component, std::uint32_t instruction_set, std::size_t count, Uniform uniform,
          unsigned seed) {
    const auto& law = *static_cast<const springnet_law*>(component.implementation);
    const bool several = law.invariant == SPRINGNET_SEVERAL;
    const std::size_t V = several ? law.invariant_count : 1, P = component.parameter_count, I = law.input_count;
    const std::size_t S = law.state_count;
    const sdk::JacobianLayout layout{V, P, S, I};
    const bool has_energy = (component.capabilities & SPRINGNET_HAS_ENERGY) != 0;
    const bool has_margin = (component.capabilities & SPRINGNET_HAS_RUPTURE) != 0;
    std::mt19937 random(seed);
    const auto numbers = [&](double low, double high) {
      std::vector<double>& values = memory_.emplace_back(count);
      for (double& x : values) x = std::uniform_real_distribution<double>(low, high)(random);
      return values.data();
    };
    const auto output = [&](const std::string& name) {
      names_.push_back(name);
      outputs_.emplace_back(new std::vector<double>(count, -7.0));
      return outputs_.back()->data();
    };
    springnet_law_batch b{};
    springnet_message message{};
    b.struct_size = sizeof b;
    b.count = static_cast<std::uint32_t>(count);
    b.instruction_set = instruction_set;
    b.time = 0.37;
    b.message = &message;
    const std::uint32_t stride = uniform == Uniform::all ? 0 : 1;
    std::vector<const double*> parameters, inputs, states, values, rates, references;
    std::vector<std::uint32_t> strides(P + I + 1, stride);
    for (std::size_t k = 0; uniform == Uniform::some && k < strides.size(); k += 2) strides[k] = 0;
    for (std::size_t k = 0; k < P; ++k) parameters.push_back(numbers(0.6 + static_cast<double>(k), 2.6));
    for (std::size_t k = 0; k < I; ++k) inputs.push_back(numbers(-1.0, 1.0));
    for (std::size_t i = 0; i < V; ++i) {
      const bool at_rest = several && (law.invariants[i]->flags & SPRINGNET_REFERENCE_ONLY) != 0;
      values.push_back(at_rest ? nullptr : numbers(0.8, 1.2));
      rates.push_back(at_rest ? nullptr : numbers(-1.0, 1.0));
      references.push_back(numbers(0.9, 1.1));
    }
    for (std::size_t k = 0; k < S; ++k) states.push_back(numbers(-0.1, 0.3));
    b.states = states.data();
    b.parameters = parameters.data();
    b.parameter_strides = strides.data();
    b.inputs = inputs.data();
    b.input_strides = strides.data();
    if (several) {
      b.values = values.data();
      b.rates = (component.capabilities & SPRINGNET_READS_RATE) != 0 ? rates.data() : nullptr;
      b.references = references.data();
    } else {
      b.q = values[0];
      b.rate = (component.capabilities & SPRINGNET_READS_RATE) != 0 ? rates[0] : nullptr;
      b.reference = references[0];
      b.reference_stride = stride;
    }
    std::vector<double*> forces, by_parameters, matrix(layout.rows() * layout.columns(false), nullptr);
    if (several) {
      for (std::size_t i = 0; i < V; ++i)
        forces.push_back(values[i] == nullptr ? nullptr : output("force " + std::to_string(i)));
      b.forces = forces.data();
    } else {
      b.force = output("force");
      b.force_by_q = output("by q");
      b.force_by_rate = output("by rate");
      for (std::size_t k = 0; k < P; ++k) by_parameters.push_back(output("by parameter " + std::to_string(k)));
      b.force_by_parameters = by_parameters.data();
      if (has_energy) b.energy_by_q = output("energy by q");
    }
    if (has_energy) b.energy = output("energy");
    if (has_margin) b.margin = output("margin");
    for (std::size_t row = 0; row < layout.rows(); ++row) {
      if (row == layout.energy() && !has_energy) continue;
      if (row == layout.margin() && !has_margin) continue;
      for (std::size_t column = 0; column < layout.columns(false); ++column)
        matrix[row * layout.columns(false) + column] =
            output("row " + std::to_string(row) + " column " + std::to_string(column));
    }
    b.derivatives = matrix.data();
    std::vector<double*> of_states[9];
    const auto list = [&](std::size_t k, std::size_t size, const std::string& name) {
      for (std::size_t i = 0; i < size; ++i) of_states[k].push_back(output(name + " " + std::to_string(i)));
      return of_states[k].data();
    };
    if (S > 0) {
      b.force_by_states = list(0, S, "force by state");
      if (has_energy) b.energy_by_states = list(1, S, "energy by state");
      b.state_rates = list(2, S, "rate of state");
      b.rates_by_q = list(3, S, "rate by q");
      b.rates_by_states = list(4, S * S, "rate by states");
      b.rates_by_parameters = list(5, S * P, "rate by parameters");
    }
    const springnet_status status = law.evaluate(law.context, &b);
    INFO(std::string(message.text));
    REQUIRE(status == SPRINGNET_OK);
    if (S == 0) return;
    // Steps of both orders.
    for (const std::uint32_t order : {1u, 2u}) {
      springnet_law_update u{};
      u.struct_size = sizeof u;
      u.order = order;
      u.batch = &b;
      u.time_step = 0.3;
      u.start_q = numbers(0.8, 1.2);
      u.start_rate = b.rate == nullptr ? nullptr : numbers(-1.0, 1.0);
      std::vector<const double*> start_inputs;
      for (std::size_t k = 0; k < I; ++k) start_inputs.push_back(numbers(-1.0, 1.0));
      u.start_inputs = start_inputs.data();
      const std::string step = "step of order " + std::to_string(order) + ": ";
      b.force = output(step + "force");
      b.force_by_q = output(step + "force by q");
      b.force_by_rate = output(step + "force by rate");
      b.energy = has_energy ? output(step + "energy") : nullptr;
      b.margin = nullptr;
      b.energy_by_q = nullptr;
      b.energy_by_states = b.state_rates = b.rates_by_q = b.rates_by_rate = b.rates_by_states = b.rates_by_parameters =
          nullptr;
      for (auto& each : of_states) each.clear();
      b.force_by_states = list(0, S, step + "force by state");
      b.force_by_parameters = list(1, P, step + "force by parameter");
      u.next = list(2, S, step + "next");
      u.next_by_q = list(3, S, step + "next by q");
      u.next_by_rate = list(4, S, step + "next by rate");
      u.next_by_states = list(5, S * S, step + "next by states");
      u.next_by_parameters = list(6, S * P, step + "next by parameters");
      std::vector<double*> whole(layout.rows() * layout.columns(true), nullptr);
      for (std::size_t row = 0; row < layout.rows(); ++row) {
        if ((row == layout.energy() && !has_energy) || row == layout.margin()) continue;
        for (std::size_t column = 0; column < layout.columns(true); ++column)
          whole[row * layout.columns(true) + column] =
              output(step + "row " + std::to_string(row) + " column " + std::to_string(column));
      }
      b.derivatives = whole.data();
      INFO(std::string(message.text));
      REQUIRE(law.update(law.context, &u) == SPRINGNET_OK);
    }
  }

  // The first output that differs; "" if there is none. -0 is 0.
  [[nodiscard]] std::string difference_from(const Answers& other) const {
    if (names_ != other.names_) return "other outputs";
    for (std::size_t k = 0; k < names_.size(); ++k)
      for (std::size_t i = 0; i < outputs_[k]->size(); ++i) {
        const double a = (*outputs_[k])[i], b = (*other.outputs_[k])[i];
        if (!(a == b))
          return names_[k] + " of " + std::to_string(i) + ": " + std::to_string(a) + ", " + std::to_string(b) + " (" +
                 std::to_string(a - b) + ")";
      }
    return {};
  }
  [[nodiscard]] double largest(const std::string& name) const {
    double found = 0.0;
    for (std::size_t k = 0; k < names_.size(); ++k)
      if (names_[k] == name)
        for (const double x : *outputs_[k]) found = std::max(found, std::abs(x));
    return found;
  }

 private:
  std::vector<std::vector<double>> memory_;
  std::vector<std::unique_ptr<std::vector<double>>> outputs_;
  std::vector<std::string> names_;
};

bool is_available(InstructionSet set) {
  try {
    return layers::choose_instruction_set(set) == set;
  } catch (const Error&) {
    return false;
  }
}

template <class Compiled>
void compare(const LawFormula& formula) {
  const HostComponent compiled = springnet::spring_function(Compiled{});
  const auto made = component_of(formula);
  CHECK((made->description->capabilities & ~SPRINGNET_FITS_ELEMENTS) ==
        (compiled.description().capabilities & ~SPRINGNET_FITS_ELEMENTS));
  for (const InstructionSet set : {InstructionSet::generic, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_available(set)) continue;
    for (const std::size_t count : {std::size_t{1}, std::size_t{127}, std::size_t{1000}}) {
      for (const Uniform uniform : {Uniform::nothing, Uniform::all, Uniform::some}) {
        CAPTURE(count);
        CAPTURE(static_cast<int>(uniform));
        const Answers own(*made->description, layers::abi_number(set), count, uniform, 5);
        const Answers theirs(compiled.description(), layers::abi_number(set), count, uniform, 5);
        CHECK(own.difference_from(theirs) == "");
      }
    }
  }
}

}  // namespace

TEST_CASE("a formula has the bits of the compiled law: force, energy, margin and all derivatives") {
  compare<Worm>(worm());
}
TEST_CASE("steps that are done in one loop have the bits of each by itself") { compare<Joined>(joined()); }
TEST_CASE("terms and factors of 0 are computed as in the compiled law") {
  compare<Nothing>(nothing());
  LawFormula hidden;
  hidden.force = "0*(1/e)";
  const auto made = component_of(hidden);
  const double length = 1.0, rest = 1.0;
  double force = 0.0;
  springnet_law_batch b{};
  b.struct_size = sizeof b;
  b.count = 1;
  b.q = &length;
  b.reference = &rest;
  b.force = &force;
  REQUIRE(made->law().evaluate(made->law().context, &b) == SPRINGNET_OK);
  CHECK(std::isnan(force));
}
TEST_CASE("an energy alone has the bits of the compiled law") { compare<EnergyAlone>(energy_alone()); }
TEST_CASE("a formula with states has the bits of the compiled law, in steps of both orders too") {
  compare<Relaxing>(relaxing());
}
TEST_CASE("states of formulas keep their bounds with the bits of the compiled law") {
  compare<Filling>(filling());
  LawFormula unbounded = filling();
  unbounded.states[0].largest = FormulaSymbol::infinity;
  const auto bounded = component_of(filling()), free = component_of(unbounded);
  const Answers kept(*bounded->description, SPRINGNET_GENERIC, 300, Uniform::nothing, 5);
  const Answers passed(*free->description, SPRINGNET_GENERIC, 300, Uniform::nothing, 5);
  CHECK(kept.largest("step of order 2: next 0") == 1.0);
  CHECK(passed.largest("step of order 2: next 0") > 1.0);
}
TEST_CASE("a formula with smooth rates takes the steps of such laws") {
  compare<Smooth>(smooth());
  LawFormula kinked = smooth();
  kinked.smooth_rates = false;
  const auto one = component_of(smooth()), other = component_of(kinked);
  const Answers own(*one->description, SPRINGNET_GENERIC, 100, Uniform::nothing, 5);
  CHECK(own.difference_from(Answers(*other->description, SPRINGNET_GENERIC, 100, Uniform::nothing, 5)) != "");
}
TEST_CASE("a formula over several scalars has the bits of the compiled law") { compare<Sheet>(sheet()); }
