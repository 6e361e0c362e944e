// FCL as it is read and written: what comes back, and what errors say.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/fuzzy.hpp>

#include "facts.hpp"
#include "random_base.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using namespace springnet::fuzzy;

namespace {

const std::string sample = R"(FUNCTION_BLOCK tissue
(* A comment
   of two lines *)
VAR_INPUT
  feel, wetness : REAL; // both
END_VAR
VAR_OUTPUT
  stiffness : REAL;
  slope : REAL;
END_VAR
FUZZIFY feel
  RANGE := (0..4);
  TERM soft := (0, 1) (2, 0);
  TERM hard := Trapezoid 1 3 4 4;
END_FUZZIFY
FUZZIFY wetness
  TERM watery := Sigmoid 0.5 -2e1;
END_FUZZIFY
DEFUZZIFY stiffness
  RANGE := (-1.5 .. 1e3);
  TERM low := Triangle -1 0 1;
  TERM high := Gaussian 500 25;
  METHOD : COG;
  ACCU : MAX;
  DEFAULT := 3;
END_DEFUZZIFY
DEFUZZIFY slope
  TERM one := 1;
  TERM line := Linear 1 -2.5 .5;
  METHOD : COGS;
  DEFAULT := NC;
END_DEFUZZIFY
RULEBLOCK first
  AND : PROD;
  OR : ASUM;
  ACT : MIN;
  RULE 1 : IF feel IS very soft AND NOT (wetness IS watery OR feel IS hard) THEN stiffness IS low, slope IS one WITH 0.25;
  RULE two : IF (feel IS hard OR feel IS soft) AND wetness IS not watery THEN stiffness IS somewhat high AND slope IS line;
END_RULEBLOCK
END_FUNCTION_BLOCK
)";

std::string error_of(const std::string& text) {
  try {
    static_cast<void>(parse_rules(text, "a.fcl"));
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return "no error";
}

// The sample with one text in place of another, which it has.
std::string error_with(const std::string& before, const std::string& after) {
  std::string text = sample;
  const std::size_t place = text.find(before);
  REQUIRE(place != std::string::npos);
  return error_of(text.replace(place, before.size(), after));
}

std::string repeated(const std::string& text, std::size_t count) {
  std::string result;
  for (std::size_t i = 0; i < count; ++i) result += text;
  return result;
}

}  // namespace

TEST_CASE("what is read") {
  const RuleBase base = parse_rules(sample, "a.fcl");
  CHECK(base.name == "tissue");
  REQUIRE(base.inputs.size() == 2);
  CHECK(base.inputs[0].largest == 4.0);
  CHECK(base.inputs[0].has_range);
  CHECK_FALSE(base.inputs[1].has_range);
  CHECK(base.inputs[1].smallest == doctest::Approx(0.2));  // what a sigmoid without a range spans
  CHECK(base.inputs[1].terms[0].numbers == std::vector<double>{0.5, -20.0});
  REQUIRE(base.outputs.size() == 2);
  CHECK(base.outputs[0].otherwise == 3.0);
  CHECK_FALSE(base.outputs[1].otherwise);
  CHECK(base.outputs[1].terms[1].numbers == std::vector<double>{1.0, -2.5, 0.5});
  const RuleBlock& block = base.blocks.at(0);
  CHECK(block.conjunction == TNorm::product);
  REQUIRE(block.rules.size() == 2);
  CHECK(text_of(base, block.rules[0]) ==
        "if feel is very soft and not (wetness is watery or feel is hard) then stiffness is low and slope is one with "
        "0.25");
  CHECK(
      text_of(base, block.rules[1]) ==
      "if (feel is hard or feel is soft) and wetness is not watery then stiffness is somewhat high and slope is line");
}

TEST_CASE("ACCU of a rule block is that of its outputs") {
  std::string text = sample;
  text.replace(text.find("  ACCU : MAX;\n"), 14, "");
  text.replace(text.find("  ACT : MIN;"), 12, "  ACT : MIN;\n  ACCU : BSUM;");
  CHECK(parse_rules(text, "a.fcl").outputs[0].accumulation == SNorm::bounded);
}

TEST_CASE("what is written comes back to the bit") {
  std::vector<RuleBase> bases{parse_rules(sample, "a.fcl")};
  for (unsigned seed = 0; seed < 200; ++seed) bases.push_back(testing::RandomBase(seed).make(seed % 2 == 1));
  for (const RuleBase& base : bases) {
    const std::string text = to_fcl(base);
    const RuleBase again = parse_rules(text, "again.fcl");
    CHECK(to_fcl(again) == text);
    for (std::size_t i = 0; i < base.inputs.size(); ++i) CHECK(again.inputs[i].has_range == base.inputs[i].has_range);
    const std::vector<Parameter> parameters = parameters_of(base);
    REQUIRE(parameters_of(again).size() == parameters.size());
    RuleBase before = base, after = again;
    for (const Parameter& each : parameters) CHECK(number_of(before, each) == number_of(after, each));
    REQUIRE(again.blocks.size() == base.blocks.size());
    testing::RandomBase random(1);
    const Inputs inputs = random.inputs(base);
    const Evaluation first = evaluate(base, inputs), second = evaluate(again, inputs);
    for (std::size_t i = 0; i < first.rules.size(); ++i) CHECK(first.rules[i].activation == second.rules[i].activation);
    for (std::size_t i = 0; i < first.outputs.size(); ++i) {
      REQUIRE(first.outputs[i].has_value() == second.outputs[i].has_value());
      if (first.outputs[i]) CHECK(first.outputs[i]->value == second.outputs[i]->value);
    }
  }
}

TEST_CASE("a file keeps all but the numbers of its terms") {
  const std::string fcl = "\xEF\xBB\xBF" + std::string(soft_tissue_fcl());
  CHECK(with_numbers_of(fcl, soft_tissue()) == fcl);
  RuleBase changed = soft_tissue();
  const std::vector<Parameter> parameters = parameters_of(changed);
  for (std::size_t i = 0; i < parameters.size(); i += 2) number_of(changed, parameters[i]) += 1e-9;
  const std::string text = with_numbers_of(fcl, changed);
  RuleBase again = parse_rules(text, "again.fcl");
  for (const Parameter& each : parameters) CHECK(number_of(again, each) == number_of(changed, each));
  const auto without_terms = [](const std::string& of) {
    std::string rest;
    for (std::size_t at = 0, term = 0; at < of.size(); at = of.find(';', term) + 1) {
      term = std::min(of.find("TERM", at), of.size());
      rest += of.substr(at, term - at);
      if (term == of.size()) break;
    }
    return rest;
  };
  CHECK(without_terms(text) == without_terms(fcl));
  // The sample has points and singletons too.
  RuleBase sampled = parse_rules(sample, "a.fcl");
  for (const Parameter& each : parameters_of(sampled))
    if (each.number == 0) number_of(sampled, each) -= 0.25;
  const std::string written = with_numbers_of(sample, sampled);
  RuleBase reread = parse_rules(written, "b.fcl");
  for (const Parameter& each : parameters_of(sampled)) CHECK(number_of(reread, each) == number_of(sampled, each));
  CHECK(written.find("(* A comment\n   of two lines *)") != std::string::npos);
  CHECK_THROWS_WITH_AS(static_cast<void>(with_numbers_of(sample, soft_tissue())),
                       doctest::Contains("other variables or terms"), Error);
}

TEST_CASE("errors say where, what, and the nearest names") {
  const struct {
    std::string before, after, facts;
  } cases[] = {
      {"FUNCTION_BLOCK tissue", "tissue", "a.fcl:1:1: 'tissue' | FUNCTION_BLOCK"},
      {"of two lines *)", "of two lines", "a.fcl:2:1: | comment | '*)'"},
      {"feel, wetness", "feel, feel", "a.fcl:5:9: | 'feel' is already there"},
      {"feel, wetness", "feel, 7", "a.fcl:5:9: | name of a variable | '7'"},
      {"feel, wetness", "feel, rule", "a.fcl:5:9: 'rule' is a word of FCL"},
      {"feel, wetness : REAL", "feel, wetness : INT", "a.fcl:5:19: 'INT' | REAL"},
      {"feel, wetness : REAL;", "feel, wetness : REAL", "a.fcl:6:1: ';' is missing | 'END_VAR'"},
      {"FUZZIFY feel", "FUZZIFY fell", "a.fcl:11:9: 'fell' is not an input; did you mean 'feel'?"},
      {"FUZZIFY wetness", "FUZZIFY feel", "a.fcl:16:9: | 'feel' has a FUZZIFY block already"},
      {"(0..4)", "(4..0)", "a.fcl:12:3: the range must rise, from 4 to 0"},
      {"(0..4)", "(0..4", "a.fcl:12:17: ')' is missing after a range's end, before ';'"},
      {"(0..4)", "(0..1e999)", "a.fcl:12:16: '1e999' is too large"},
      {"(0..4)", "(0..1e101)",
       "a.fcl:12:16: 1e+101 is too large to compute with; a number must be 0, or from 1e-100 to 1e+100"},
      {"(0..4)", "(0..4x)", "a.fcl:12:16: '4x' is not a number"},
      {"TERM hard :=", "TERM soft :=", "a.fcl:14:8: 'feel' has a term 'soft' already"},
      {"Trapezoid 1 3 4 4", "Trapezoid 1 3 4", "a.fcl:14:16: term 'hard' has 3 numbers, must have 4"},
      {"Trapezoid 1 3 4 4", "Trapezoid 1 3 2 4", "a.fcl:14:16: term 'hard' | rising order"},
      {"Trapezoid 1 3 4 4", "Trapezoid 4 4 4 4", "a.fcl:14:16: term 'hard' has no extent"},
      {"Trapezoid 1 3 4 4", "Trapez 1 3 4 4",
       "a.fcl:14:16: 'Trapez' is not a membership function; did you mean 'Trapezoid'?"},
      {"Trapezoid 1 3 4 4", "3", "a.fcl:14:8: term 'hard' is a single number | Triangle 2 3 4"},
      {"Trapezoid 1 3 4 4", "Linear 1 2 3", "a.fcl:14:8: term 'hard' is linear"},
      {"(0, 1) (2, 0)", "(0, 1) (-2, 0)", "a.fcl:13:16: term 'soft' has points whose x falls"},
      {"(0, 1) (2, 0)", "(0, 1.5) (2, 0)", "a.fcl:13:16: term 'soft' has a point of membership 1.5"},
      {"(0, 1) (2, 0)", "(0 1) (2, 0)", "a.fcl:13:19: ',' is missing"},
      {"(0, 1) (2, 0)", "(0, €) (2, 0)", "a.fcl:13:20: '€' has no meaning in FCL"},
      {"Sigmoid 0.5 -2e1", "Gaussian 0.5 -2", "a.fcl:17:18: | standard deviation of -2"},
      {"DEFUZZIFY stiffness", "DEFUZZIFY feel", "a.fcl:19:11: 'feel' is not an output; | stiffness, slope"},
      {"RANGE := (-1.5 .. 1e3);", "", "a.fcl:19:11: output 'stiffness' has no range"},
      {"METHOD : COG;", "METHOD : COGA;", "a.fcl:23:12: METHOD must not be 'COGA'; did you mean | 'COG'"},
      {"METHOD : COG;", "METHOD : COGS;", "a.fcl:21:8: term 'low' is no number, which METHOD COGS needs"},
      {"METHOD : COGS;", "METHOD : COG;", "a.fcl:28:8: term 'one' has no area, which METHOD COG needs"},
      {"ACCU : MAX;", "ACCU : PROD;", "a.fcl:24:10: ACCU must not be 'PROD'; there is MAX, ASUM"},
      {"DEFAULT := 3", "DEFAULT := soft", "a.fcl:25:14: DEFAULT must be a number, is 'soft'"},
      {"Linear 1 -2.5 .5", "Linear 1 -2.5", "a.fcl:29:16: term 'line' has 2 numbers, must have 3"},
      {"AND : PROD;", "AND : MAX;", "a.fcl:34:9: AND must not be 'MAX'; there is MIN, PROD"},
      {"ACT : MIN;", "ACT : MIN; ACCU : BSUM;", "a.fcl:36:14: output 'stiffness' has ACCU : MAX already"},
      {"RULE two", "RULE 1", "a.fcl:38:8: the block has a rule '1' already"},
      {"RULE two", "RULE 1.5", "a.fcl:38:8: a rule needs a number or a name"},
      {"RULE two : IF", "RULE two IF", "a.fcl:38:12: ':' is missing"},
      {"IF feel IS very soft", "IF fel IS very soft", "a.fcl:37:15: 'fel' is not an input; did you mean 'feel'?"},
      {"IF feel IS very soft", "IF slope IS very one",
       "a.fcl:37:15: 'slope' is an output; conditions are about inputs"},
      {"feel IS very soft", "feel IS verry soft", "a.fcl:37:23: 'feel' has no term 'verry'; there is soft, hard"},
      {"feel IS very soft", "feel IS very sofd", "a.fcl:37:28: 'feel' has no term 'sofd'; did you mean 'soft'?"},
      {"feel IS hard)", "feel IS hard", "a.fcl:37:76: ')' is missing after a condition in brackets, before 'THEN'"},
      {"WITH 0.25", "WITH 2", "a.fcl:37:118: a weight must be from 0 to 1, is 2"},
      {"somewhat high AND", "any AND", "a.fcl:38:92: 'any' concludes nothing"},
      {"END_RULEBLOCK\nEND_FUNCTION_BLOCK", "", "a.fcl:40:1: the end of the file stands where | END_RULEBLOCK"},
      {"END_FUNCTION_BLOCK\n", "END_FUNCTION_BLOCK\nRULEBLOCK", "a.fcl:41:1: 'RULEBLOCK' | the end of the file"},
  };
  for (const auto& each : cases) {
    const std::string message = error_with(each.before, each.after);
    CAPTURE(each.after);
    CAPTURE(message);
    CHECK(testing::has_facts(message, each.facts));
  }
  const std::string head = "FUNCTION_BLOCK VAR_INPUT x : REAL; END_VAR ";
  CHECK(testing::has_facts(error_of(head + "END_FUNCTION_BLOCK"), "a.fcl:1:44: there is no output"));
  CHECK(testing::has_facts(error_of(head + "VAR_OUTPUT y : REAL; END_VAR END_FUNCTION_BLOCK"),
                           "output 'y' has no terms; write DEFUZZIFY y"));
  CHECK(testing::has_facts(error_of(""), "a.fcl:1:1: the end of the file | FUNCTION_BLOCK"));
}

TEST_CASE("what a file may have is limited") {
  CHECK(testing::has_facts(error_with("IF feel", "IF " + repeated("(", 100) + "feel"), "more than 50 brackets"));
  CHECK(testing::has_facts(error_with("IF feel", "IF " + repeated("x", 201) + "feel"), "is not an input"));
  CHECK(testing::has_facts(error_with("feel IS very soft", "feel IS " + repeated("very ", 21) + "soft"),
                           "more than 20 hedges"));
  CHECK(testing::has_facts(
      error_with("IF feel", "IF " + repeated("NOT (", 30) + "NOT feel IS soft" + repeated(")", 30) + " AND feel"),
      "more than 20 hedges"));
  CHECK(testing::has_facts(error_with("IF feel", "IF " + repeated("feel IS soft AND ", 600) + "feel"),
                           "more than 1000 parts"));
  CHECK(testing::has_facts(error_with("(0, 1) (2, 0)", repeated("(0, 1) ", 1001)), "more than 1000 points"));
  CHECK(testing::has_facts(error_with("Linear 1", "Linear " + repeated("1 ", 500)), "more than 200 numbers"));
  std::string terms, variables;
  for (int i = 0; i < 201; ++i) {
    terms += "TERM t" + std::to_string(i) + " := Triangle 0 1 2; ";
    variables += "v" + std::to_string(i) + " : REAL; ";
  }
  CHECK(testing::has_facts(error_with("TERM soft", terms + "TERM soft"), "more than 200 terms"));
  CHECK(testing::has_facts(error_with("feel, wetness", variables + "feel, wetness"), "more than 200 variables"));
  CHECK(testing::has_facts(error_with("feel, wetness", repeated("x", 201) + ", wetness"), "at most 200 letters"));
  const testing::TemporaryFolder folder;
  const auto refusal = [&](const char* name) -> std::string {
    try {
      static_cast<void>(read_rules(folder.path() / name));
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  std::ofstream(folder.path() / "large.fcl") << sample << std::string(1'000'000, ' ');
  CHECK(testing::has_facts(refusal("large.fcl"), "large.fcl | more than 1000000 bytes"));
  CHECK(testing::has_facts(refusal("none.fcl"), "none.fcl"));
  std::filesystem::create_directory(folder.path() / "folder.fcl");
  CHECK(testing::has_facts(refusal("folder.fcl"), "folder.fcl | is not a file"));
  std::ofstream(folder.path() / "good.fcl") << "\xEF\xBB\xBF" << sample;
  CHECK(read_rules(folder.path() / "good.fcl").inputs.size() == 2);
}

TEST_CASE("the rule base of the documentation is read, and its tables name every word") {
  std::ifstream in(FUZZY_PAGE);
  const std::string page{std::istreambuf_iterator<char>(in), {}};
  const std::size_t begin = page.find("```\nFUNCTION_BLOCK");
  REQUIRE(begin != std::string::npos);
  const std::string text = page.substr(begin + 4, page.find("```", begin + 4) - begin - 4);
  CHECK(parse_rules(text, "fuzzy.md").blocks.at(0).rules.size() == 2);
  for (const char* word :
       {"Triangle", "Trapezoid", "Gaussian", "Sigmoid", "Linear", "not",   "very",  "somewhat", "extremely",
        "seldom",   "any",       "MIN",      "PROD",    "BDIF",   "DPROD", "EPROD", "HPROD",    "NMIN",
        "MAX",      "ASUM",      "BSUM",     "NSUM",    "DSUM",   "ESUM",  "HSUM",  "NMAX",     "COG",
        "COA",      "LM",        "RM",       "MM",      "COGS",   "COGSS"})
    CHECK_MESSAGE(page.find(std::string("`") + word) != std::string::npos, word);
  // The shipped words, as a scene writes them.
  for (const Variable& input : soft_tissue().inputs)
    for (const Term& term : input.terms) {
      std::string words = term.name;
      std::replace(words.begin(), words.end(), '_', ' ');
      CHECK_MESSAGE(page.find(words) != std::string::npos, words);
    }
}
