// Values, widths and what explains them, against forms worked out by hand.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/fuzzy.hpp>

using namespace springnet;
using namespace springnet::fuzzy;

namespace {

// Midpoint sums over cells of size h are off by h^2 / 24 of an integrand's slopes at its ends and kinks: with a range
// of 10 and slopes below 10 by 1e-4.
constexpr double cells_tolerance = 1e-4;

RuleBase base_of(const std::string& terms_of_y, const std::string& rules) {
  return parse_rules(R"(FUNCTION_BLOCK
VAR_INPUT  x : REAL;  z : REAL;  END_VAR
VAR_OUTPUT y : REAL;  END_VAR
FUZZIFY x
  TERM low := (0, 1) (1, 0);
  TERM high := (0, 0) (1, 1);
END_FUZZIFY
FUZZIFY z
  TERM low := (0, 1) (1, 0);
END_FUZZIFY
DEFUZZIFY y
)" + terms_of_y + "END_DEFUZZIFY\nRULEBLOCK\n" +
                         rules + "END_RULEBLOCK\nEND_FUNCTION_BLOCK\n",
                     "a.fcl");
}

}  // namespace

TEST_CASE("one triangle has its centre and its standard deviation") {
  const RuleBase base = base_of("RANGE := (0 .. 10); TERM a := Triangle 1 2 6; METHOD : COG;",
                                "ACT : PROD; RULE 1 : IF x IS low THEN y IS a;");
  // Whatever the activation, which multiplies the whole set.
  for (const double x : {0.0, 0.3, 0.9}) {
    const Guess guess = evaluate(base, {x, {}}).outputs[0].value();
    CHECK(guess.value == doctest::Approx(3.0).epsilon(cells_tolerance));  // (a + b + c) / 3
    // (a^2 + b^2 + c^2 - a b - a c - b c) / 18
    CHECK(guess.width == doctest::Approx(std::sqrt(21.0 / 18.0)).epsilon(cells_tolerance));
    CHECK(guess.activations[0] == doctest::Approx(1.0 - x));
  }
}

TEST_CASE("a Gaussian has its mean and its standard deviation") {
  const RuleBase base = base_of("RANGE := (-10 .. 12); TERM a := Gaussian 1 0.8; METHOD : COG;",
                                "ACT : PROD; RULE 1 : IF x IS low THEN y IS a;");
  const Guess guess = evaluate(base, {0.5, {}}).outputs[0].value();
  CHECK(guess.value == doctest::Approx(1.0).epsilon(1e-12));  // sums of Gaussians converge at once
  CHECK(guess.width == doctest::Approx(0.8).epsilon(1e-12));
}

TEST_CASE("two rules that overlap: clipped sets, put together by the maximum") {
  const RuleBase base =
      base_of("RANGE := (0 .. 8); TERM a := Triangle 0 2 4; TERM b := Triangle 2 4 6; METHOD : COG; ACCU : MAX;",
              "ACT : MIN; RULE 1 : IF x IS low THEN y IS a; RULE 2 : IF x IS high THEN y IS b;");
  // x = 1/4: a clipped at 3/4, b at 1/4. The set rises from 0 to 3/4 at 1.5, stays to 2.5, falls to 1/4 at 3.5, stays
  // to 5.5, falls to 0 at 6. Areas: 0.5625, 0.75, 0.5, 0.5, 0.0625. Moments: their centres 1, 2, 2.91667, 4.5, 5.66667.
  const Guess guess = evaluate(base, {0.25, {}}).outputs[0].value();
  const double area = 0.5625 + 0.75 + 0.5 + 0.5 + 0.0625;
  const double moment = 0.5625 * 1.0 + 0.75 * 2.0 + 0.5 * (2.5 + 5.0 / 12.0) + 0.5 * 4.5 + 0.0625 * (5.5 + 1.0 / 6.0);
  CHECK(guess.value == doctest::Approx(moment / area).epsilon(cells_tolerance));
  CHECK(guess.activations == std::vector<double>{0.75, 0.25});
}

TEST_CASE("COA halves the area, LM, RM and MM look for maxima") {
  const auto value = [](const std::string& method) {
    const RuleBase base = base_of("RANGE := (0 .. 10); TERM a := Trapezoid 0 4 6 10; METHOD : " + method + ";",
                                  "ACT : MIN; RULE 1 : IF x IS low THEN y IS a;");
    return evaluate(base, {0.5, {}}).outputs[0].value().value;
  };
  CHECK(value("COA") == doctest::Approx(5.0).epsilon(1e-12));
  // Clipped at a half: from 2 to 8, whose outer cells have their midpoints at 2.005 and 7.995.
  CHECK(value("LM") == doctest::Approx(2.005).epsilon(1e-12));
  CHECK(value("RM") == doctest::Approx(7.995).epsilon(1e-12));
  CHECK(value("MM") == doctest::Approx(5.0).epsilon(1e-12));
  const RuleBase triangle =
      base_of("RANGE := (0 .. 1); TERM a := (0, 1) (1, 0); METHOD : COA;", "RULE 1 : IF x IS any THEN y IS a;");
  CHECK(evaluate(triangle, {{}, {}}).outputs[0].value().value ==
        doctest::Approx(1.0 - std::sqrt(0.5)).epsilon(1e-6));  // 1 - u^2 / 2 = half of 1/2
}

TEST_CASE("Takagi-Sugeno: means and sums of numbers, weighted by activations") {
  const std::string rules = "RULE 1 : IF x IS low THEN y IS a; RULE 2 : IF x IS high THEN y IS b WITH 0.5;";
  const Inputs at{0.25, 3.0};
  // Weights 3/4 and 1/8; a = 2, b = 4 * 0.25 + 2 * 3 - 1 = 6.
  const std::string terms = "TERM a := 2; TERM b := Linear 4 2 -1; METHOD : ";
  const Guess mean = evaluate(base_of(terms + "COGS;", rules), at).outputs[0].value();
  CHECK(mean.value == doctest::Approx((0.75 * 2.0 + 0.125 * 6.0) / 0.875).epsilon(1e-14));
  CHECK(mean.width == doctest::Approx(4.0 * std::sqrt(0.75 * 0.125) / 0.875).epsilon(1e-14));
  const Guess sum = evaluate(base_of(terms + "COGSS;", rules), at).outputs[0].value();
  CHECK(sum.value == doctest::Approx(0.75 * 2.0 + 0.125 * 6.0).epsilon(1e-14));
  CHECK(sum.width == doctest::Approx(0.875 * mean.width).epsilon(1e-14));
}

TEST_CASE("what is not known applies no rule") {
  const RuleBase base =
      base_of("RANGE := (0 .. 4); TERM a := Triangle 0 1 2; TERM b := Triangle 2 3 4; METHOD : COG; DEFAULT := 7;",
              "RULE 1 : IF x IS low THEN y IS a; RULE 2 : IF z IS NOT low THEN y IS b;");
  const Evaluation known = evaluate(base, {0.0, 1.0});
  CHECK(known.outputs[0]->value == doctest::Approx(2.0).epsilon(1e-12));
  const Evaluation x_alone = evaluate(base, {0.0, {}});
  CHECK(x_alone.rules[0].activation == 1.0);
  CHECK(x_alone.rules[1].activation == 0.0);
  CHECK(x_alone.outputs[0]->value == doctest::Approx(1.0).epsilon(1e-12));
  CHECK(x_alone.degrees == std::vector<std::vector<double>>{{1.0, 0.0}, {0.0}});
  const Guess nothing = evaluate(base, {{}, {}}).outputs[0].value();
  CHECK(nothing.is_otherwise);
  CHECK(nothing.value == 7.0);
  CHECK(nothing.width == 0.0);
  RuleBase without_default = base;
  without_default.outputs[0].otherwise.reset();
  CHECK_FALSE(evaluate(without_default, {{}, {}}).outputs[0]);
  // A linear conclusion needs its inputs.
  const RuleBase linear = base_of("TERM a := Linear 1 0 2; TERM b := Linear 0 1 2; METHOD : COGS;",
                                  "RULE 1 : IF x IS low THEN y IS a; RULE 2 : IF x IS low THEN y IS b;");
  CHECK(evaluate(linear, {0.5, {}}).outputs[0]->value == 2.5);
}

TEST_CASE("hedges, brackets and NOT") {
  const auto activation = [](const std::string& condition) {
    const RuleBase base = base_of("RANGE := (0 .. 1); TERM a := Triangle 0 0.5 1; METHOD : COG;",
                                  "AND : MIN; OR : MAX; RULE 1 : IF " + condition + " THEN y IS a;");
    return evaluate(base, {0.36, 0.9}).rules[0].activation;  // low 0.64, high 0.36; z low 0.1
  };
  const auto is = [](double value) { return doctest::Approx(value).epsilon(1e-14); };
  CHECK(activation("x IS very low") == is(0.4096));
  CHECK(activation("x IS somewhat high") == is(0.6));
  CHECK(activation("x IS extremely low") == is(1.0 - 2.0 * 0.36 * 0.36));
  CHECK(activation("x IS seldom high") == is(std::sqrt(0.18)));
  CHECK(activation("x IS not very somewhat high") == is(0.64));
  CHECK(activation("NOT x IS high") == is(0.64));
  CHECK(activation("x IS any") == 1.0);
  CHECK(activation("x IS not any") == 0.0);
  CHECK(activation("x IS high AND z IS low OR x IS low") == is(0.64));
  CHECK(activation("x IS high AND (z IS low OR x IS low)") == is(0.36));
  CHECK(activation("NOT (x IS high AND z IS low)") == is(0.9));
  CHECK(activation("NOT NOT (x IS high AND z IS low)") == is(0.1));
}

TEST_CASE("of inputs that are not known, conditions hold as far as they do whatever these are") {
  const auto activation = [](const std::string& condition, const Inputs& at) {
    const RuleBase base = base_of("RANGE := (0 .. 1); TERM a := Triangle 0 0.5 1; METHOD : COG;",
                                  "AND : MIN; OR : MAX; RULE 1 : IF " + condition + " THEN y IS a;");
    return evaluate(base, at).rules[0].activation;
  };
  const Inputs x_alone{0.75, {}}, nothing{{}, {}};  // x is low to 0.25
  CHECK(activation("NOT (x IS low OR z IS low)", nothing) == 0.0);
  CHECK(activation("NOT (x IS low OR z IS low)", x_alone) == 0.0);
  CHECK(activation("NOT (x IS low AND z IS low)", nothing) == 0.0);
  CHECK(activation("NOT (x IS low AND z IS low)", x_alone) == 0.75);
  CHECK(activation("NOT (NOT (x IS low AND z IS low) AND x IS high)", nothing) == 0.0);
  CHECK(activation("NOT (x IS high AND NOT (z IS low OR x IS low))", x_alone) == 0.25);
  CHECK(activation("x IS low OR z IS very not low", x_alone) == 0.25);
  CHECK(activation("NOT (x IS any AND z IS any)", nothing) == 0.0);
  CHECK(activation("NOT (x IS low AND z IS not any)", nothing) == 1.0);
}

TEST_CASE("De Morgan's laws hold for each pair of dual norms, for known and unknown inputs") {
  const struct {
    TNorm conjunction;
    SNorm disjunction;
  } pairs[] = {{TNorm::minimum, SNorm::maximum},   {TNorm::product, SNorm::sum},
               {TNorm::bounded, SNorm::bounded},   {TNorm::bounded, SNorm::normalised},
               {TNorm::drastic, SNorm::drastic},   {TNorm::einstein, SNorm::einstein},
               {TNorm::hamacher, SNorm::hamacher}, {TNorm::nilpotent, SNorm::nilpotent}};
  RuleBase base = base_of("RANGE := (0 .. 1); TERM a := Triangle 0 0.5 1; METHOD : COG;",
                          "RULE 1 : IF NOT (x IS low OR z IS low) THEN y IS a;"
                          "RULE 2 : IF NOT x IS low AND NOT z IS low THEN y IS a;"
                          "RULE 3 : IF NOT (x IS low AND z IS low) THEN y IS a;"
                          "RULE 4 : IF NOT x IS low OR NOT z IS low THEN y IS a;"
                          "RULE 5 : IF NOT (x IS low OR NOT (x IS high AND z IS low)) THEN y IS a;"
                          "RULE 6 : IF NOT x IS low AND (x IS high AND z IS low) THEN y IS a;");
  const std::optional<double> values[] = {{}, 0.0, 0.125, 0.25, 0.5, 0.875, 1.0};  // of which sums are exact
  double largest = 0.0, of_unknown = 0.0;
  for (const auto& [conjunction, disjunction] : pairs) {
    base.blocks[0].conjunction = conjunction;
    base.blocks[0].disjunction = disjunction;
    for (const std::optional<double>& x : values)
      for (const std::optional<double>& z : values) {
        const std::vector<RuleActivation> rules = evaluate(base, {x, z}).rules;
        for (std::size_t i = 0; i < rules.size(); i += 2) {
          CAPTURE(i);
          // Some roundings of numbers up to 1.
          CHECK(std::abs(rules[i].activation - rules[i + 1].activation) <= 1e-15);
          largest = std::max(largest, rules[i].activation);
          if (!x || !z) of_unknown = std::max(of_unknown, rules[i].activation);
          if (!x && !z) CHECK(rules[i].activation == 0.0);
        }
      }
  }
  CHECK(largest == 1.0);
  CHECK(of_unknown == 1.0);  // x is high, so that it is not low and z low
}

TEST_CASE("an evaluator has the numbers of evaluate, and keeps them") {
  const auto base = std::make_shared<const RuleBase>(base_of(
      "RANGE := (0 .. 4); TERM a := Triangle 0 1 2; TERM b := Triangle 2 3 4; METHOD : COG;",
      "RULE 1 : IF x IS low THEN y IS a; RULE 2 : IF z IS low THEN y IS b; RULE 3 : IF x IS high THEN y IS b;"));
  Evaluator evaluator(base);
  const Inputs one{0.25, {}}, other{0.25, 0.5};
  const std::optional<Guess>& first = evaluator.guess(0, one);
  CHECK(first->value == evaluate(*base, one).outputs[0]->value);
  CHECK(evaluator.guess(0, other)->value == evaluate(*base, other).outputs[0]->value);
  CHECK(evaluator.guess(0, other)->value != first->value);
  CHECK(&evaluator.guess(0, one) == &first);
  CHECK(evaluator.guess_of_term(0, 1)->value == guess_of_term(*base, 0, 1)->value);
  CHECK(&evaluator.guess_of_term(0, 1) == &evaluator.guess_of_term(0, 1));
  CHECK_FALSE(evaluator.guess(0, {{}, {}}));
  // The rules that apply, and no others.
  REQUIRE(first->rules.size() == 2);
  CHECK(first->rules[0].rule == 0);
  CHECK(first->rules[0].activation == 0.75);
  CHECK(first->rules[1].rule == 2);
  CHECK(evaluator.guess_of_term(0, 1)->rules.empty());
  CHECK_THROWS_WITH_AS(static_cast<void>(evaluator.guess(0, {std::nan(""), {}})),
                       doctest::Contains("input 'x': must be a finite number"), Error);
  CHECK_THROWS_AS(static_cast<void>(evaluator.guess(1, one)), std::out_of_range);
  RuleBase wrong = *base;
  wrong.outputs[0].terms[0].numbers = {2.0, 1.0, 0.0};
  CHECK_THROWS_WITH_AS(Evaluator(std::make_shared<const RuleBase>(wrong)), doctest::Contains("output 'y': term 'a'"),
                       Error);
}

TEST_CASE("what evaluate refuses") {
  RuleBase base =
      base_of("RANGE := (0 .. 4); TERM a := Triangle 0 1 2; METHOD : COG;", "RULE 1 : IF x IS low THEN y IS a;");
  CHECK_THROWS_WITH_AS(static_cast<void>(evaluate(base, {0.5})), doctest::Contains("1 values for 2 inputs"), Error);
  CHECK_THROWS_WITH_AS(static_cast<void>(evaluate(base, {0.5, std::nan("")})), doctest::Contains("input 'z'"), Error);
  CHECK_THROWS_WITH_AS(static_cast<void>(gradient_of(base, {0.5, 0.5}, 1)), doctest::Contains("no output 1"), Error);
  base.outputs[0].has_range = false;
  CHECK_THROWS_WITH_AS(static_cast<void>(evaluate(base, {0.5, 0.5})), doctest::Contains("'y': has no range"), Error);
  base.outputs[0].has_range = true;
  base.outputs[0].method = Method::leftmost_maximum;
  CHECK_THROWS_WITH_AS(static_cast<void>(gradient_of(base, {0.5, 0.5}, 0)),
                       doctest::Contains("METHOD LM has no derivatives"), Error);
  base.outputs[0].terms[0].numbers = {2.0, 1.0, 0.0};
  CHECK_THROWS_WITH_AS(static_cast<void>(evaluate(base, {0.5, 0.5})), doctest::Contains("output 'y': term 'a'"), Error);
  base.outputs[0].terms[0].numbers = {0.0, 1.0, 2.0};
  base.blocks[0].rules[0].condition[0].proposition.term = 2;
  CHECK_THROWS_WITH_AS(static_cast<void>(evaluate(base, {0.5, 0.5})), doctest::Contains("names term 2 of 'x'"), Error);
  base.blocks[0].rules[0].condition[0] = {ConditionNode::Kind::negation, {}, 0, 0};
  CHECK_THROWS_WITH_AS(static_cast<void>(evaluate(base, {0.5, 0.5})), doctest::Contains("a later one"), Error);
}
