// Words in place of numbers: which number stands for which word, and what is said of one that is none.
#include <cmath>
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

namespace {

bool contains(const std::string& text, const std::string& facts) { return springnet::testing::has_facts(text, facts); }

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
  CHECK(contains(refusal("rules = \"none.fcl\"\n" + small), "test.toml:1:9: rules: | none.fcl"));
  CHECK(contains(refusal("rules = \"../material/CMakeLists.txt\"\n" + small),
                 "rules: lies outside of the scene's folder"));
  CHECK(contains(refusal("rules = \"curve.csv\"\n" + small),
                 "test.toml:1:9: rules: | curve.csv:1:1: '#' has no meaning"));
}

TEST_CASE("overrides are words as well") {
  const std::string text = body("material = { like = \"liver\" }");
  const auto mass = [&](const std::vector<SceneOverride>& overrides) {
    return total_mass(parse(text, overrides).network);
  };
  CHECK(mass({{"body.0.material.like", "\"bone\""}}) == doctest::Approx(1908.0 * 8e-6).epsilon(1e-3));
  CHECK(contains(refusal(text, {{"body.0.material.like", "\"bon\""}}),
                 "--set body.0.material.like=\"bon\": | did you mean 'bone'?"));
}

TEST_CASE("a word that is none: where, and the nearest ones") {
  const auto material = [](const std::string& keys) { return refusal(body("material = { " + keys + " }")); };
  CHECK(contains(material("like = \"livr\""),
                 "test.toml:8:21: body.0.material.like: 'livr' | soft_tissue.fcl | 'liver'"));
  CHECK(contains(material("feel = \"squishy\""), "body.0.material.feel: | very soft, soft, firm, hard, very hard"));
  CHECK(contains(material("feel = 7"), "body.0.material.feel: must be from 0 to 4 | is 7"));
  CHECK(contains(material("fell = \"soft\""), "body.0.material.fell: unknown key; did you mean 'feel'?"));
  CHECK(contains(material("wetness = \"watery\""),
                 "body.0.material: wetness = watery says nothing of youngs_modulus | feel, like"));
  const auto stiffness = [](const std::string& text) {
    return refusal(body("spring = { type = \"linear\", stiffness = " + text + " }", ", mass = 1.0"));
  };
  CHECK(contains(stiffness("\"very sofd\""),
                 "test.toml:8:41: body.0.spring.stiffness: | 'very sofd' | did you mean 'very soft'?"));
  CHECK(contains(stiffness("\"3 N/m\""), "body.0.spring.stiffness: | a number | a text"));  // of formulas alone
  // A key that no output has is read as before.
  CHECK(contains(
      refusal(body("rest_length_scale = \"large\"\nspring = { type = \"linear\", stiffness = 1.0 }", ", mass = 1.0")),
      "body.0.rest_length_scale: | a number | a text"));
  CHECK(contains(
      refusal("rules = \"rules.fcl\"\n" + body("density = \"dense\"\nspring = { type = \"linear\", stiffness = 1.0 }")),
      "body.0.density: | 'dense' | rules.fcl | High End, heavy, light, low"));
}

TEST_CASE("errors about a guessed number have the place of the words") {
  const std::string text = body("material = { like = \"liver\" }\nspring = { type = \"linear\", stiffness = 1.0 }");
  CHECK(contains(refusal(text), "body.0.spring: cannot be combined with 'material'"));
  const std::string thin =
      simulation +
      "[[body]]\nname = \"b\"\nmesh = { lattice = [3, 3, 1], spacing = 0.01, diagonals = \"all\" }\n"
      "neuron = { type = \"point_mass\" }\nmaterial = { like = \"skin\" }\n";
  CHECK(contains(refusal(thin), "test.toml:8:12: | thickness"));
}
