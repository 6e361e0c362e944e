// Lists with a value for each node, spring, element and face.
#include <string>

#include <doctest/doctest.h>

#include "everything.hpp"
#include "scenes.hpp"

using springnet::Element;
using springnet::Network;
using springnet::NodeIndex;
using springnet::SpringIndex;
using springnet::Vector3;

namespace {

const std::string begins = R"([simulation]
duration = 1
time_step = 0.1
[[body]]
name = "b"
nodes = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
springs = [[0, 1], [2, 0]]
neuron = { type = "point_mass" }
spring = { type = "linear", stiffness = 1.0 }
)";

}  // namespace

TEST_CASE("lists of a body, of pairs and of elements are taken one by one") {
  const Network net = parse(begins + R"(rest_lengths = [0.5, 0.25]
masses = [1, 2, 3]
velocities = [[0, 0, 1], [0, 0, 2], [0, 0, 3]]
faces = [[2, 1, 0]]
groups = [{ name = "ends", nodes = [2, 1] }]
[[connect]]
pairs = [[{ node = 1 }, { node = 2 }], [{ node = 2 }, { node = 1 }]]
rest_lengths = [0.1, 0.2]
spring = { type = "linear", stiffness = 2.0 }
[[rigid]]
pairs = [[{ node = 0 }, { node = 1 }]]
lengths = [1.000000001]
[[element]]
invariant = "area"
nodes = [[0, 1, 2], [0, 2, 1]]
references = [0.4, 0.6]
spring = { type = "linear", stiffness = 1.0 }
[[force]]
faces = [[0, 1, 2]]
areas = [[0, 0, 0.75]]
pressure = 2.0
[[fix]]
select = { group = "ends" }
[[instrument]]
box = { center = [0, 0, 50], size = [1, 2, 3], axes = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]] }
)")
                          .network;
  REQUIRE(net.springs().size() == 4);
  for (SpringIndex s = 0; s < 4; ++s) CHECK(net.springs()[s].rest_length == std::array{0.5, 0.25, 0.1, 0.2}[s]);
  for (NodeIndex k = 0; k < 3; ++k) {
    CHECK(net.nodes()[k].mass == 1.0 + k);
    CHECK(net.nodes()[k].fixed == (k > 0));
    if (k == 0) CHECK(net.nodes()[k].velocity == Vector3(0, 0, 1));
  }
  CHECK(net.faces() == std::vector<springnet::Face>{{2, 1, 0}});
  CHECK(net.bodies()[0].face_count == 1);
  CHECK(net.rigids()[0].length == 1.000000001);
  CHECK(net.elements()[0].reference == 0.4);
  CHECK(net.elements()[1].reference == 0.6);
  CHECK(net.loads()[0].areas == std::vector<Vector3>{{0, 0, 0.75}});
  CHECK(net.instruments()[0].box->axes.col(1) == Vector3(-1, 0, 0));
}

TEST_CASE("lists of another length, and keys that do not go with them, are refused") {
  const auto refused = [](const std::string& more, const std::string& what) {
    const std::string message = refusal(begins + more);
    CAPTURE(message);
    CHECK(message.find(what) != std::string::npos);
  };
  const std::string masses = "masses = [1, 1, 1]\n";
  refused("masses = [1, 2]", "must have 3 elements, has 2");
  refused("masses = [1, 2, -3]", "body.0.masses.2");
  refused(masses + "rest_lengths = [1]", "has 1 numbers, needs 2, one for each spring");
  refused(masses + "rest_lengths = [1, -1]", "body.0.rest_lengths.1");
  refused(masses + "rest_length_scale = 2\nrest_lengths = [1, 1]", "cannot be combined with 'rest_length_scale'");
  refused(masses + "velocities = [[0, 0, 0]]", "must have 3 elements");
  refused(masses + "faces = [[0, 1, 3]]", "there is no node 3");
  refused(masses + "faces = [[0, 1, 1]]", "body.0.faces.0");
  refused(masses + "groups = [{ name = \"a\", nodes = [7] }]", "there is no node 7");
  refused(masses + "groups = [{ name = \"a\", nodes = [1] }, { name = \"a\", nodes = [2] }]", "two groups 'a'");
  refused(masses + "mesh = { lattice = [2, 2, 2], spacing = 1 }", "both 'mesh' and 'nodes'");
  const std::string law = "spring = { type = \"linear\", stiffness = 1.0 }\n";
  refused(masses + "[[connect]]\npairs = [[{ node = 1 }, { node = 2 }]]\nrest_lengths = [1, 2]\n" + law,
          "has 2 numbers, needs 1, one for each pair");
  refused(masses + "[[connect]]\npairs = [[{ node = 1 }, { node = 2 }]]\nrest_lengths = [1]\nrest_length = 1\n" + law,
          "cannot be combined with 'rest_lengths'");
  refused(masses + "[[rigid]]\npairs = [[{ node = 1 }, { node = 2 }]]\nlengths = [1]\n", "rigid.0.lengths.0");
  refused(masses + "[[element]]\ninvariant = \"area\"\nnodes = [[0, 1, 2]]\nreferences = [1, 2]\n" + law,
          "needs 1, one for each element");
  refused(masses + "[[element]]\ninvariant = \"area\"\nnodes = [[0, 1, 2]]\nrests = []\n" + law, "has no meaning");
  refused(masses + "[[force]]\nfaces = [[0, 1, 2]]\nforce = [0, 0, 1]\n", "cannot be combined with 'faces'");
  refused(masses + "[[force]]\nfaces = [[0, 1, 2]]\nareas = []\npressure = 1\n", "must have 1 elements");
  refused(masses + "[[force]]\nselect = {}\nareas = []\nforce = [0, 0, 1]\n", "requires 'faces'");
  refused(
      masses +
          "[[instrument]]\nbox = { center = [0, 0, 50], size = [1, 1, 1], axes = [[1, 0, 0], [1, 0, 0], [0, 0, 1]] }\n",
      "rotation");
}
