// The program of examples/host/README.md, "Changes while it runs": the block there is that between the lines.

#include <fstream>
#include <iterator>
#include <string>

#include <doctest/doctest.h>

#include "nets.hpp"

using namespace springnet;

// ---- page ----
// clang-format off
// Springs are stiffer from now on, one is shortened, a node is heavier.
void treat(Simulation& simulation) {
  const ComponentKind spring = ComponentKind::spring_function;
  simulation.set_parameter({0, 1, 2}, spring, "stiffness", {300.0});           // one value for all
  simulation.set_rest_lengths({3, 4}, {0.9, 0.8 * simulation.rest_length(4)});  // or one each
  simulation.set_masses({5}, {2.0});
}

// A thread of four nodes from `first` to `second`, as a suture; rest lengths are the present distances.
void suture(Simulation& simulation, NodeIndex first, NodeIndex second) {
  simulation.extend([=](Network& now) {
    const MaterialIndex thread = now.add_material({LawUse{"linear", {{"stiffness", 2000.0}}}, std::nullopt});
    NodeIndex last = first;
    for (int k = 1; k <= 4; ++k) {
      Node node;
      node.mass = 0.001;
      node.position = now.nodes()[first].position +
                      k / 5.0 * (now.nodes()[second].position - now.nodes()[first].position);
      const NodeIndex added = now.add_node(node);
      now.add_spring(last, added, thread);
      last = added;
    }
    now.add_spring(last, second, thread);
  });
}

// Slow motion afterwards: long steps of an implicit method, without a spring and a node that are no longer wanted.
void go_on(Simulation& simulation) {
  simulation.cut({7});
  simulation.remove_nodes({8});
  simulation.set_integrator({"generalized_alpha", {}});
}
// clang-format on
// ---- end of page ----

TEST_CASE("the page's block is what is compiled here, and does what it says") {
  const auto text_of = [](const char* file) {
    std::ifstream in(file);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string page = text_of(HOST_PAGE), source = text_of(OWN_SOURCE);
  const std::size_t section = page.find("## Changes while it runs"), begin = page.find("```cpp\n", section) + 7;
  REQUIRE(section != std::string::npos);
  const std::string block = page.substr(begin, page.find("```", begin) - begin);
  CHECK(block.size() > 500);
  CHECK(source.find(block) != std::string::npos);

  Network net = springnet::testing::cube(200.0, 1.0, 0.0, 1.0);
  Simulation simulation =
      springnet::testing::simulate(net, springnet::testing::recurrent(springnet::testing::newton, 1e-8), 0.01);
  simulation.step();
  treat(simulation);
  CHECK(simulation.parameter(2, ComponentKind::spring_function, "stiffness") == 300.0);
  CHECK(simulation.rest_length(3) == 0.9);
  CHECK(simulation.mass(5) == 2.0);
  simulation.step();
  const std::size_t springs = simulation.spring_count();
  suture(simulation, 0, 63);
  CHECK(simulation.spring_count() == springs + 5);
  CHECK(simulation.tension(static_cast<SpringIndex>(springs)) == doctest::Approx(0.0).epsilon(1e-9));
  go_on(simulation);
  for (int i = 0; i < 10; ++i) simulation.step();
  CHECK(simulation.time() == doctest::Approx(0.12));
}
