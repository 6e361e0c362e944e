// Laws as formulas in scenes: what the page of formulas shows, and mistakes with their places.
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include <doctest/doctest.h>

#include <springnet/simulation.hpp>

#include "facts.hpp"
#include "formula_scenes.hpp"
#include "scenes.hpp"

using namespace springnet;

namespace {

std::string page_of(const char* path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

const std::string sheet_of_springs =
    "[[body]]\nname = \"sheet\"\nmesh = { lattice = [3, 3, 1], spacing = 0.5, origin = [0, 0, 5] }\nneuron = { type = "
    "\"point_mass\", mass = 1.0 }\nspring = { type = \"linear\", stiffness = 0.0 }\n";

}  // namespace

TEST_CASE("the examples of the page of formulas are parts of scenes") {
  const std::string page = page_of(FORMULAS_PAGE);
  std::size_t examples = 0;
  for (std::size_t begin = page.find("```toml\n"); begin != std::string::npos; begin = page.find("```toml\n", begin)) {
    begin += 8;
    const std::string text = page.substr(begin, page.find("```", begin) - begin);
    const std::size_t tables = std::min(text.find("[["), text.size());
    const std::string law = tables > 0 ? text.substr(0, tables) : "spring = { type = \"linear\", stiffness = 1.0 }";
    const std::string scene = chain(law) + sheet_of_springs + text.substr(tables);
    CAPTURE(scene);
    CHECK(refusal(scene) == "");
    ++examples;
  }
  CHECK(examples >= 3);
}

TEST_CASE("a formula in a scene: parameters, units, inputs, curves, states") {
  const Scene scene = parse(chain(
      "spring = { formula = \"stiffness*e*(1 + drive) + table(e) + flow\", stiffness = \"3 N/m\", inputs = "
      "[\"drive\"], "
      "curves = { table = { x = [0, 1], y = [0, 2] } }, states = { flow = { rate = \"-flow/tau + 0*e\", start = 1 } }, "
      "tau = 0.5 }\nviscosity = { formula = \"damping*speed\", damping = 0.2 }"));
  const Network& net = scene.network;
  const Material& material = net.materials()[net.springs()[0].material];
  REQUIRE(material.spring->component != nullptr);
  CHECK(material.spring->parameters.at("stiffness") == 3.0);
  CHECK(material.spring->parameters.at("tau") == 0.5);
  CHECK(material.spring->component->law().state_count == 1);
  CHECK(material.spring->component->law().input_count == 1);
  CHECK(material.viscosity->component->law().invariant == SPRINGNET_RELATIVE_SPEED);
  // Everywhere where a law stands.
  const std::string elements =
      chain("spring = { formula = \"k*e\", k = 1 }\nviscosity = { formula = \"c*rate\", c = 1 }") +
      "[[connect]]\npairs = [[{ body = \"chain\", node = 0 }, { body = \"chain\", node = 2 }]]\n"
      "spring = { energy = \"k*e^2\", k = 1 }\n[[element]]\ninvariant = \"angle\"\nnodes = "
      "[[0, 1, 2]]\nspring = { formula = \"k*(angle - 3)\", k = 1 }\n[[spring]]\nselect = {}\n"
      "viscosity = { formula = \"c*rate^3\", c = 1 }\n";
  CHECK(refusal(elements) == "");
}

TEST_CASE("units are checked for the elements that have the law") {
  const auto law = [](const char* invariant, const std::string& unit) {
    const bool of_chain = invariant == std::string("angle");
    return chain("spring = { formula = \"k*e\", k = 1 }") + sheet_of_springs + "[[element]]\ninvariant = \"" +
           invariant + "\"\nselect = { body = \"" + (of_chain ? "chain" : "sheet") +
           "\" }\nspring = { formula = \"k*e\", k = \"2 " + unit +
           "\" }\nviscosity = { formula = \"c*rate\", c = 1 }\n";
  };
  CHECK(refusal(law("angle", "N m")) == "");
  CHECK(refusal(law("dihedral", "N m/rad")) == "");
  CHECK(refusal(law("area", "N/m^3")) == "");
  refused(law("angle", "N/m"), "element.0.spring.formula | force: is in N/m, and must be in J");
  refused(law("area", "N/m"), "element.0.spring.formula | must be in N/m");
  refused(chain("spring = { formula = \"k*e\", k = \"2 N m\" }"), "body.0.spring.formula | must be in N");
  CHECK(refusal(chain("spring = { formula = \"k*temp*e\", k = \"2 N/(m K)\", temp = \"300 K\" }")) == "");
}

TEST_CASE("a formula in a scene has its own limit of length, and a title that of texts") {
  const std::string zeros = "spring = { formula = \"k*e" + std::string(6000, ' ') + "\", k = 1 }";
  CHECK(refusal(chain(zeros)) == "");
  refused(chain("spring = { formula = \"k*e" + std::string(10'000, ' ') + "\", k = 1 }"),
          "body.0.spring.formula | at most 10,000 bytes, has 10,003");
  refused("title = \"" + std::string(6000, 'a') + "\"\n" + chain("spring = { formula = \"k*e\", k = 1 }"),
          "title | at most 4,096 bytes");
}

TEST_CASE("mistakes in formulas of scenes are told with file, line, column, key and a caret") {
  refused(
      chain("spring = { formula = \"stifness*e\", stiffness = 1 }"),
      "test.toml:9:22 | body.0.spring.formula | force: column 1 | 'stifness' is not known | did you mean 'stiffness' | "
      "stifness*e");
  refused(chain("spring = { formula = \"stiffness*e\", stiffness = 1, limit = 2 }"), "parameter 'limit' | no formula");
  refused(chain("spring = { formula = \"k*e\", k = \"3\" }"), "body.0.spring.k | no unit after the number");
  refused(chain("spring = { formula = \"k*e\", k = \"N/m\" }"), "body.0.spring.k | a number and its unit");
  refused(chain("spring = { formula = \"k*e\", k = \"3 N\" }"), "force | is in J | must be in N");
  refused(chain("spring = { formula = \"k*e\", k = true }"), "body.0.spring.k");
  refused(chain("spring = { formula = \"k*e\", type = \"linear\", k = 1 }"),
          "type | cannot be combined with 'formula'");
  refused(chain("spring = { formula = \"k*e\", k = 1, curves = 3 }"), "body.0.spring.curves | must be a table");
  refused(chain("spring = { formula = \"f(e)\", curves = { f = { x = [0, 1] } } }"), "curves.f | has no 'y'");
  refused(chain("spring = { formula = \"f(e)\", curves = { f = { x = [0, 0], y = [1, 2] } } }"), "curve 'f'");
  refused(chain("spring = { formula = \"e - z\", states = { z = { start = 1 } } }"), "states.z | has no 'rate'");
  refused(chain("spring = { formula = \"e - z\", states = { z = { rate = \"y\" } } }"),
          "rate of z: column 1 | 'y' is not");
  refused(chain("spring = { formula = \"k*angle\", k = 1 }"), "body.0.spring | reads an angle | the length");
  refused(chain("spring = { formula = \"k*speed\", k = 1 }"), "'speed' is read by viscosities alone");
  refused(chain("spring = { formula = \"k*e\", k = 1, scalars = { a = \"length(0, 1)\" } }"),
          "scalars | has no meaning here");
  const std::string element = chain("spring = { formula = \"k*e\", k = 1 }") + sheet_of_springs +
                              "[[element]]\ninvariant = \"triangle\"\nselect = { body = \"sheet\" }\n";
  refused(element + "spring = { energy = \"k*(a - rest(a))^2\", k = 1 }\n", "element.0.spring | has no 'scalars'");
  refused(element + "spring = { energy = \"k*(a - rest(a))^2\", k = 1, scalars = { a = \"length(0, 3)\" } }\n",
          "element.0.spring.energy | corner 3");
  refused(element + "spring = { energy = \"k*(a - rest(a))^2\", k = 1, scalars = { a = \"size(0, 1)\" } }\n",
          "'size(0, 1)' is none | area(0, 1, 2)");
  refused(element + "spring = { formula = { b = \"k*a\" }, k = 1, scalars = { a = \"length(0, 1)\" } }\n",
          "formula.b | no such name");
}

TEST_CASE("two formulas with parameters of the same names and values are two laws") {
  const std::string text = chain("spring = { formula = \"k*(length - 0.5)\", k = 2 }") +
                           "[[body]]\nname = \"other\"\nnodes = [[0, 0, 1], [1, 0, 1]]\nsprings = [[0, 1]]\n"
                           "neuron = { type = \"point_mass\", mass = 1.0 }\n"
                           "spring = { formula = \"10*k*(length - 0.5)\", k = 2 }\n";
  const Scene scene = parse(text);
  CHECK(scene.network.materials().size() == 2);
  const auto host = std::make_shared<const PluginHost>(PluginHost::with_default_search());
  const Simulation run(scene.network, host, scene.options);
  CHECK(run.tension(0) == 1.0);
  CHECK(run.tension(2) == 10.0);
}

TEST_CASE("a value that is set from outside keeps the bounds of its parameter") {
  const std::string text = chain("spring = { formula = \"k*e\", k = { value = 2, smallest = 0 } }");
  const Scene scene = parse(text, {parse_override("body.0.spring.k=3")});
  CHECK(scene.network.materials()[0].spring->parameters.at("k") == 3.0);
  CHECK(springnet::testing::has_facts(refusal(text, {parse_override("body.0.spring.k=-1")}), "body.0.spring.k | 0"));
}
