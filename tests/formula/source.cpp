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
  return fmt::format("{}", fmt::join(source(formula, kind).statements, " "));
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
  CHECK(law.uses_element);
  CHECK(law.uses_parameters);
  CHECK_FALSE(source("exp(2)").uses_element);
  CHECK_FALSE(source("exp(2)").uses_parameters);
}

TEST_CASE("what a plugin declares in another way is refused") {
  const auto refused = [](const auto& change, const char* words) {
    LawFormula law;
    law.force = "k*e";
    change(law);
    CHECK_THROWS_WITH_AS(static_cast<void>(source_of(law)), doctest::Contains(words), Error);
  };
  refused([](LawFormula& law) { law.energy = "k*e^2/2"; }, "\"Energy, rupture\"");
  refused([](LawFormula& law) { law.margin = "1 - e"; }, "\"Energy, rupture\"");
  refused([](LawFormula& law) { law.inputs = {{"k"}}; }, "\"Inputs\"");
  refused([](LawFormula& law) { law.states = {{"z", "e - z"}}; }, "\"Laws with memory\"");
  refused([](LawFormula& law) { law.curves = {{"f", {0.0, 1.0}, {0.0, 1.0}}}; }, "\"Tables\"");
  refused([](LawFormula& law) { law.scalars = {{"a", "length(0, 1)"}}; }, "\"Laws over several invariants\"");
  refused([](LawFormula& law) { law.force = ""; }, "no formula");
  refused([](LawFormula& law) { law.force = "k*(e"; }, "force: column 3: this '(' is not closed");
}
