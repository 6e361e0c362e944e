// Values of springs and elements from CSV files.
#include <string>

#include <doctest/doctest.h>

#include <springnet/simulation.hpp>

#include "facts.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;

namespace {

const std::string chain = simulation + R"([[body]]
name = "chain"
nodes = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 1, 0]]
springs = [[0, 1], [1, 2], [2, 3]]
neuron = { type = "point_mass", mass = 1 }
spring = { type = "linear", stiffness = 5.0 }
viscosity = { type = "linear", damping = 0.5 }
)";
const std::string angles = R"([[element]]
invariant = "angle"
nodes = [[0, 1, 2], [1, 2, 3]]
spring = { type = "linear", stiffness = 7.0 }
values = "values.csv"
)";
const std::string of_springs = "[[spring]]\nvalues = \"values.csv\"\n";

class Values {
 public:
  explicit Values(const std::string& csv) { folder_.write("values.csv", csv); }
  [[nodiscard]] Scene load(const std::string& text) const {
    return parse_scene(text, "test.toml", plugins(), {}, folder_.path());
  }
  [[nodiscard]] std::string refusal(const std::string& text) const {
    try {
      static_cast<void>(load(text));
    } catch (const Error& error) {
      REQUIRE(error.kind() == ErrorKind::input);
      return error.what();
    }
    return {};
  }

 private:
  springnet::testing::TemporaryFolder folder_;
};

double stiffness(const Network& network, MaterialIndex material) {
  return network.materials()[material].spring->parameters.find("stiffness")->second;
}

bool refuses(const std::string& csv, const std::string& table, const std::string& facts) {
  const std::string what = Values(csv).refusal(chain + table);
  CAPTURE(what);
  return springnet::testing::has_facts(what, facts);
}

}  // namespace

TEST_CASE("rows set laws and rest lengths of springs, others keep theirs") {
  const Network net =
      Values("spring, spring.stiffness, viscosity.damping, rest_length\n2, 50, 0, 1.25\n0, 8, 0.25, 1\n")
          .load(chain + of_springs)
          .network;
  CHECK(stiffness(net, net.springs()[0].material) == 8.0);
  CHECK(stiffness(net, net.springs()[1].material) == 5.0);
  CHECK(stiffness(net, net.springs()[2].material) == 50.0);
  CHECK(net.materials()[net.springs()[2].material].viscosity->parameters.find("damping")->second == 0.0);
  CHECK(net.materials()[net.springs()[0].material].viscosity->parameters.find("damping")->second == 0.25);
  CHECK(net.springs()[0].rest_length == 1.0);
  CHECK(net.springs()[1].rest_length == 1.0);
  CHECK(net.springs()[2].rest_length == 1.25);
}

TEST_CASE("springs with the same values share a material") {
  const Network net = Values("spring,spring.stiffness\n0,8\n1,8\n2,9\n").load(chain + of_springs).network;
  CHECK(net.springs()[0].material == net.springs()[1].material);
  CHECK(net.springs()[0].material != net.springs()[2].material);
  CHECK(net.materials().size() == 3);  // and that of the body
}

TEST_CASE("rest lengths alone leave the materials as they are") {
  const Network net = Values("spring,rest_length\n1,0.5\n").load(chain + of_springs).network;
  CHECK(net.materials().size() == 1);
  CHECK(net.springs()[1].rest_length == 0.5);
}

TEST_CASE("rows of elements count within their table") {
  const std::string other =
      "[[element]]\ninvariant = \"angle\"\nnodes = [[2, 1, 0]]\n"
      "spring = { type = \"linear\", stiffness = 1.0 }\n";
  const Network net = Values("element,spring.stiffness,reference\n1,9,0.5\n").load(chain + other + angles).network;
  REQUIRE(net.elements().size() == 3);
  CHECK(stiffness(net, net.elements()[0].material) == 1.0);
  CHECK(stiffness(net, net.elements()[1].material) == 7.0);
  CHECK(stiffness(net, net.elements()[2].material) == 9.0);
  CHECK(net.elements()[2].reference == 0.5);
}

TEST_CASE("parameters of a law that is a formula have rows, too") {
  std::string text = chain;
  const std::string linear = "spring = { type = \"linear\", stiffness = 5.0 }";
  text.replace(text.find(linear), linear.size(), "spring = { formula = \"hardness * e\", hardness = 2.0 }");
  const Network net = Values("spring,spring.hardness\n1,3\n").load(text + of_springs).network;
  CHECK(net.materials()[net.springs()[1].material].spring->parameters.find("hardness")->second == 3.0);
}

TEST_CASE("tables of values that do not fit are refused, with the line") {
  CHECK(refuses("spring,spring.stiffness\n0,8\n3,9\n", of_springs,
                "test.toml:12:10: | values | values.csv:3 | 3, numbered"));
  CHECK(refuses("spring,spring.stiffness\n0.5,8\n", of_springs, "values.csv:2 | 0.5"));
  CHECK(refuses("spring,spring.stiffness\n-1,8\n", of_springs, "values.csv:2 | -1"));
  CHECK(refuses("spring,spring.stiffness\n0,8\n0,9\n", of_springs, "values.csv:3 | spring 0"));
  CHECK(refuses("spring,spring.stifness\n0,8\n", of_springs, "column 2 | spring.stiffness | viscosity.damping"));
  CHECK(refuses("spring\n0\n", of_springs, "no values | spring.stiffness"));
  CHECK(refuses("spring,spring.stiffness\n", of_springs, "no rows"));
  CHECK(refuses("spring.stiffness\n1\n", of_springs, "'spring'"));
  CHECK(refuses("spring,viscosity.damping\n0,-1\n", of_springs, "values.csv:2 | viscosity.damping | -1"));
  CHECK(refuses("spring,rest_length\n0,-1\n", of_springs, "values.csv:2 | -1"));
  CHECK(refuses("spring,spring.stiffness\n0,\n", of_springs, "values.csv:2 | spring.stiffness"));
  CHECK(refuses("spring,spring.stiffness\n0,8\n", of_springs + "select = { springs = [0] }\n", "select | 'values'"));
  CHECK(refuses("element,spring.stiffness\n2,8\n", angles, "values.csv:2 | no element 2 | 2, numbered"));
  CHECK(refuses("spring,spring.stiffness\n0,8\n", angles, "column 1 | 'element'"));
}

TEST_CASE("a spring without the law of a column is told") {
  const std::string without = "[[spring]]\nselect = { springs = [1] }\nviscosity = \"none\"\n";
  CHECK(refuses("spring,viscosity.damping\n0,1\n1,1\n", without + of_springs, "values.csv:3 | spring 1 | 'damping'"));
  CHECK_FALSE(refuses("spring,viscosity.damping\n0,1\n2,1\n", without + of_springs, "values.csv"));
}
