// What formulas declare in scenes: bounds and scales of parameters, inputs and states, stretches, promises. And
// formulas as the law of a material.
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <springnet/formula.hpp>

#include "facts.hpp"
#include "formula_scenes.hpp"
#include "scenes.hpp"

using namespace springnet;

namespace {

std::string spring(const std::string& keys) { return chain("spring = { " + keys + " }"); }

const LawUse& first_law(const Scene& scene) {
  const Network& net = scene.network;
  return *net.materials()[net.springs()[0].material].spring;
}

std::string body(const std::string& mesh, const std::string& material) {
  return simulation + "[[body]]\nname = \"b\"\nmesh = { lattice = " + mesh +
         ", spacing = 0.5 }\nneuron = { type = \"point_mass\" }\ndensity = 10.0\nthickness = 0.01\n[body.material]\n" +
         material + "\n";
}
const std::string sheet = "[3, 3, 1]", block = "[3, 3, 2]";

}  // namespace

TEST_CASE("what a parameter, an input, a state and a law declare in a scene") {
  const Scene scene = parse(spring(
      "formula = \"stiffness*(e - flow)*drive\", summary = \"all of it\", stretch = [0.5, 2], declares = "
      "[\"pulls only\", \"adds power\", \"smooth rates\"], stiffness = { value = \"3 N/m\", above = 0, largest = "
      "100, scale = 10, learnable = false, summary = \"of the spring\" }, inputs = { drive = { value = \"1 1\", "
      "smallest = 0, largest = 2 } }, states = { flow = { rate = \"(e - flow)/tau\", start = 0.25, unit = \"m\", "
      "smallest = 0, largest = inf, scale = 4, summary = \"of the dashpot\" } }, tau = \"0.5 s\""));
  const LawUse& use = first_law(scene);
  CHECK(use.parameters.at("stiffness") == 3.0);
  CHECK(use.parameters.at("tau") == 0.5);
  const LawFormula& law = *formula_of(*use.component);
  CHECK(law.summary == "all of it");
  CHECK(law.smallest_stretch == 0.5);
  CHECK(law.largest_stretch == 2.0);
  CHECK(law.pulls_only);
  CHECK(law.adds_power);
  CHECK(law.smooth_rates);
  CHECK_FALSE(law.monotone);
  CHECK_FALSE(law.not_zero_at_rest);
  REQUIRE(law.parameters.size() == 2);
  const FormulaSymbol& stiffness = law.parameters[0];
  CHECK(stiffness.unit == "N/m");
  CHECK(stiffness.smallest == 0.0);
  CHECK(stiffness.excludes_smallest);
  CHECK(stiffness.largest == 100.0);
  CHECK(stiffness.scale == 10.0);
  CHECK_FALSE(stiffness.learnable);
  CHECK(stiffness.summary == "of the spring");
  CHECK(law.parameters[1].learnable);
  CHECK(law.parameters[1].scale == 0.5);  // that of the value
  CHECK(law.inputs[0].preset == 1.0);
  CHECK(law.inputs[0].largest == 2.0);
  CHECK(law.states[0].start == 0.25);
  CHECK(law.states[0].unit == "m");
  CHECK(law.states[0].scale == 4.0);
  CHECK(law.states[0].largest == FormulaSymbol::infinity);
  CHECK(law.states[0].summary == "of the dashpot");
}

TEST_CASE("values of a formula beyond what it declares are refused as those of a plugin") {
  const auto k = [](const std::string& table) { return spring("formula = \"k*e\", k = { " + table + " }"); };
  CHECK(refusal(k("value = 3, smallest = 3, largest = 3")) == "");
  refused(k("value = \"3 N/m\", largest = 2"), "test.toml:9:43 | body.0.spring.k.value: must be at most 2 N/m, is 3");
  refused(k("value = -1, smallest = 0"), "body.0.spring.k.value: must be at least 0, is -1");
  refused(k("value = 0, above = 0"), "body.0.spring.k.value: must be above 0, is 0");
  // From a program, or with --set, too.
  const Scene scene = parse(k("value = 3, largest = 5"));
  LawUse use = first_law(scene);
  use.parameters["k"] = 6.0;
  CHECK_THROWS_WITH_AS(static_cast<void>(complete_parameters(*use.component->description, use.parameters, "here")),
                       doctest::Contains("must be at most 5"), Error);
  CHECK_THROWS_WITH_AS(static_cast<void>(parse(k("value = 3, largest = 5"), {{"body.0.spring.k.value", "7"}})),
                       doctest::Contains("must be at most 5, is 7"), Error);
  // A signal, and the start of a state.
  const std::string driven =
      chain("spring = { formula = \"drive*e\", inputs = { drive = { value = 1, largest = 2 } } }");
  refused(driven + "[[input]]\ninput = \"drive\"\nvalue = 3.0\n", "at most 2");
  refused(spring("formula = \"e - z\", states = { z = { rate = \"e\", start = 2, largest = 1 } }"),
          "body.0.spring.states.z.start: must be at most 1, is 2");
  refused(spring("formula = \"e - z\", states = { z = { rate = \"e\", smallest = 1 } }"),
          "body.0.spring.states.z: must be at least 1, is 0");
}

TEST_CASE("wrong declarations of parameters, inputs and states are told with their places") {
  const auto k = [](const std::string& table) { return spring("formula = \"k*e\", k = { " + table + " }"); };
  refused(k("smallest = 1"), "body.0.spring.k: has no 'value'");
  refused(k("value = 1, smalest = 0"), "body.0.spring.k.smalest | no key | did you mean 'smallest'");
  refused(k("value = 1, preset = 0"), "there is no key 'preset' of a parameter | known: value, smallest");
  refused(k("value = nan"), "body.0.spring.k.value | is nan");
  refused(k("value = inf"), "body.0.spring.k.value | finite");
  refused(k("value = [1]"), "body.0.spring.k.value | must be a number");
  refused(k("value = \"3\""), "no unit after the number");
  refused(k("value = 1, smallest = nan"), "body.0.spring.k.smallest: must be a number, is nan");
  refused(k("value = 1, smallest = \"0 N/m\""), "body.0.spring.k.smallest: must be a number, is a text");
  refused(k("value = 1, smallest = 2, largest = 1"), "body.0.spring.k.largest: must be at least the smallest, 2, is 1");
  refused(k("value = 1, smallest = 0, above = 0"), "above: cannot be combined with 'smallest'");
  refused(k("value = 1, above = inf"), "above: must be a finite number");
  refused(k("value = 1, scale = 0"), "body.0.spring.k.scale: must be above 0");
  refused(k("value = 1, scale = inf"), "body.0.spring.k.scale: must be a finite number");
  refused(k("value = 1, scale = \"logarithmic\""), "scale: must be a number above 0, the typical magnitude");
  refused(k("value = 1, learnable = 1"), "body.0.spring.k.learnable: must be true or false");
  refused(k("value = 1, summary = \"a\\u0007\""), "summary: must not have control characters");
  refused(k("value = 1, summary = \"" + std::string(5000, 'a') + "\""), "summary: must have at most");
  refused(k("value = 1, value = 2"), "not TOML");
  refused(spring("formula = \"k*e\", k = [1, 2]"), "body.0.spring.k: must be a number");
  refused(spring("formula = \"k*e\", inputs = { k = { value = 0, learnable = true } }"),
          "no key 'learnable' of an input");
  const auto z = [](const std::string& table) {
    return spring("formula = \"e - z\", states = { z = { rate = \"e - z\", " + table + " } }");
  };
  CHECK(refusal(z("start = \"0 m\", unit = \"m\"")) == "");
  refused(z("start = \"0 m\", unit = \"s\""), "states.z.unit: is 's', and 'start' is in m");
  refused(z("learnable = true"), "no key 'learnable' of a state | known: rate, start");
  refused(z("smallest = 2, largest = -2"), "states.z.largest: must be at least the smallest, 2, is -2");
  refused(z("scale = -1"), "states.z.scale: must be above 0");
  refused(z("unit = 3"), "states.z.unit: must be a text");
}

TEST_CASE("stretches and promises of a formula are checked") {
  const auto with = [](const std::string& keys) { return spring("formula = \"k*e\", k = 1, " + keys); };
  CHECK(refusal(with("stretch = [0, inf]")) == "");
  CHECK(refusal(with("declares = []")) == "");
  refused(with("stretch = 2"), "body.0.spring.stretch: must be two numbers [smallest, largest], is a number");
  refused(with("stretch = [1]"), "stretch: must have 2 elements, has 1");
  refused(with("stretch = [1, 2, 3]"), "stretch: must have 2 elements, has 3");
  refused(with("stretch = [2, 1]"), "stretch.1: must be above the smallest stretch, 2, is 1");
  refused(with("stretch = [2, 2]"), "stretch.1: must be above the smallest");
  refused(with("stretch = [-1, 2]"), "stretch.0: must be at least 0, as lengths are, is -1");
  refused(with("stretch = [nan, 2]"), "stretch.0: must be a number, is nan");
  refused(with("stretch = [0, nan]"), "stretch.1: must be a number, is nan");
  refused(with("stretch = [-inf, 2]"), "stretch.0: must be a finite number");
  refused(with("stretch = [\"0\", 2]"), "stretch.0: must be a number, is a text");
  refused(with("declares = \"monotone\""), "body.0.spring.declares: must be a list");
  refused(with("declares = [\"monoton\"]"), "declares.0: must be one of | 'pulls only' | did you mean 'monotone'");
  refused(with("declares = [1]"), "declares.0: must be a text");
  refused(with("declares = [\"monotone\", \"monotone\"]"), "declares.1: is listed twice");
  refused(with("declares = [\"smooth rates\"]"), "declares.0: has no meaning for a law without 'states'");
  std::string many;
  for (int i = 0; i < 100'000; ++i) many += "\"adds power\", ";
  refused(with("declares = [" + many + "]"), "declares.1: is listed twice");
  std::string numbers;
  for (int i = 0; i < 100'000; ++i) numbers += "1, ";
  refused(with("stretch = [" + numbers + "]"), "stretch: must have 2 elements, has 100000");
  refused(chain("viscosity = { formula = \"c*speed\", c = 1, stretch = [0, 2] }"),
          "stretch: has no meaning for a law of the relative speed");
  refused(with("stretch = [0, 2], type = \"linear\""), "cannot be combined with 'formula'");
  // Beside the name of a law they are keys like any other.
  refused(spring("type = \"linear\", stiffness = 1, stretch = [0, 2]"), "no key 'stretch'");
}

TEST_CASE("the springs of a material may have a formula") {
  const std::string material = "youngs_modulus = 1e4\n";
  const Scene formula = parse(body(block, material + "law = { formula = \"stiffness*e*(1 + b*e^2)\", b = 2.0 }"));
  const Scene linear = parse(body(block, material));
  const Network& net = formula.network;
  REQUIRE(net.springs().size() == linear.network.springs().size());
  const LawUse& first = first_law(formula);
  for (std::size_t i = 0; i < net.springs().size(); ++i) {
    const LawUse& own = *net.materials()[net.springs()[i].material].spring;
    const LawUse& other = *linear.network.materials()[linear.network.springs()[i].material].spring;
    CHECK(own.parameters.at("stiffness") == other.parameters.at("stiffness"));
    CHECK(own.parameters.at("b") == 2.0);
    CHECK(own.component == first.component);
  }
  const auto with = [&](const std::string& law) { return body(block, material + "law = { " + law + " }"); };
  CHECK(refusal(with("energy = \"stiffness/2*e^2\"")) == "");
  CHECK(refusal(with("formula = \"stiffness*e + tension\", tension = \"0.1 N\"")) == "");
  refused(with("formula = \"stiffness*e + tension\", tension = \"0.1 m\""), "is in m, and goes with what is in N");
  refused(with("formula = \"k*e\", k = 1"), "body.0.material.law: does not read 'stiffness' (N/m)");
  refused(with("formula = \"stiffness*e\", stiffness = 3"), "law.stiffness: is set by the material here; remove it");
  refused(with("formula = \"stiffness*angle\""), "body.0.material.law | reads an angle");
  refused(with("formula = \"stiffness*(e\""), "body.0.material.law.formula | not closed");
  refused(with("formula = \"stiffness*e\", type = \"linear\""), "cannot be combined with 'formula'");
  refused(with("formula = \"stiffness*e\"") + "direction = [1, 0, 0]\n", "direction | no meaning");
}

TEST_CASE("the elements of a material may have a formula, which gets its constants from the material") {
  const std::string edges = "scalars = { a = \"length(0, 1)\", b = \"length(0, 2)\", c = \"length(1, 2)\" }";
  const std::string energy =
      "energy = \"youngs_modulus*thickness*((a - rest(a))^2 + (b - rest(b))^2 + (c - rest(c))^2)\"";
  const Scene scene = parse(body(sheet, "youngs_modulus = 1e4\nlaw = { " + energy + ", " + edges + " }"));
  CHECK(scene.network.springs().empty());
  REQUIRE(scene.network.elements().size() == 8);
  const Element& element = scene.network.elements()[0];
  CHECK(element.invariant == Invariant::triangle);
  const LawUse& law = *scene.network.materials()[element.material].spring;
  CHECK(law.parameters.size() == 2);
  CHECK(law.parameters.at("youngs_modulus") == 1e4);
  CHECK(law.parameters.at("thickness") == 0.01);

  const std::string volume = "scalars = { v = \"volume(0, 1, 2, 3)\" }, energy = \"bulk*(v - rest(v))^2/rest(v)\"";
  const Scene solid = parse(body(block, "law = { " + volume + ", bulk = \"1e4 Pa\" }"));
  REQUIRE(!solid.network.elements().empty());
  CHECK(solid.network.elements()[0].invariant == Invariant::tetrahedron);

  const auto with = [&](const std::string& mesh, const std::string& keys) { return refusal(body(mesh, keys)); };
  // Damping, bending and directions as with a plugin.
  CHECK(with(sheet, "youngs_modulus = 1e4\npoisson_ratio = 0.3\ndamping_time = 0.01\nbending = true\nlaw = { " +
                        energy + ", " + edges + " }") == "");
  const std::string directed = "law = { energy = \"k*direction_0^2*a\", k = 1.0, scalars = { a = \"length(0, 1)\" } }";
  CHECK(with(sheet, "direction = [1, 0, 0]\n" + directed) == "");
  refused(body(sheet, directed), "has no 'direction'");
  refused(body(sheet, "youngs_modulus = 1e4\npoisson_ratio = 0.3\nlaw = { " + energy + ", " + edges + " }"),
          "body.0.material.poisson_ratio: has no meaning for 'formula'");
  refused(body(sheet, "law = { " + energy + ", " + edges + " }"), "the key 'youngs_modulus' is missing");
  refused(body(sheet, "youngs_modulus = 1e4\nlaw = { " + energy + ", youngs_modulus = 1, " + edges + " }"),
          "law.youngs_modulus: is set by the material here");
  refused(body(sheet, "law = { " + volume + ", bulk = 1.0 }"), "is for tetrahedra, and the mesh of the body has no");
  refused(body(block, "youngs_modulus = 1e4\nlaw = { " + energy + ", " + edges + " }"),
          "is for triangles, and the mesh of the body has solid cells");
  refused(body(sheet, "law = { " + volume + ", bulk = 1.0, stretch = [0, 2] }"),
          "stretch: has no meaning for a law over several scalars");
  refused(body(sheet, "law = { energy = \"k*a\", k = 1, scalars = { } }"), "scalars: lists none");
  refused(body(sheet, "law = { energy = \"k*a\", k = 1, scalars = { a = 3 } }"), "scalars.a: must be a text");
}

TEST_CASE("misspelt keys of a formula are told with the right ones") {
  refused(spring("formulae = \"k*e\", k = 1"), "body.0.spring.formulae: is no key of a law | did you mean 'formula'");
  refused(spring("enegry = \"k*e^2\", k = 1"), "body.0.spring.enegry: is no key of a law | did you mean 'energy'");
  refused(spring("formula = \"k*(e - z)\", k = 1, state = { z = \"e\" }"), "did you mean 'states'");
  refused(spring("formula = \"k*e\", k = 1, inputs_ = [\"a\"]"), "did you mean 'inputs'");
  // A parameter whose name is near to a key is one.
  CHECK(refusal(spring("formula = \"state*e\", state = 1")) == "");
}
