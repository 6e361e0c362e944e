// What 'springnet inspect' shows of words that stand for numbers.
#include <cmath>
#include <string>

#include <doctest/doctest.h>
#include <springnet/fuzzy.hpp>

#include "facts.hpp"
#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

const char* const scene = R"(
[simulation]
duration = 1.0
time_step = 0.001
[[body]]
name = "organ"
mesh = { lattice = [3, 3, 3], spacing = 0.01, diagonals = "all" }
neuron = { type = "point_mass" }
material = { like = "liver", feel = "hard" }
[[body]]
name = "line"
nodes = [[1, 0, 0], [1.01, 0, 0]]
springs = [[0, 1]]
neuron = { type = "point_mass", mass = 0.001 }
spring = { type = "linear", stiffness = "very soft" }
)";

}  // namespace

TEST_CASE("inspect shows which terms and rules gave which number, and how wide it is") {
  const TemporaryFolder folder;
  folder.write("organ.toml", scene);
  const Answer answer = testing::springnet(folder, "inspect organ.toml");
  CAPTURE(answer.out);
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(testing::has_facts(answer.out,
                           "First guesses from words | body.0.material.youngs_modulus = | to a factor of | from 'feel "
                           "= hard, like = liver' by "
                           "soft_tissue.fcl | rule words 4, activation 0.2: if feel is hard then log10_youngs_modulus "
                           "is hard with 0.2 | rule "
                           "tissues liver, activation 1: if like is liver then | body.0.density = 1079 kg/m^3 (+- 20), "
                           "from 'like = liver' by | "
                           "body.1.spring.stiffness = | N/m (to a factor of | "
                           "log10_stiffness is very_soft"));
  // What is shown is not noted once more, and 'inspect' does not send to itself.
  CHECK(answer.out.find("springnet inspect") == std::string::npos);
  // A run says so too, in a note.
  const Answer run = testing::springnet(folder, "run organ.toml -o out --duration 0.002");
  CHECK(run.status == 0);
  CHECK(testing::has_facts(run.out + run.err,
                           "stiffness is | N/m | a first guess from 'very soft'; 'springnet inspect'"));
}

TEST_CASE("the page's first scene has the guesses that the page shows, and its commands work") {
  const std::string page = testing::read_text(SPRINGNET_FUZZY_PAGE);
  const auto block = [&](const std::string& begin) {
    const std::size_t at = page.find(begin);
    REQUIRE(at != std::string::npos);
    const std::size_t text = page.find('\n', at) + 1;
    return page.substr(text, page.find("```", text) - text);
  };
  const TemporaryFolder folder;
  folder.write("organ.toml", block("```toml\n[simulation]"));
  const Answer answer = testing::springnet(folder, "inspect organ.toml");
  REQUIRE(answer.status == 0);
  CAPTURE(answer.out);
  CHECK(answer.out.find("\n\n" + block("```\nFirst guesses") + "\n") != std::string::npos);
  CHECK(testing::springnet(folder, "inspect organ.toml --plot organ.html").status == 0);
  CHECK(testing::springnet(folder, "inspect organ.toml --json").json().at("guesses").size() == 3);
}

TEST_CASE("inspect --json has the guesses as numbers") {
  const TemporaryFolder folder;
  folder.write("organ.toml", scene);
  const auto guesses = testing::springnet(folder, "inspect organ.toml --json").json().at("guesses");
  REQUIRE(guesses.size() == 3);
  CHECK(guesses[0]["key"] == "body.0.material.youngs_modulus");
  CHECK(guesses[0]["output"] == "log10_youngs_modulus");
  CHECK(guesses[0]["unit"] == "Pa");
  CHECK(guesses[2]["unit"] == "N/m");
  CHECK(guesses[0]["width_is_of"] == "decimal logarithm");
  CHECK(guesses[0]["terms"]["liver"] == 1.0);
  CHECK(guesses[0]["terms"]["hard"] == 0.2);
  CHECK(guesses[0]["rules"].size() == 2);
  CHECK(guesses[1]["width_is_of"] == "value");
  CHECK(guesses[2]["words"] == "very soft");
  CHECK(guesses[2]["rules"].empty());
  // The value is that of the rule base.
  const fuzzy::RuleBase& base = fuzzy::soft_tissue();
  fuzzy::Inputs inputs(base.inputs.size());
  for (std::size_t i = 0; i < base.inputs.size(); ++i)
    for (const fuzzy::Term& term : base.inputs[i].terms)
      if (term.name == "liver" || (term.name == "hard" && base.inputs[i].name == "feel"))
        inputs[i] = centre_of(base.inputs[i], term);
  const fuzzy::Guess wanted = evaluate(base, inputs).outputs[0].value();
  CHECK(guesses[0]["value"].get<double>() == doctest::Approx(std::pow(10.0, wanted.value)).epsilon(1e-12));
  CHECK(guesses[0]["width"].get<double>() == doctest::Approx(wanted.width).epsilon(1e-12));
  // Without words there are none.
  folder.write("pair.toml", testing::pair_scene);
  CHECK_FALSE(testing::springnet(folder, "inspect pair.toml --json").json().contains("guesses"));
}

TEST_CASE("inspect --plot draws the membership functions, those that count solid") {
  const TemporaryFolder folder;
  folder.write("organ.toml", scene);
  REQUIRE(testing::springnet(folder, "inspect organ.toml --plot guesses.svg").status == 0);
  const std::string svg = testing::read_text(folder.path() / "guesses.svg");
  CHECK(svg.starts_with("<svg"));
  CHECK(
      testing::has_facts(svg,
                         "body.0.material.youngs_modulus | feel | like | hard 1 | liver 1 | what the rules conclude | "
                         "stroke-dasharray | body.1.spring.stiffness | very_soft 1"));
  CHECK(svg.find("kidney") == std::string::npos);  // does not count: no entry of a legend
  CHECK(testing::springnet(folder, "inspect organ.toml --plot guesses.html").status == 0);
  CHECK(testing::read_text(folder.path() / "guesses.html").find("<html") != std::string::npos);
  const auto refusal = [&](const std::string& arguments) {
    const Answer answer = testing::springnet(folder, "inspect " + arguments);
    CHECK(answer.status == 2);
    return answer.err;
  };
  CHECK(testing::has_facts(refusal("organ.toml --plot guesses.png"), "--plot guesses.png | .svg or .html"));
  folder.write("pair.toml", testing::pair_scene);
  CHECK(testing::has_facts(refusal("pair.toml --plot guesses.svg"), "--plot | pair.toml | nothing to draw"));
}
