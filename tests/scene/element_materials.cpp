// Bodies of elements in place of springs, and elements with several scalars, as a scene says them.
#include <algorithm>
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "scenes.hpp"

using namespace springnet;
using springnet::testing::has_facts;

namespace {

std::string body_of_elements(const std::string& mesh, const std::string& keys) {
  return simulation + "[[body]]\nname = \"b\"\n" + mesh + "\nneuron = { type = \"point_mass\" }\ndensity = 10.0\n" +
         keys + "\n";
}
const std::string box = "mesh = { lattice = [3, 3, 2], spacing = [0.5, 0.4, 0.3] }";
const std::string sheet = "mesh = { lattice = [3, 4, 1], spacing = 0.5 }\nthickness = 0.01";
const std::string solid = "youngs_modulus = 1e4, poisson_ratio = 0.4, law = \"solid\"";
const std::string membrane = "youngs_modulus = 1e4, poisson_ratio = -0.5, law = \"membrane\"";

std::string material(const std::string& keys) { return "material = { " + keys + " }"; }

const LawUse& law_of(const Network& net, const Element& element) { return *net.materials()[element.material].spring; }

}  // namespace

TEST_CASE("a body of tetrahedra that fill it and fit together") {
  const Scene scene = parse(body_of_elements(box, material(solid + ", damping_time = 0.01")));
  const Network& net = scene.network;
  CHECK(net.springs().empty());
  REQUIRE(net.elements().size() == 6 * 4);
  double volume = 0.0;
  std::vector<Face> inner;
  for (const Element& element : net.elements()) {
    CHECK(element.invariant == Invariant::tetrahedron);
    CHECK(element.reference > 0.0);
    volume += element.reference;
    CHECK(law_of(net, element).id == "solid");
    CHECK(law_of(net, element).parameters.at("poisson_ratio") == 0.4);
    const LawUse& viscosity = *net.materials()[element.material].viscosity;
    CHECK(viscosity.id == "viscous_solid");
    CHECK(viscosity.parameters.at("shear_viscosity") == doctest::Approx(0.01 * 1e4 / 2.8));
    CHECK(viscosity.parameters.at("bulk_viscosity") == doctest::Approx(0.01 * 1e4 / (3 * 0.2)));
    for (std::size_t skipped = 0; skipped < 4; ++skipped) {
      Face face{};
      std::size_t at = 0;
      for (std::size_t k = 0; k < 4; ++k)
        if (k != skipped) face[at++] = element.nodes[k];
      std::sort(face.begin(), face.end());
      inner.push_back(face);
    }
  }
  CHECK(volume == doctest::Approx(1.0 * 0.8 * 0.3).epsilon(1e-14));
  // Each triangle belongs to two tetrahedra, or to one: those of the surface, two for each side of a cell.
  std::sort(inner.begin(), inner.end());
  std::size_t once = 0;
  for (const Face& face : inner) {
    const auto [from, to] = std::equal_range(inner.begin(), inner.end(), face);
    CHECK(to - from <= 2);
    once += to - from == 1 ? 1 : 0;
  }
  CHECK(once == 2 * 2 * (4 + 2 + 2));
  CHECK(net.faces().size() == once);
  CHECK_FALSE(scene.output.elements);  // recorded on request
  const Scene recorded = parse("[output]\nelements = [\"b\"]\n" + body_of_elements(box, material(solid)));
  CHECK(recorded.output.element_numbers.size() == 24);
}

TEST_CASE("a body of triangles with bending, and one with a direction") {
  const Network net = parse(body_of_elements(sheet, material(membrane + ", bending = true"))).network;
  const auto count = [&](Invariant shape) {
    return std::count_if(net.elements().begin(), net.elements().end(),
                         [&](const Element& each) { return each.invariant == shape; });
  };
  CHECK(count(Invariant::triangle) == 12);
  CHECK(count(Invariant::hinge) == 23 - 10);  // edges less those of the rim
  const Network fibres =
      parse(body_of_elements(box, material("youngs_modulus = 1e4, poisson_ratio = 0.4, direction = [0, 3, 4], law "
                                           "= { type = \"fibre_solid\", fibre_modulus = 5e4 }")))
          .network;
  CHECK(fibres.elements()[0].direction[1] == doctest::Approx(0.6));
  CHECK(fibres.elements()[0].direction[2] == doctest::Approx(0.8));
}

TEST_CASE("elements with several scalars among chosen nodes") {
  const std::string net = body_of_elements(box, "spring = { type = \"linear\", stiffness = 1.0 }");
  const Network scaled =
      parse(net +
            "[[element]]\ninvariant = \"tetrahedron\"\nselect = { body = \"b\" }\nreference_scale = 2.0\n"
            "spring = { type = \"solid\", youngs_modulus = 1.0, poisson_ratio = 0.3 }\n")
          .network;
  REQUIRE(scaled.elements().size() == 24);
  CHECK(scaled.elements()[3].reference == doctest::Approx(8.0 * scaled.value_of(scaled.elements()[3])));
}

TEST_CASE("mistakes in element materials say what and where") {
  const auto refused = [](const std::string& text, const std::string& facts) {
    const std::string message = refusal(text);
    INFO(message);
    CHECK(has_facts(message, facts));
  };
  refused(body_of_elements(sheet, material(solid)), "body.0.material | tetrahedra | no solid cell");
  refused(body_of_elements(box, "thickness = 0.1\n" + material(membrane)), "body.0.material | triangles | solid cells");
  refused(body_of_elements(box, material("youngs_modulus = 1e4, law = \"solid\"")), "poisson_ratio");
  refused(body_of_elements(box, material("youngs_modulus = 1e4, poisson_ratio = 0.5, law = \"solid\"")),
          "between -1 and 0.5");
  refused(body_of_elements(box, material("youngs_modulus = 1e4, poisson_ratio = -1, law = \"solid\"")),
          "between -1 and 0.5");
  refused(body_of_elements(box, material(solid + ", direction = [1, 0, 0]")), "direction | same in all directions");
  refused(
      body_of_elements(
          box, material("youngs_modulus = 1e4, poisson_ratio = 0.4, law = { type = \"fibre_solid\", fibre_modulus = "
                        "5e4 }")),
      "has no 'direction'");
  refused(
      body_of_elements(box, material("youngs_modulus = 1e4, poisson_ratio = 0.4, direction = [0, 0, 0], law = { type = "
                                     "\"fibre_solid\", fibre_modulus = 5e4 }")),
      "direction | is 0");
  refused(body_of_elements(box, material(solid + ", bending = true")), "bending | no meaning for solids");
  refused(body_of_elements(box, material("youngs_modulus = 1e4, bending = true")), "bending | springs");
  refused(body_of_elements("mesh = { lattice = [3, 3, 2], spacing = 0.5, diagonals = \"all\" }", material(solid)),
          "diagonals");
  refused(body_of_elements(box, material("youngs_modulus = 1e4, poisson_ratio = 0.3, law = \"shell\"")),
          "neither triangles nor tetrahedra");
  refused(body_of_elements(box, material(solid) + "\nspring = { type = \"linear\", stiffness = 1.0 }"),
          "combined with 'material'");
  refused(body_of_elements("nodes = [[0, 0, 0], [1, 0, 0]]\nsprings = [[0, 1]]\ncross_section = 1.0", material(solid)),
          "use a mesh");
  const std::string net =
      body_of_elements(box, "spring = { type = \"linear\", stiffness = 1.0 }") + "[[element]]\nselect = {}\n";
  const std::string law = "spring = { type = \"solid\", youngs_modulus = 1.0, poisson_ratio = 0.3 }\n";
  refused(net + "invariant = \"tetrahedron\"\nreference = 1.0\n" + law, "reference | reference_scale");
  refused(net + "invariant = \"tetrahedron\"\nreference_scale = 0.0\n" + law, "reference_scale | above 0");
  refused(net + "invariant = \"volume\"\ndirection = [1, 0, 0]\n" + law, "direction | no meaning");
  refused(net + "invariant = \"tetrahedron\"\ndirection = [1, 0, 0]\n" + law,
          "element.0.direction | same in all directions");
  // A law that does not fit, at the place that says so.
  refused(net + "invariant = \"triangle\"\n" + law, "test.toml | element.0.select | 'solid' is for | tetrahedron");
  refused(net +
              "invariant = \"volume\"\nspring = { type = \"linear\", stiffness = 1.0 }\nviscosity = { type = "
              "\"relative\", damping = 1.0 }\n",
          "element.0.select | 'relative' reads the relative speed");
  const std::string fibres =
      "spring = { type = \"fibre_solid\", youngs_modulus = 1.0, poisson_ratio = 0.3, "
      "fibre_modulus = 1.0 }\n";
  refused(net + "invariant = \"tetrahedron\"\n" + fibres, "element.0.select | reads a direction");
  const auto one = [&](const std::string& nodes) {
    return simulation +
           "[[body]]\nname = \"b\"\nneuron = { type = \"point_mass\", mass = 1.0 }\nsprings = []\n"
           "nodes = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1e-9], [0, 0, 1]]\n"
           "[[element]]\nbody = \"b\"\ninvariant = \"tetrahedron\"\nnodes = [" +
           nodes + "]\n" + law;
  };
  refused(one("[0, 1, 2, 4], [0, 1, 2, 3]"), "element.0.nodes.1 | element 1 | needs a volume at rest | in a plane");
  refused(one("[0, 2, 1, 4]"), "element.0.nodes.0 | volume above 0 | exchange two");
  refused(body_of_elements(box, "spring = { type = \"solid\", youngs_modulus = 1.0, poisson_ratio = 0.3 }"),
          "body.0.spring.type | 'solid' is for elements | tetrahedron | not for springs");
  refused(body_of_elements(box, material(solid + ", damping_time = 1e308")), "damping_time | 1e+308 s | overflows");
}
