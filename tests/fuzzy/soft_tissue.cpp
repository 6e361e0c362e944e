// The shipped rule base: every word means something, and what it means is what its comments say.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/fuzzy.hpp>

using namespace springnet;
using namespace springnet::fuzzy;

namespace {

std::size_t output_named(const std::string& name) {
  const std::vector<Output>& outputs = soft_tissue().outputs;
  const auto found =
      std::find_if(outputs.begin(), outputs.end(), [&](const Output& each) { return each.name == name; });
  REQUIRE(found != outputs.end());
  return static_cast<std::size_t>(found - outputs.begin());
}

// The guess for one term of one input, nothing else being known.
std::optional<Guess> guess_for(const std::string& output, const std::string& input, const std::string& term) {
  const RuleBase& base = soft_tissue();
  Inputs inputs(base.inputs.size());
  for (std::size_t i = 0; i < base.inputs.size(); ++i)
    for (const Term& each : base.inputs[i].terms)
      if (base.inputs[i].name == input && each.name == term) inputs[i] = centre_of(base.inputs[i], each);
  return evaluate(base, inputs).outputs[output_named(output)];
}

}  // namespace

TEST_CASE("every term of an input gives a guess, with a width") {
  const RuleBase& base = soft_tissue();
  for (std::size_t i = 0; i < base.inputs.size(); ++i)
    for (const Term& term : base.inputs[i].terms) {
      CAPTURE(term.name);
      Inputs inputs(base.inputs.size());
      inputs[i] = centre_of(base.inputs[i], term);
      CHECK(degree_of(term, *inputs[i]) == 1.0);
      const Evaluation evaluation = evaluate(base, inputs);
      CHECK(std::any_of(evaluation.outputs.begin(), evaluation.outputs.end(),
                        [](const std::optional<Guess>& guess) { return guess && guess->width > 0.0; }));
      // At its own place no other term is met.
      CHECK(std::count_if(evaluation.degrees[i].begin(), evaluation.degrees[i].end(),
                          [](double degree) { return degree > 0.0; }) == 1);
    }
}

TEST_CASE("every term of an output is concluded, and lies within the range") {
  const RuleBase& base = soft_tissue();
  for (std::size_t o = 0; o < base.outputs.size(); ++o)
    for (std::size_t t = 0; t < base.outputs[o].terms.size(); ++t) {
      const Output& output = base.outputs[o];
      CAPTURE(output.terms[t].name);
      bool is_concluded = false;
      for (const RuleBlock& block : base.blocks)
        for (const Rule& rule : block.rules)
          for (const Conclusion& each : rule.conclusions) is_concluded |= each.output == o && each.term == t;
      CHECK(is_concluded);
      CHECK(degree_of(output.terms[t], output.smallest) < 1e-3);
      CHECK(degree_of(output.terms[t], output.largest) < 1e-3);
    }
}

TEST_CASE("words are in order, and tissues where their sources have them") {
  double before = 0.0, stiffness_before = -10.0;
  for (const char* feel : {"very_soft", "soft", "firm", "hard", "very_hard"}) {
    const double modulus = guess_for("log10_youngs_modulus", "feel", feel).value().value;
    const double stiffness = guess_for("log10_stiffness", "feel", feel).value().value;
    CHECK(modulus > before + 0.5);
    CHECK(stiffness > stiffness_before + 0.5);
    CHECK(stiffness == doctest::Approx(modulus - 1.9).epsilon(1e-3));
    before = modulus;
    stiffness_before = stiffness;
  }
  before = 2000.0;
  for (const char* wetness : {"dry", "moist", "wet", "watery"}) {
    const double density = guess_for("density", "wetness", wetness).value().value;
    CHECK(density < before);
    before = density;
  }
  const auto modulus = [](const char* tissue) {
    return std::pow(10.0, guess_for("log10_youngs_modulus", "like", tissue).value().value);
  };
  CHECK(modulus("liver") > 4e3);
  CHECK(modulus("liver") < 6e3);
  CHECK(std::abs(modulus("fat") - 3250.0) < 910.0);
  CHECK(modulus("bone") > 1e10);
  CHECK(modulus("bone") < 2.5e10);
  CHECK(guess_for("density", "like", "fat").value().value == doctest::Approx(911.0).epsilon(1e-3));
}

TEST_CASE("a term of an output stands for its own set") {
  const RuleBase& base = soft_tissue();
  const std::size_t density = output_named("density");
  const auto watery =
      static_cast<std::size_t>(std::find_if(base.outputs[density].terms.begin(), base.outputs[density].terms.end(),
                                            [](const Term& term) { return term.name == "watery"; }) -
                               base.outputs[density].terms.begin());
  const Guess guess = guess_of_term(base, density, watery).value();
  CHECK(guess.value == doctest::Approx(1010.0).epsilon(1e-6));
  CHECK(guess.width == doctest::Approx(10.0).epsilon(1e-3));
  // The rules conclude it alone, with a weight that multiplies the set.
  CHECK(guess_for("density", "wetness", "watery").value().value == doctest::Approx(guess.value).epsilon(1e-12));
}

TEST_CASE("where terms are") {
  const Variable range{"x", 0.0, 4.0, {}};
  const auto centre = [&](Shape shape, std::vector<double> numbers) {
    return centre_of(range, Term{"t", shape, std::move(numbers)});
  };
  CHECK(centre(Shape::triangle, {0, 1, 3}) == 1.0);
  CHECK(centre(Shape::triangle, {-3, -1, 3}) == 0.0);
  CHECK(centre(Shape::trapezoid, {0, 1, 3, 4}) == 2.0);
  CHECK(centre(Shape::trapezoid, {2, 3, 7, 8}) == 3.5);
  CHECK(centre(Shape::gaussian, {2.5, 1}) == 2.5);
  CHECK(centre(Shape::sigmoid, {2.5, 1}) == 4.0);
  CHECK(centre(Shape::sigmoid, {2.5, -1}) == 0.0);
  CHECK(centre(Shape::points, {0, 0, 1, 1, 3, 1, 4, 0}) == 2.0);
  CHECK(centre(Shape::points, {1, 1, 3, 0}) == 0.5);
  CHECK(centre(Shape::points, {1, 0, 3, 1}) == 3.5);
}
