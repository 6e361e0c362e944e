// Formulas as C++ of the SDK: what is written. That it compiles and has the bits of the formula is tested on the
// installed package, tests/package/check_plugin_new.
#include <algorithm>
#include <string>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/formula_source.hpp>

#include "formula/expression.hpp"

using namespace springnet;

namespace {

FormulaSource source(const std::string& formula, ComponentKind kind = ComponentKind::spring_function) {
  LawFormula law;
  law.kind = kind;
  law.force = formula;
  return source_of(law);
}

std::string statements(const std::string& formula, ComponentKind kind = ComponentKind::spring_function) {
  return fmt::format("{}", fmt::join(source(formula, kind).functions.at(0).statements, " "));
}

bool declares(const FormulaSource& law, const std::string& what) {
  return std::find(law.declarations.begin(), law.declarations.end(), "static constexpr " + what + ";") !=
         law.declarations.end();
}

}  // namespace

TEST_CASE("what a formula reads, in the words of the SDK") {
  CHECK(statements("k*e") == "return p[k] * e.elongation();");
  CHECK(statements("k*(length - rest)") == "return p[k] * e.elongation();");
  CHECK(statements("k*strain") == "return p[k] * e.strain();");
  CHECK(statements("k*value - reference") == "return p[k] * e.q - e.reference;");
  CHECK(statements("k*stretch") == "return p[k] * (e.q / e.reference);");
  CHECK(statements("k*rate*time") == "return p[k] * e.rate * e.time;");
  CHECK(statements("k*strain_rate") == "return p[k] * (e.rate / e.reference);");
  CHECK(statements("k*speed", ComponentKind::viscosity_function) == "return p[k] * e.q;");
  CHECK(statements("k*pi") == "return p[k] * 3.141592653589793;");
}

TEST_CASE("brackets are those of the formula: sums and products are not regrouped") {
  CHECK(statements("a + (b + c)") == "return p[a] + (p[b] + p[c]);");
  CHECK(statements("a + b + c") == "return p[a] + p[b] + p[c];");
  CHECK(statements("a - (b - c)") == "return p[a] - (p[b] - p[c]);");
  CHECK(statements("a/(b*c)") == "return p[a] / (p[b] * p[c]);");
  CHECK(statements("(a + b)*c") == "return (p[a] + p[b]) * p[c];");
  CHECK(statements("-(-(a + b))") == "return -(-(p[a] + p[b]));");
  CHECK(statements("a - -b") == "return p[a] - -p[b];");
  CHECK(statements("-2*a") == "return -2.0 * p[a];");
}

TEST_CASE("whole powers are products, others pow; parts that occur twice are computed once") {
  CHECK(statements("e^2") == "return e.elongation() * e.elongation();");
  CHECK(statements("(a*e)^2") == "const auto x1 = p[a] * e.elongation(); return x1 * x1;");
  CHECK(statements("a^5") == "const auto x1 = p[a] * p[a]; return p[a] * (x1 * x1);");
  CHECK(statements("a^x1") == "return pow(p[a], p[x1]);");
  CHECK(statements("(x1*e)^2") == "const auto x2 = p[x1] * e.elongation(); return x2 * x2;");
  CHECK(statements("stretch^0.5") == "return pow(e.q / e.reference, 0.5);");
}

TEST_CASE("conditions, and choices that the SDK has a name for") {
  CHECK(statements("if(a < b, a, c)") == "return p[a] < p[b] ? p[a] : p[c];");
  CHECK(statements("if(e > 0 and (a < b or not a <= 2), a, if(e < 1, b, 0))") ==
        "return 0.0 < e.elongation() && (p[a] < p[b] || !(p[a] <= 2.0)) ? p[a] : (e.elongation() < 1.0 ? p[b] : 0.0);");
  CHECK(statements("min(a, e)") == "return min(p[a], e.elongation());");
  CHECK(statements("if(e < a, e, nan)") ==
        "return e.elongation() < p[a] ? e.elongation() : std::numeric_limits<double>::quiet_NaN();");
  CHECK(statements("max(a, e)") == "return max(p[a], e.elongation());");
  CHECK(statements("clamp(e, a, 2)") == "return clamp(e.elongation(), p[a], 2.0);");
  // The SDK has no clamp of a double to dual numbers.
  CHECK(statements("clamp(1, a, b)") == "return 1.0 < p[a] ? p[a] : min(1.0, p[b]);");
}

TEST_CASE("every function of the language is one of the SDK") {
  for (const std::string& name : formula::function_names()) {
    if (name == "if" || name == "rest" || name == "rate" || name == "clamp" || name == "min" || name == "max") continue;
    CAPTURE(name);
    const bool of_two = name == "pow" || name == "hypot" || name == "atan2";
    CHECK(statements(name + (of_two ? "(e, a)" : "(e)")) ==
          fmt::format("return {}(e.elongation(){});", name, of_two ? ", p[a]" : ""));
  }
}

TEST_CASE("what a law declares") {
  CHECK(source("k*e").declarations == std::vector<std::string>{"static constexpr bool fits_elements = true;"});
  CHECK(source("k*(length - rest)").declarations.empty());
  CHECK(declares(source("k*strain"), "bool divides_by_reference = true"));
  CHECK(declares(source("k*rate"), "bool reads_rate = true"));
  CHECK_FALSE(declares(source("k*rate", ComponentKind::viscosity_function), "bool reads_rate = true"));
  CHECK(declares(source("k*e*time"), "bool reads_time = true"));
  CHECK(declares(source("k*e + tension"), "bool not_zero_at_rest = true"));
  CHECK(declares(source("k*(length - natural)"), "bool not_zero_at_rest = true"));
  CHECK_FALSE(declares(source("k*(exp(strain) - 1) + c*rate"), "bool not_zero_at_rest = true"));
  const FormulaSource relative = source("k*speed", ComponentKind::viscosity_function);
  CHECK(declares(relative, "std::uint32_t invariant = SPRINGNET_RELATIVE_SPEED"));
  CHECK_FALSE(declares(relative, "bool fits_elements = true"));
}

TEST_CASE("parameters that C++ or the SDK has another meaning for get an underscore in C++ alone") {
  const FormulaSource law = source("class*e + invariant*p + class_*k");
  CHECK(law.parameters == std::vector<std::string>{"class", "invariant", "p", "class_", "k"});
  CHECK(law.enumerators == std::vector<std::string>{"class__", "invariant_", "p_", "class_", "k"});
  CHECK(law.functions[0].uses_element);
  CHECK(law.functions[0].uses_parameters);
  CHECK_FALSE(source("exp(2)").functions[0].uses_element);
  CHECK_FALSE(source("exp(2)").functions[0].uses_parameters);
}

TEST_CASE("energies, margins, states, inputs and promises in the words of the SDK") {
  LawFormula law;
  law.force = "k*(e - z)*drive";
  law.energy = "k/2*(e - z)^2";
  law.margin = "2 - stretch";
  law.smallest_stretch = 0.5;
  law.pulls_only = law.monotone = law.not_zero_at_rest = law.adds_power = law.smooth_rates = true;
  law.parameters = {{"k", "", FormulaSymbol::none, "a \"k\"", 0.0, 10.0, true, 2.0}};
  law.inputs = {{"drive", "", 0.5, "", 0.0, 1.0}};
  law.states = {{"z", "e - z", 0.25, "m", "of the dashpot", -1.0}, {"y", "1"}};
  const FormulaSource made = source_of(law);
  REQUIRE(made.functions.size() == 4);
  CHECK(made.functions[0].statements ==
        std::vector<std::string>{"return p[k] * (e.elongation() - e.state(z)) * e.input(drive);"});
  CHECK(made.functions[1].name == "state_rates");
  CHECK(
      made.functions[1].statements ==
      std::vector<std::string>{"return std::array<decltype(e.reference + 0.0), 2>{e.elongation() - e.state(z), 1.0};"});
  CHECK(made.functions[2].name == "energy");
  CHECK(made.functions[3].statements == std::vector<std::string>{"return 2.0 - e.q / e.reference;"});
  CHECK(made.enums == std::vector<std::vector<std::string>>{{"k"}, {"z", "y"}, {"drive"}});
  REQUIRE(made.lists.size() == 3);
  CHECK(made.lists[0].entries ==
        std::vector<std::string>{R"(number("k", "1", "a \"k\"").above(0).at_most(10).learnable(2))"});
  CHECK(made.lists[1].entries[0] == R"(number("z", "m", "of the dashpot").preset(0.25).at_least(-1).learnable(0.25))");
  CHECK(made.lists[1].entries[1] == R"(number("y", "1", "").preset(0))");
  CHECK(made.lists[2].entries[0] == R"(number("drive", "1", "").preset(0.5).at_least(0).at_most(1))");
  for (const char* each : {"bool acts_in_compression = false", "bool monotone = true", "bool not_zero_at_rest = true",
                           "bool adds_power = true", "bool smooth_rates = true", "double smallest_stretch = 0.5"}) {
    CAPTURE(each);
    CHECK(declares(made, each));
  }
  CHECK(made.declarations[0] == "using has = Has<Energy, Margin>;");
}

TEST_CASE("curves are tables of the plugin, scalars its invariants") {
  LawFormula law;
  law.force = "f(e) + g(2) + f_x";
  law.curves = {{"f", {0.0, 1.0}, {0.0, 1.0}}, {"g", {0.0, 1.0}, {0.0, 1.0}}};
  const FormulaSource curved = source_of(law);
  CHECK(curved.uses_tables);
  CHECK(curved.table_keys == std::vector<std::string>{"f_x_", "f_y", "g_x", "g_y"});
  CHECK(curved.functions[0].statements[0] == "return e.table[0](e.elongation()) + e.table[1](2.0) + p[f_x];");
  CHECK(curved.lists.back().entries[3] == R"(table("g_y", "1", "").as_long_as(2))");
  law.force = "f(e)";
  law.curves.pop_back();
  CHECK(source_of(law).prepare ==
        "static MonotoneCubic prepare(const TableSource& source) { return {source[0], source[1], Beyond::linear}; }");
  CHECK(source_of(law).functions[0].statements[0] == "return e.table(e.elongation());");

  LawFormula several;
  several.shape = Invariant::tetrahedron;
  several.scalars = {{"a", "length(0, 1)"}, {"at_rest", "volume(0, 1, 2, 3)"}, {"turn", "angle(0, 1, 2)"}};
  several.forces = {"k*(a - rest(a))*rest(at_rest) + direction_2*rate(a)", "0", "turn"};
  const FormulaSource made = source_of(several);
  CHECK(declares(made, "Shape shape = Shape::tetrahedron"));
  CHECK(declares(made, "bool reads_direction = true"));
  CHECK(declares(made, "bool reads_rate = true"));
  CHECK(made.lists.back().entries ==
        std::vector<std::string>{"length_of(0, 1)", "at_rest(volume_of(0, 1, 2, 3))", "angle_of(0, 1, 2)"});
  CHECK(made.enums.back() == std::vector<std::string>{"a", "at_rest_", "turn"});
  const std::string text = fmt::format("{}", fmt::join(made.functions[0].statements, " "));
  CAPTURE(text);
  CHECK(text.find("e.reference[at_rest_]") != std::string::npos);
  CHECK(text.find("e.direction[2] * e.rate[a]") != std::string::npos);
  CHECK(text.find("0.0, e.q[turn]};") != std::string::npos);
  CHECK(declares(source("k*(angle - 1)"), "std::uint32_t invariant = SPRINGNET_ANGLE"));
  CHECK(declares(source("k*area"), "std::uint32_t invariant = SPRINGNET_AREA"));
  CHECK(declares(source("k*volume"), "std::uint32_t invariant = SPRINGNET_VOLUME"));
}

TEST_CASE("what no law can have, and names that plugins cannot have, are refused") {
  const auto refused = [](const auto& change, const char* words) {
    LawFormula law;
    law.force = "k*e";
    change(law);
    CHECK_THROWS_WITH_AS(static_cast<void>(source_of(law)), doctest::Contains(words), Error);
  };
  refused([](LawFormula& law) { law.force = ""; }, "no formula");
  refused([](LawFormula& law) { law.force = "k*(e"; }, "column 3: this '(' is not closed");
  refused([](LawFormula& law) { law.force = "f(e)"; }, "there is no function 'f'");
  refused([](LawFormula& law) { law.states = {{"_z", "e"}}; }, "state '_z': names in plugins begin");
  refused([](LawFormula& law) { law.inputs = {{"name"}}; }, "input 'name': scenes have this key");
  refused(
      [](LawFormula& law) {
        law.parameters = {{"k"}}, law.parameters[0].smallest = FormulaSymbol::infinity, law.parameters[0].largest = 0.0;
      },
      "no value");
}
