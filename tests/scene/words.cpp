// Words in place of numbers: which number stands for which word, and what is said of one that is none.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <string>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <springnet/fuzzy.hpp>
#include <springnet/scene_guesses.hpp>

#include "facts.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using springnet::testing::has_facts;

namespace {

std::string body(const std::string& keys, const std::string& neuron = "") {
  return simulation + "[[body]]\nname = \"b\"\nmesh = { lattice = [3, 3, 3], spacing = 0.01, diagonals = \"all\" }\n" +
         "neuron = { type = \"point_mass\"" + neuron + " }\n" + keys + "\n";
}

std::vector<SceneGuess> guesses_of(const std::string& text) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder.path() / "scene.toml") << text;
  std::ofstream(folder.path() / "rules.fcl") << std::ifstream(SCENE_FOLDER "/rules.fcl").rdbuf();
  return find_guesses(folder.path() / "scene.toml");
}

// A rule base of one input x, from 0 to 1, with the terms low and high.
std::string rules_of(const std::string& output, const std::string& more = "TERM a := 1; TERM b := 3; METHOD : COGS;",
                     const std::string& input = "x", const std::string& range = "RANGE := (0 .. 1);") {
  return fmt::format(
      "FUNCTION_BLOCK VAR_INPUT {1} : REAL; END_VAR VAR_OUTPUT {0} : REAL; youngs_modulus : REAL; END_VAR "
      "FUZZIFY {1} {3} TERM low := (0, 1) (1, 0); TERM high := (0, 0) (1, 1); END_FUZZIFY DEFUZZIFY {0} {2} "
      "END_DEFUZZIFY DEFUZZIFY youngs_modulus TERM c := 1000; METHOD : COGS; END_DEFUZZIFY RULEBLOCK "
      "RULE 1 : IF {1} IS low THEN {0} IS a; RULE 2 : IF {1} IS high THEN {0} IS b AND youngs_modulus IS c; "
      "END_RULEBLOCK END_FUNCTION_BLOCK",
      output, input, more, range);
}

// The scene with those rules; what it is refused with.
std::string refusal_by(const std::string& rules, const std::string& text) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder.path() / "own.fcl") << rules;
  try {
    static_cast<void>(parse_scene("rules = \"own.fcl\"\n" + text, "test.toml", plugins(), {}, folder.path()));
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}
std::vector<SceneGuess> guesses_by(const std::string& rules, const std::string& text,
                                   const PluginHost* host = nullptr) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder.path() / "own.fcl") << rules;
  std::ofstream(folder.path() / "scene.toml") << "rules = \"own.fcl\"\n" + text;
  return find_guesses(folder.path() / "scene.toml", {}, OutsideFiles::refused, host);
}

double total_mass(const Network& network) {
  double sum = 0.0;
  for (const Node& node : network.nodes()) sum += node.mass;
  return sum;
}

// The number of an input's term alone.
double by_rules(const char* output, const char* input, const char* term) {
  const fuzzy::RuleBase& base = fuzzy::soft_tissue();
  fuzzy::Inputs inputs(base.inputs.size());
  for (std::size_t i = 0; i < base.inputs.size(); ++i)
    for (const fuzzy::Term& each : base.inputs[i].terms)
      if (base.inputs[i].name == input && each.name == term) inputs[i] = centre_of(base.inputs[i], each);
  const fuzzy::Evaluation evaluation = evaluate(base, inputs);
  for (std::size_t o = 0; o < base.outputs.size(); ++o)
    if (base.outputs[o].name == output) return evaluation.outputs[o].value().value;
  return std::nan("");
}

}  // namespace

TEST_CASE("a material of words has the numbers of the rules") {
  const double modulus = std::pow(10.0, by_rules("log10_youngs_modulus", "like", "liver"));
  const double density = by_rules("density", "like", "liver");
  const double damping_time = std::pow(10.0, by_rules("log10_damping_time", "response", "viscous"));
  const Network words = parse(body("material = { like = \"liver\", response = \"viscous\" }")).network;
  const Network numbers =
      parse(body(fmt::format("density = {}\nmaterial = {{ youngs_modulus = {}, damping_time = {} }}", density, modulus,
                             damping_time)))
          .network;
  REQUIRE(words.springs().size() == numbers.springs().size());
  for (std::size_t i = 0; i < words.springs().size(); ++i) {
    const Material& ours = words.materials()[words.springs()[i].material];
    const Material& wanted = numbers.materials()[numbers.springs()[i].material];
    CHECK(ours.spring->parameters.at("stiffness") ==
          doctest::Approx(wanted.spring->parameters.at("stiffness")).epsilon(1e-14));
    CHECK(ours.viscosity->parameters.at("damping") ==
          doctest::Approx(wanted.viscosity->parameters.at("damping")).epsilon(1e-14));
  }
  CHECK(total_mass(words) == doctest::Approx(1079.0 * 8e-6).epsilon(1e-3));
  CHECK(total_mass(words) == doctest::Approx(total_mass(numbers)).epsilon(1e-14));
}

TEST_CASE("numbers of the scene go before guesses") {
  const std::string liver = "material = { like = \"liver\", youngs_modulus = 123.0 }";
  const auto keys = [](const std::string& text) {
    std::string all;
    for (const SceneGuess& guess : guesses_of(text)) all += guess.key + " ";
    return all;
  };
  CHECK(keys(body("material = { like = \"liver\" }")) == "body.0.material.youngs_modulus body.0.density ");
  CHECK(keys(body(liver)) == "body.0.density ");
  CHECK(keys(body(liver + "\ndensity = 1000.0")) == "");
  CHECK(keys(body(liver, ", mass = 1.0")) == "");
  CHECK(keys(body(
            "material = { feel = \"soft\", response = \"elastic\" }\nviscosity = { type = \"linear\", damping = 1 }",
            ", mass = 1.0")) == "body.0.material.youngs_modulus ");
  CHECK(parse(body(liver)).network.materials().size() ==
        parse(body("density = 1000.0\nmaterial = { youngs_modulus = 123.0 }")).network.materials().size());
}

TEST_CASE("what is felt and what it is count together, and a number lies between terms") {
  const auto modulus = [](const std::string& words) { return guesses_of(body("material = { " + words + " }"))[0]; };
  const SceneGuess liver = modulus("like = \"liver\""), hard = modulus("feel = \"hard\"");
  const SceneGuess both = modulus("like = \"liver\", feel = \"hard\"");
  CHECK(both.value > liver.value);
  CHECK(both.value < hard.value);
  CHECK(both.width > liver.width);  // they disagree
  CHECK(both.words == "feel = hard, like = liver");
  const SceneGuess between = modulus("feel = 3.5");
  CHECK(between.value > hard.value);
  CHECK(between.value < modulus("feel = \"Very hard\"").value);
  CHECK(modulus("feel = 3").value == hard.value);
}

TEST_CASE("a term stands where a key has the name of an output") {
  const Scene scene = parse(
      body("density = \"watery\"\nspring = { type = \"linear\", stiffness = \"very soft\" }\nviscosity = { type = "
           "\"linear\", damping = \"slightly viscous\" }"));
  const LawUse& spring = scene.network.materials()[0].spring.value();
  CHECK(spring.parameters.at("stiffness") ==
        doctest::Approx(std::pow(10.0, by_rules("log10_stiffness", "feel", "very_soft"))).epsilon(1e-12));
  CHECK(scene.network.materials()[0].viscosity->parameters.at("damping") ==
        doctest::Approx(std::pow(10.0, by_rules("log10_damping", "response", "slightly_viscous"))).epsilon(1e-12));
  CHECK(total_mass(scene.network) == doctest::Approx(1010.0 * 8e-6).epsilon(1e-3));
  CHECK(scene.notes.size() == 3);
  // By an input's term: the output has no term of that name of its own.
  const SceneGuess guess =
      guesses_of("rules = \"rules.fcl\"\n" +
                 body("density = \"high end\"\n" + std::string("spring = { type = \"linear\", stiffness = 1.0 }")))[0];
  CHECK(guess.value == doctest::Approx(1000.0).epsilon(1e-14));
  CHECK(guess.words == "grade = high end");
  CHECK(guess.is_logarithmic);
  CHECK(guess.rules_name == "rules.fcl");
  // In other tables too.
  CHECK(guesses_of(small +
                   "[[spring]]\nselect = { body = \"a\" }\nspring = { type = \"linear\", stiffness = \"hard\" }")[0]
            .key == "spring.0.spring.stiffness");
}

TEST_CASE("a scene's own rules") {
  const Network network = parse("rules = \"rules.fcl\"\n" + body("material = { grade = 0.25 }"))
                              .network;  // 1000 and 5000 Pa, 10^2 and 10^3
  CHECK(total_mass(network) == doctest::Approx(std::pow(10.0, 2.25) * 8e-6).epsilon(1e-12));
  const Network same = parse(body("density = 1.0\nmaterial = { youngs_modulus = 2000.0 }")).network;
  CHECK(network.materials()[0].spring->parameters.at("stiffness") ==
        doctest::Approx(same.materials()[0].spring->parameters.at("stiffness")).epsilon(1e-12));
  CHECK(has_facts(refusal("rules = \"none.fcl\"\n" + small), "test.toml:1:9: rules: | none.fcl"));
  CHECK(has_facts(refusal("rules = \"../material/CMakeLists.txt\"\n" + small),
                  "rules: lies outside of the scene's folder"));
  CHECK(has_facts(refusal("rules = \"curve.csv\"\n" + small),
                  "test.toml:1:9: rules: | curve.csv:1:1: '#' has no meaning"));
}

TEST_CASE("overrides are words as well") {
  const std::string text = body("material = { like = \"liver\" }");
  const auto mass = [&](const std::vector<SceneOverride>& overrides) {
    return total_mass(parse(text, overrides).network);
  };
  CHECK(mass({{"body.0.material.like", "\"bone\""}}) == doctest::Approx(1908.0 * 8e-6).epsilon(1e-3));
  CHECK(has_facts(refusal(text, {{"body.0.material.like", "\"bon\""}}),
                  "--set body.0.material.like=\"bon\": | did you mean 'bone'?"));
}

TEST_CASE("a word that is none: where, and the nearest ones") {
  const auto material = [](const std::string& keys) { return refusal(body("material = { " + keys + " }")); };
  CHECK(has_facts(material("like = \"livr\""),
                  "test.toml:8:21: body.0.material.like: 'livr' | soft_tissue.fcl | 'liver'"));
  CHECK(has_facts(material("feel = \"squishy\""), "body.0.material.feel: | very soft, soft, firm, hard, very hard"));
  CHECK(has_facts(material("feel = 7"), "body.0.material.feel: must be from 0 to 4 | is 7"));
  CHECK(has_facts(material("fell = \"soft\""),
                  "body.0.material.fell: unknown key | no input of soft_tissue.fcl; did you mean 'feel'?"));
  CHECK(has_facts(material("wetness = \"watery\""),
                  "body.0.material: wetness = watery says nothing of youngs_modulus | feel, like"));
  const auto stiffness = [](const std::string& text) {
    return refusal(body("spring = { type = \"linear\", stiffness = " + text + " }", ", mass = 1.0"));
  };
  CHECK(has_facts(stiffness("\"very sofd\""),
                  "test.toml:8:41: body.0.spring.stiffness: | 'very sofd' | did you mean 'very soft'?"));
  CHECK(has_facts(stiffness("\"3 N/m\""), "body.0.spring.stiffness: | a number | a text"));  // of formulas alone
  // A key that no output has is read as before.
  CHECK(has_facts(
      refusal(body("rest_length_scale = \"large\"\nspring = { type = \"linear\", stiffness = 1.0 }", ", mass = 1.0")),
      "body.0.rest_length_scale: | a number | a text"));
  CHECK(has_facts(
      refusal("rules = \"rules.fcl\"\n" + body("density = \"dense\"\nspring = { type = \"linear\", stiffness = 1.0 }")),
      "body.0.density: | 'dense' | rules.fcl | High End, heavy, light, low"));
}

TEST_CASE("guesses name the words that count, and their unit") {
  const std::vector<SceneGuess> guesses =
      guesses_of(body("material = { like = \"liver\", feel = \"hard\", response = \"viscous\" }"));
  REQUIRE(guesses.size() == 3);
  CHECK(guesses[0].words == "feel = hard, like = liver");
  CHECK(guesses[1].key == "body.0.material.damping_time");
  CHECK(guesses[1].words == "response = viscous");
  CHECK(guesses[2].words == "like = liver");
  CHECK(text_of(guesses[0]).find(" Pa (to a factor of ") != std::string::npos);
  CHECK(guesses[1].unit == "s");
  CHECK(text_of(guesses[2]) == "1079 kg/m^3 (+- 20)");
  // What the rules gave: two apply to the modulus, and the number is its logarithm.
  CHECK(guesses[0].number.rules.size() == 2);
  CHECK(std::pow(10.0, guesses[0].number.value) == doctest::Approx(guesses[0].value).epsilon(1e-14));
  // The unit of a law's parameter is that of the law.
  const std::string line = body("spring = { type = \"linear\", stiffness = \"soft\" }", ", mass = 1.0");
  CHECK(guesses_of(line)[0].unit == "");
  const std::vector<std::string> notes = parse(line).notes;
  REQUIRE(notes.size() == 1);
  CHECK(has_facts(notes[0], "stiffness is | N/m (to a factor of | 'soft'"));
  // Of a DEFAULT no rule is the reason.
  const std::string with_default =
      rules_of("poisson_ratio", "TERM a := 1; TERM b := 3; METHOD : COGS; DEFAULT := 0.25;", "x",
               "RANGE := (0 .. 1); TERM none := Triangle 0.4 0.5 0.6;");
  const std::string without_rules = with_default.substr(0, with_default.find("RULE 1")) +
                                    "RULE 1 : IF x IS none THEN poisson_ratio IS a; END_RULEBLOCK END_FUNCTION_BLOCK";
  const std::vector<SceneGuess> other =
      guesses_by(without_rules, body("material = { x = \"low\", youngs_modulus = 5 }", ", mass = 1.0"));
  REQUIRE(other.size() == 1);
  CHECK(other[0].value == 0.25);
  CHECK(has_facts(note_of(other[0]), "poisson_ratio is 0.25, the DEFAULT of own.fcl | none of its rules | 'x = low'"));
}

TEST_CASE("the masses of a body go before the density of its material") {
  const Network whole = parse(body("mass = 2.0\nmaterial = { like = \"liver\" }")).network;
  CHECK(total_mass(whole) == doctest::Approx(2.0).epsilon(1e-13));
  const auto cloud = [](const std::string& keys) {
    return simulation + "[[body]]\nname = \"b\"\nmesh = { points = \"cloud.csv\", radius = 1.1 }\n" +
           "neuron = { type = \"point_mass\" }\nmaterial = { like = \"liver\" }\n" + keys;
  };
  const Network points = parse(cloud("mass = 10.0\ncross_section = 1e-4\n")).network;
  CHECK(total_mass(points) == doctest::Approx(10.0).epsilon(1e-13));
  const double modulus = std::pow(10.0, by_rules("log10_youngs_modulus", "like", "liver"));
  // Springs of 1 m: E A / L
  REQUIRE(points.springs().size() == 4);
  for (const Spring& each : points.springs())
    CHECK(points.materials()[each.material].spring->parameters.at("stiffness") ==
          doctest::Approx(1e-4 * modulus).epsilon(1e-12));
  CHECK(
      has_facts(refusal(cloud("mass = 10.0\n")), "test.toml:8:12: body.0.material: a cloud of points | cross_section"));
  const std::string without_mass = refusal(cloud("cross_section = 1e-4\n"));
  CHECK(has_facts(without_mass, "body.0.neuron: has no mass | 'mass'"));
  CHECK(without_mass.find("density") == std::string::npos);
}

TEST_CASE("a value that is neither a word nor a number is told what may stand there") {
  CHECK(has_facts(
      refusal(body("material = { feel = true }")),
      "body.0.material.feel: must be one of 'very soft', 'soft', 'firm', 'hard', 'very hard' | a number from 0 "
      "to 4 | soft_tissue.fcl | is true or false"));
  CHECK(has_facts(refusal(body("material = { feel = [1, 2] }")), "body.0.material.feel: must be one of | is a list"));
}

TEST_CASE("an input without RANGE takes any number") {
  const auto scene = [](const std::string& x) { return body("material = { x = " + x + " }", ", mass = 1.0"); };
  const std::string bounded = rules_of("poisson_ratio"),
                    open = rules_of("poisson_ratio", "TERM a := 0.1; TERM b := 0.2; METHOD : COGS;", "x", "");
  CHECK(has_facts(refusal_by(bounded, scene("1.5")), "body.0.material.x: must be from 0 to 1 | is 1.5"));
  REQUIRE(guesses_by(open, scene("1.5")).size() == 2);
  CHECK(guesses_by(open, scene("1.5"))[1].value == 0.2);  // the last point of `high` holds beyond it
  CHECK(has_facts(refusal_by(open, scene("1e200")), "body.0.material: | input 'x': 1e+200 is too large"));
  CHECK(has_facts(refusal_by(open, scene("true")), "'low', 'high', or a number by the rules of own.fcl"));
}

TEST_CASE("words do not take the place of a scene's own texts") {
  for (const char* output : {"type", "name", "file", "select", "log10_interpolation"}) {
    CAPTURE(output);
    CHECK(
        has_facts(refusal_by(rules_of(output), small),
                  fmt::format("test.toml:1:9: rules: | own.fcl: output '{}' | no number in scenes | rename", output)));
  }
  CHECK(has_facts(refusal_by(rules_of("density", "TERM a := 1; TERM b := 3; METHOD : COGS;", "law"), small),
                  "test.toml:1:9: rules: | own.fcl: input 'law' | body.material.law"));
  // A key that may be a number or a text of its own.
  const auto friction = [](const std::string& text) {
    return small + "[[plane]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\nfriction = \"" + text + "\"\n";
  };
  CHECK(guesses_by(rules_of("friction"), friction("held")).empty());
  CHECK(guesses_by(rules_of("friction"), friction("a")).at(0).value == 1.0);
  CHECK(guesses_by(rules_of("friction"), friction("high")).at(0).value == 3.0);
  CHECK(has_facts(refusal_by(rules_of("friction"), friction("helt")), "plane.0.friction: | 'helt' is none"));
  // Formulas, whose texts may look like words.
  const std::string formula = body("spring = { formula = \"k\", k = 1.0, summary = \"low\" }", ", mass = 1.0");
  CHECK(guesses_by(rules_of("formula"), formula).empty());
  CHECK(guesses_by(rules_of("summary"), formula).empty());
}

TEST_CASE("bodies with the same words share one evaluation") {
  std::string terms, rules;
  for (int i = 0; i < 100; ++i) {
    terms += fmt::format("TERM t{0} := Gaussian 0.0{0} 1; ", i + 10);
    rules += fmt::format("RULE {0} : IF x IS t{0} THEN youngs_modulus IS t{0}; ", i + 10);
  }
  const std::string base =
      "FUNCTION_BLOCK VAR_INPUT x : REAL; END_VAR VAR_OUTPUT youngs_modulus : REAL; END_VAR FUZZIFY x RANGE := (0 .. "
      "1); " +
      terms + "END_FUZZIFY DEFUZZIFY youngs_modulus RANGE := (0 .. 1); " + terms +
      "METHOD : COG; END_DEFUZZIFY RULEBLOCK " + rules + "END_RULEBLOCK END_FUNCTION_BLOCK";
  const auto seconds = [&](double step) {
    std::string text = simulation;
    for (int i = 0; i < 60; ++i)
      text += fmt::format(
          "[[body]]\nname = \"b{}\"\nmesh = {{ lattice = [2, 2, 2], spacing = 0.01 }}\nneuron = {{ type = "
          "\"point_mass\", mass = 1.0 }}\nmaterial = {{ x = {} }}\n",
          i, 0.1 + step * i);
    const std::clock_t before = std::clock();
    CHECK(guesses_by(base, text).size() == 60);
    return static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  };
  // One evaluation of a hundred rules in place of sixty, of the time that the process computes. Measured: 40 times.
  const double different = seconds(0.001), same = seconds(0.0);
  CAPTURE(different);
  CAPTURE(same);
  CHECK(same < 0.4 * different);
}

TEST_CASE("errors about a guessed number have the place of the words") {
  const std::string text = body("material = { like = \"liver\" }\nspring = { type = \"linear\", stiffness = 1.0 }");
  CHECK(has_facts(refusal(text), "body.0.spring: cannot be combined with 'material'"));
  const std::string thin =
      simulation +
      "[[body]]\nname = \"b\"\nmesh = { lattice = [3, 3, 1], spacing = 0.01, diagonals = \"all\" }\n"
      "neuron = { type = \"point_mass\" }\nmaterial = { like = \"skin\" }\n";
  CHECK(has_facts(refusal(thin), "test.toml:8:12: | thickness"));
  CHECK(has_facts(refusal(thin, {{"body.0.density", "\"watery\""}}),
                  "--set body.0.density=\"watery\": body.0.density: | thickness"));
}
