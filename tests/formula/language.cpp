// The language of formulas: values, priorities, names, and what mistakes are told.
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/formula.hpp>
#include <springnet/simulation.hpp>

#include "facts.hpp"
#include "law_call.hpp"

using namespace springnet;

namespace {

// Springs of the given lengths and rest length 1 m, 5 s after the start.
test::LawAnswer answer_of(const Component& component, const test::Array& q, const test::Array& rate,
                          const std::vector<test::Array>& parameters) {
  test::LawInput input;
  input.count = static_cast<std::uint32_t>(q.size());
  input.q = q;
  input.rate = rate;
  input.reference = {1.0};
  input.parameters = parameters;
  input.time = 5.0;
  return test::evaluate(*component.description, input);
}

// The force of a spring of length 1.3 m and rest length 1 m, with a = 2 and b = -3, whose length grows by 0.7 m/s.
double value_of(const std::string& text, std::vector<FormulaCurve> curves = {}) {
  LawFormula law;
  law.force = text + " + 0*(a + b + rate)";
  law.parameters = {{"a"}, {"b"}};
  law.curves = std::move(curves);
  const test::LawAnswer answer = answer_of(*component_of(law), {1.3}, {0.7}, {{2.0}, {-3.0}});
  REQUIRE(answer.status == SPRINGNET_OK);
  return answer.force[0];
}

std::string refusal(const LawFormula& law) {
  try {
    static_cast<void>(component_of(law));
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return {};
}
std::string refusal(const std::string& text) {
  LawFormula law;
  law.force = text;
  law.parameters = {{"stiffness"}, {"limit"}};
  return refusal(law);
}

void refused(const std::string& text, const std::string& facts) {
  const std::string message = refusal(text);
  INFO(text);
  INFO(message);
  CHECK(testing::has_facts(message, facts));
}

}  // namespace

TEST_CASE("arithmetic has the usual priorities") {
  CHECK(value_of("1 + 2*3") == 7.0);
  CHECK(value_of("(1 + 2)*3") == 9.0);
  CHECK(value_of("8/4/2") == 1.0);
  CHECK(value_of("8 - 4 - 2") == 2.0);
  CHECK(value_of("-2^2") == -4.0);
  CHECK(value_of("2^3^2") == 512.0);
  CHECK(value_of("2^-1") == 0.5);
  CHECK(value_of("-a*b") == 6.0);
  CHECK(value_of("2 - -3") == 5.0);
  CHECK(value_of("1.5e1 + .5") == 15.5);
  CHECK(value_of("a^2*b") == -12.0);
  CHECK(value_of("b^3") == -27.0);
  CHECK(value_of("a^13") == 8192.0);
  CHECK(value_of("a^0.5") == doctest::Approx(std::sqrt(2.0)).epsilon(1e-15));
}

TEST_CASE("names of what a law reads") {
  CHECK(value_of("e") == doctest::Approx(0.3).epsilon(1e-15));
  CHECK(value_of("strain") == doctest::Approx(0.3).epsilon(1e-15));
  CHECK(value_of("stretch") == 1.3);
  CHECK(value_of("length") == 1.3);
  CHECK(value_of("value") == 1.3);
  CHECK(value_of("rest") == 1.0);
  CHECK(value_of("reference") == 1.0);
  CHECK(value_of("rate") == 0.7);
  CHECK(value_of("strain_rate") == 0.7);
  CHECK(value_of("time") == 5.0);
  CHECK(value_of("pi") == 3.14159265358979323846);
}

TEST_CASE("functions, conditions, definitions, comments, curves") {
  CHECK(value_of("if(a > 1, 10, 20)") == 10.0);
  CHECK(value_of("if(a <= 1 or not b < -5 and a >= 2, 10, 20)") == 10.0);
  CHECK(value_of("if(not (a > 1 and b > 1), 10, 20)") == 10.0);
  CHECK(value_of("min(a, b) + max(a, b) + clamp(7, b, a)") == 1.0);
  CHECK(value_of("abs(b) + floor(-0.5) + ceil(0.5)") == 3.0);
  CHECK(value_of("hypot(3, 4) + atan2(0, -1) - pi") == 5.0);
  CHECK(value_of("pow(a, 3) + sqrt(9) + cbrt(27)") == doctest::Approx(14.0).epsilon(1e-15));
  CHECK(value_of("x = a + 1; y = x*x; # twice\n y - x") == 6.0);
  const double one = value_of("sin(1)^2 + cos(1)^2");
  CHECK(one == doctest::Approx(1.0).epsilon(1e-15));
  CHECK(value_of("exp(log(a)) + expm1(0) + log1p(0) + log10(100) + tan(0) + asin(0) + acos(1) + atan(0) + sinh(0) + "
                 "cosh(0) + tanh(0) + erf(0)") == doctest::Approx(5.0).epsilon(1e-15));
  CHECK(value_of("curve(0.5) + curve(3)", {{"curve", {0.0, 1.0, 2.0}, {0.0, 2.0, 4.0}}}) ==
        doctest::Approx(7.0).epsilon(1e-14));
}

TEST_CASE("derivatives where a branch or a slope ends are those of the SDK's numbers") {
  // Right at the kink of max(e, 0), of a power with the exponent 0, of sqrt at 0.
  LawFormula law;
  law.force = "max(e, 0) + sqrt(stiffness*0) + e^limit";
  law.parameters = {{"stiffness"}, {"limit"}};
  const test::LawAnswer answer = answer_of(*component_of(law), {1.0, 0.7, 1.3}, {0.0, 0.0, 0.0}, {{2.0}, {0.0}});
  REQUIRE(answer.status == SPRINGNET_OK);
  CHECK(answer.force[0] == 1.0);
  CHECK(answer.by_q[0] == 1.0);  // max takes its first argument where both are equal
  CHECK(answer.by_q[1] == 0.0);
  CHECK(answer.by_q[2] == 1.0);
}

TEST_CASE("mistakes are told with their column and a caret") {
  refused("stiffness * (e", "force: column 13 | '(' is not closed | stiffness * (e | ^");
  refused("stiffness * e)", "column 14 | closes nothing");
  refused("stifness * e", "column 1 | 'stifness' is not known | did you mean 'stiffness'");
  refused("stiffness * e*limit + sine(e)", "column 23 | no function 'sine' | sin");
  refused("stiffness e", "column 11 | an operator is missing before 'e'");
  refused("2e + stiffness", "column 2 | '*' is missing");
  refused("stiffness ** 2", "column 11 | '^'");
  refused("stiffness *", "column 12 | ends here");
  refused("* 3", "column 1 | '*' stands where a value is missing");
  refused("exp", "column 1 | 'exp' is a function | exp(");
  refused("exp(e, 2)", "column 1 | exp takes 1 argument, not 2");
  refused("if(e, 1, 2)", "column 4 | a number, not a condition");
  refused("e < 1", "a condition, not a number");
  refused("1 + (e < 2)", "a condition, not a number");
  refused("if(e == 1, 1, 2)", "'==' has no meaning");
  refused("e ? 1 : 2", "'?' has no meaning | if(");
  refused("e && 1", "'and'");
  refused("x = 3;", "column 7 | ends with a definition");
  refused("x = 3; x = 4; x", "'x' is defined twice");
  refused("sin = 3; sin", "'sin' is a word of the language");
  for (const char* word : {"e", "strain", "length", "value", "angle", "speed", "strain_rate", "time", "pi", "nan"})
    refused(std::string("x = stiffness; ") + word + " = 2*x; stiffness*" + word,
            std::string("force: column 16 | '") + word + "' is a word of the language");
  refused("x = stiffnes*e; stiffness*e", "column 1 | 'x' is not used | ^");
  refused("x = 2; y = 3*x; stiffness*e", "column 8 | 'y' is not used");
  refused("", "no formula");
  refused("  ", "is empty");
  refused("stiffness*e + π", "column 15 | 'π' has no meaning");
  refused("line\n+ unknown", "line 1, column 1 | 'line' is not known");
  refused("stiffness\n + unknown", "line 2, column 4 | 'unknown' is not known");
  refused("1e999", "too large");
  refused("rest(e)", "column 1 | several scalars");
  refused("angle*area", "column 7 | 'area' does not go with 'angle'");
  refused("speed", "viscosities");
  refused("e.b", "column 2 | '.' has no meaning");
}

TEST_CASE("a definition takes no name of the law") {
  LawFormula law;
  law.force = "stiffness = 2; stiffness*(e - z) + drive";
  law.energy = "stiffness*e^2";
  law.parameters = {{"stiffness"}};
  law.inputs = {{"drive"}};
  law.states = {{"z", "e - z"}};
  CHECK(testing::has_facts(refusal(law), "force: column 1 | 'stiffness' is a parameter of the law"));
  law.force = "stiffness*(e - z) + drive";
  law.energy = "z = 3; stiffness*z^2";
  CHECK(testing::has_facts(refusal(law), "energy: column 1 | 'z' is a state of the law"));
  law.energy = "drive = 3; stiffness*drive^2";
  CHECK(testing::has_facts(refusal(law), "energy: column 1 | 'drive' is an input of the law"));
  // Laws over several scalars have names of their own.
  LawFormula sheet;
  sheet.scalars = {{"a", "length(0, 1)"}};
  sheet.energy = "e = a - rest(a); e^2";
  CHECK(refusal(sheet) == "");
  sheet.energy = "a = 2; a^2";
  CHECK(testing::has_facts(refusal(sheet), "energy: column 1 | 'a' is a scalar of the law"));
}

TEST_CASE("scalars tell their elements by the nodes that they read") {
  CHECK(shape_of({{"a", "length(0, 1)"}, {"b", "length(0, 2)"}}) == Invariant::triangle);
  CHECK(shape_of({{"a", "angle(0, 1, 2)"}}) == Invariant::chain);
  CHECK(shape_of({{"a", "angle(0, 1, 2)"}, {"b", "length(0, 1)"}, {"c", "length(2, 1)"}}) == Invariant::chain);
  CHECK(shape_of({{"a", "angle(0, 1, 2)"}, {"b", "length(0, 2)"}}) == Invariant::triangle);
  CHECK(shape_of({{"a", "angle(0, 1, 2)"}, {"b", "area(0, 1, 2)"}}) == Invariant::triangle);
  CHECK(shape_of({{"a", "angle(1, 0, 2)"}}) == Invariant::triangle);
  CHECK(shape_of({{"a", "angle(0, 1, 3)"}}) == Invariant::tetrahedron);
  CHECK(shape_of({{"a", "length(0, 1)"}, {"b", "dihedral(0, 1, 2, 3)"}}) == Invariant::hinge);
  CHECK(shape_of({{"a3", "length(0, 1)"}, {"b", "length( 1 , 2.0 )"}}) == Invariant::triangle);
  CHECK_THROWS_AS(static_cast<void>(shape_of({{"a", "length(0, 4)"}})), Error);
}

TEST_CASE("what a law declares is checked") {
  LawFormula law;
  law.force = "stiffness*e";
  CHECK(testing::has_facts(refusal(law), "'stiffness' is not known"));
  law.parameters = {{"stiffness"}, {"limit"}};
  CHECK(testing::has_facts(refusal(law), "parameter 'limit' | no formula of the law reads it"));
  law.parameters = {{"stiffness"}};
  CHECK(refusal(law) == "");
  CHECK(parameters_of(law) == std::vector<std::string>{"stiffness"});
  law.inputs = {{"stiffness"}};
  CHECK(testing::has_facts(refusal(law), "input 'stiffness' | given twice"));
  law.inputs = {{"Drive"}};
  CHECK(testing::has_facts(refusal(law), "'Drive' | lower case"));
  law.inputs = {{"time"}};
  CHECK(testing::has_facts(refusal(law), "input 'time' | have a meaning"));
  law.inputs.clear();
  law.energy = "0.5*stiffness*energie^2";
  CHECK(testing::has_facts(refusal(law), "energy: column 15 | 'energie' is not known"));
  law.energy = "rate^2";
  law.force.clear();
  law.parameters.clear();
  CHECK(testing::has_facts(refusal(law), "energy | does not depend on rates"));
  law.energy = "curve(e)";
  law.curves = {{"curve", {0.0, 0.0}, {1.0, 2.0}}};
  CHECK(testing::has_facts(refusal(law), "curve 'curve'"));
}

TEST_CASE("a component has what its formula declares, and gives the formula back") {
  LawFormula law;
  law.force = "stiffness*(e + 0*drive*flow)";
  law.summary = "pulls";
  law.smallest_stretch = 0.5;
  law.largest_stretch = 2.0;
  law.pulls_only = law.monotone = law.not_zero_at_rest = law.adds_power = law.smooth_rates = true;
  law.parameters = {{"stiffness", "N/m", FormulaSymbol::none, "of all", 0.0, 100.0, true, 7.0, false}, {"tau", "s"}};
  law.inputs = {{"drive", "1", 0.5, "of the muscle", 0.0, 1.0}};
  law.states = {{"flow", "(e - flow)/tau", 0.25, "m", "of the dashpot", -1.0, 3.0}};
  const auto component = component_of(law);
  const springnet_component& made = *component->description;
  constexpr std::uint64_t promises =
      SPRINGNET_ACTS_IN_COMPRESSION | SPRINGNET_MONOTONE | SPRINGNET_NOT_ZERO_AT_REST | SPRINGNET_ADDS_POWER;
  CHECK((made.capabilities & promises) == (promises & ~SPRINGNET_ACTS_IN_COMPRESSION));
  CHECK(std::string(made.summary) == "pulls");
  CHECK(component->law().smallest_stretch == 0.5);
  CHECK(component->law().largest_stretch == 2.0);
  const springnet_parameter& stiffness = *made.parameters[0];
  CHECK(stiffness.flags == (SPRINGNET_REQUIRED | SPRINGNET_EXCLUDES_SMALLEST));
  CHECK(stiffness.smallest == 0.0);
  CHECK(stiffness.largest == 100.0);
  CHECK(stiffness.scale == 7.0);
  CHECK(std::string(stiffness.summary) == "of all");
  CHECK(component->law().inputs[0]->largest == 1.0);
  CHECK(component->law().inputs[0]->default_value == 0.5);
  CHECK(component->law().states[0]->smallest == -1.0);
  CHECK(component->law().states[0]->scale == 0.25);
  CHECK(std::string(component->law().states[0]->summary) == "of the dashpot");
  REQUIRE(formula_of(*component) != nullptr);
  CHECK(formula_of(*component)->force == law.force);
  const PluginHost host = PluginHost::with_default_search();
  for (const auto& other : host.components()) CHECK(formula_of(*other) == nullptr);
  // What is not said is as with a law that says nothing.
  LawFormula plain;
  plain.force = "k*e";
  plain.parameters = {{"k"}};
  const auto bare = component_of(plain);
  CHECK((bare->description->capabilities & promises) == SPRINGNET_ACTS_IN_COMPRESSION);
  CHECK(bare->description->parameters[0]->flags == (SPRINGNET_REQUIRED | SPRINGNET_LEARNABLE));
}

TEST_CASE("declarations that contradict each other are refused") {
  const auto refused = [](const auto& change, const char* words) {
    LawFormula law;
    law.force = "k*(e - z)";
    law.parameters = {{"k"}};
    law.states = {{"z", "e - z"}};
    change(law);
    CHECK_THROWS_WITH_AS(static_cast<void>(component_of(law)), doctest::Contains(words), Error);
  };
  constexpr double nan = FormulaSymbol::none;
  refused([](LawFormula& law) { law.smallest_stretch = 3.0, law.largest_stretch = 2.0; }, "from a stretch of 3 to 2");
  refused([](LawFormula& law) { law.largest_stretch = nan; }, "from a stretch of 0 to nan");
  refused([](LawFormula& law) { law.parameters[0].smallest = 2.0, law.parameters[0].largest = 1.0; }, "no value");
  refused([](LawFormula& law) { law.parameters[0].smallest = nan; }, "no value");
  refused([](LawFormula& law) { law.parameters[0].scale = 0.0; }, "scale must be");
  refused([](LawFormula& law) { law.parameters[0].scale = FormulaSymbol::infinity; }, "scale must be");
  refused([](LawFormula& law) { law.parameters[0].preset = 2.0, law.parameters[0].largest = 1.0; }, "its default");
  refused([](LawFormula& law) { law.parameters[0].summary.assign(9000, 'a'); }, "more than 8192 bytes");
  refused([](LawFormula& law) { law.states[0].largest = -1.0; }, "its default");
  refused([](LawFormula& law) { law.states[0].scale = -1.0; }, "scale must be");
  refused([](LawFormula& law) { law.states.clear(), law.force = "k*e", law.smooth_rates = true; }, "has none");
}

TEST_CASE("formulas are bounded: length, depth, operations, derivatives") {
  CHECK(testing::has_facts(refusal(std::string(20'000, ' ') + "e"), "20001 bytes | at most 10000"));
  CHECK(testing::has_facts(refusal(std::string(500, '(') + "e" + std::string(500, ')')), "more than 100 brackets"));
  CHECK(testing::has_facts(refusal(std::string(500, '-') + "e"), "more than 100 brackets and signs"));
  std::string sum = "e";
  for (int i = 0; i < 1500; ++i) sum += "+e";
  CHECK(testing::has_facts(refusal(sum), "more than 2000 operations"));
  // Doubled again and again by definitions: a few words that stand for 2^60 terms are one chain of operations.
  std::string doubled = "x0 = e;";
  for (int i = 0; i < 60; ++i)
    doubled += "x" + std::to_string(i + 1) + " = x" + std::to_string(i) + "*x" + std::to_string(i) + " + sin(x" +
               std::to_string(i) + ");";
  doubled += "stiffness*limit*x60";
  CHECK(refusal(doubled) == "");
}

TEST_CASE("texts by chance are taken or refused, and what is taken computes") {
  const char* const words[] = {"e",   "stiffness", "limit", "rate", "time", "1",     "2.5",    "1e9",  "(",
                               ")",   "+",         "-",     "*",    "/",    "^",     ",",      ";",    "=",
                               "<",   ">=",        "if(",   "min(", "exp(", "sqrt(", "pow(",   "not ", "and ",
                               "or ", "pi",        "x",     "x = ", "#",    "\n",    "atan2(", "e)",   "0",
                               " ",   "strain",    "rest(", "\xff", "π"};
  std::mt19937 random(7);
  int taken = 0;
  for (int i = 0; i < 30'000; ++i) {
    LawFormula law;
    const int length = std::uniform_int_distribution<int>(1, 9)(random);
    for (int k = 0; k < length; ++k)
      law.force += words[std::uniform_int_distribution<std::size_t>(0, std::size(words) - 1)(random)];
    law.force += i % 2 == 0 ? "" : "*e + 0*(stiffness + limit)";
    if (i % 2 != 0) law.parameters = {{"stiffness"}, {"limit"}};
    std::shared_ptr<const Component> component;
    try {
      component = component_of(law);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::input) FAIL(law.force);
      continue;
    }
    ++taken;
    const test::LawAnswer answer = answer_of(*component, {1.0, 1.1, 0.0}, {0.0, -1.0, 2.0}, {{1.0}, {1.0}});
    if (answer.status != SPRINGNET_OK) FAIL(law.force);
  }
  CHECK(taken > 300);
}

TEST_CASE("a simulation with formulas: a FENE chain against its compiled brother") {
  LawFormula fene;
  fene.force = "stiffness*e/(1 - (e/limit)^2)";
  fene.energy = "-0.5*stiffness*limit^2*log1p(-(e/limit)^2)";
  fene.parameters = {{"stiffness", "N/m"}, {"limit", "m"}};
  LawFormula dashpot;
  dashpot.kind = ComponentKind::viscosity_function;
  dashpot.force = "damping*rate";
  dashpot.parameters = {{"damping", "N s/m"}};
  Network net;
  const MaterialIndex material =
      net.add_material({law_of(fene, {{"stiffness", 30.0}, {"limit", 0.5}}), law_of(dashpot, {{"damping", 0.2}})});
  for (int k = 0; k < 5; ++k) {
    Node node;
    node.position = {0.3 * k, 0.05 * k * k, 0.0};
    net.add_node(node);
    if (k > 0) net.add_spring(static_cast<NodeIndex>(k - 1), static_cast<NodeIndex>(k), material, 0.25);
  }
  net.fix(0);
  net.set_gravity({0, 0, -9.81});
  const auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  const auto at_end = [&](const LawUse& integrator, double time_step) {
    SimulationOptions options;
    options.time_step = time_step;
    options.integrator = integrator;
    Simulation simulation(net, host, options);
    const double start = simulation.kinetic_energy() + simulation.potential_energy();
    CHECK(std::isfinite(start));
    simulation.advance_to(0.5);
    return Eigen::Matrix3Xd(simulation.positions());
  };
  const Eigen::Matrix3Xd reference = at_end({"cvode", {{"relative_tolerance", 1e-10}}}, 0.05);
  const auto error = [&](double h) {
    return (at_end({"recurrent", {{"theta", 0.5}, {"update", 4.0}, {"force_tolerance", 1e-10}}}, h) - reference).norm();
  };
  const double coarse = error(2e-3), fine = error(1e-3);
  CHECK(fine < 3e-3);
  CHECK(coarse / fine == doctest::Approx(4.0).epsilon(0.1));  // second order, which needs the tangent
}
