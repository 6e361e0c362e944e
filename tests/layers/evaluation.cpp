// Net forces by tiles against the formulas in plain code, spring by spring.

#include <doctest/doctest.h>

#include <numeric>

#include <springnet/error.hpp>

#include "random_net.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// F_s of MODEL: -(T n) on the first end, from the laws' published formulas.
std::vector<Vector3> plain_forces(const Network& net) {
  std::vector<Vector3> force;
  for (const Node& node : net.nodes()) force.emplace_back(node.mass * net.gravity());
  const auto value = [](const LawUse& use, const char* name) {
    const auto found = use.parameters.find(name);
    return found == use.parameters.end() ? 0.0 : found->second;
  };
  for (const Spring& s : net.springs()) {
    const Node &a = net.nodes()[s.first], &b = net.nodes()[s.second];
    const Material& material = net.materials()[s.material];
    const Vector3 dp = a.position - b.position, dv = a.velocity - b.velocity;
    const double length = dp.norm();
    const Vector3 n = length > 0.0 ? Vector3(dp / length) : Vector3::Zero();
    Vector3 f = Vector3::Zero();
    if (material.spring) {
      const double x = length - s.rest_length;
      f -= (value(*material.spring, "stiffness") * x + value(*material.spring, "cubic") * x * x * x) * n;
    }
    if (material.viscosity) {
      const double d = value(*material.viscosity, "damping");
      f -= material.viscosity->id == "relative" ? Vector3(d * dv) : Vector3(d * n.dot(dv) * n);
    }
    force[s.first] += f;
    force[s.second] -= f;
  }
  return force;
}

double greatest(const std::vector<Vector3>& values) {
  double norm = 0.0;
  for (const Vector3& value : values) norm = std::max(norm, value.norm());
  return norm;
}

}  // namespace

TEST_CASE("tiles, runs and units give the forces of the formulas") {
  // Sums of some tens of terms in another order: rounding of a few hundred ulps of the greatest force.
  constexpr double rounding = 1e-13;
  Lattice lattice;
  lattice.nodes = {5, 9, 12};
  lattice.diagonals = Diagonals::all;
  Network regular;
  regular.add_lattice("box", lattice, Node{}, regular.add_material(damped(3.0, 2.0)));
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.1);
  for (std::uint32_t k = 0; k < regular.nodes().size(); ++k) {
    Node node = regular.nodes()[k];
    node.position += Vector3(noise(random), noise(random), noise(random));
    node.velocity = Vector3(noise(random), noise(random), noise(random));
    regular.set_node(k, node);
  }
  for (const bool renumber : {true, false}) {
    for (const Network& net :
         {random_network(300, 4, 1), random_network(20000, 4, 2), regular, random_network(2, 1, 4)}) {
      const std::vector<Vector3> expected = plain_forces(net);
      const double scale = greatest(expected);
      EvaluatorFixture fixture(net, InstructionSet::best, 2, renumber);
      fixture.evaluate();
      double worst = 0.0, worst_single = 0.0;
      for (std::uint32_t k = 0; k < net.nodes().size(); ++k) {
        worst = std::max(worst, (fixture.force(k) - expected[k]).norm());
        Vector3 single;
        springnet_message message{};
        REQUIRE(fixture.evaluator->evaluate_node(fixture.layout.ordering().engine[k], 0.0, fixture.nodes(),
                                                 fixture.external, nullptr, single, message) == SPRINGNET_OK);
        worst_single = std::max(worst_single, (single - expected[k]).norm());
      }
      CHECK(worst <= rounding * scale);
      CHECK(worst_single <= rounding * scale);
    }
  }
}

namespace {

// Without these springs.
Network without(const Network& net, const std::vector<std::uint8_t>& removed) {
  Network rest;
  for (const LawUse& neuron : net.neurons()) rest.add_neuron(neuron);
  for (const Material& material : net.materials()) rest.add_material(material);
  for (const Node& node : net.nodes()) rest.add_node(node);
  rest.set_gravity(net.gravity());
  for (std::uint32_t s = 0; s < net.springs().size(); ++s)
    if (const Spring& spring = net.springs()[s]; removed[s] == 0)
      rest.add_spring(spring.first, spring.second, spring.material, spring.rest_length);
  return rest;
}

// A lattice some of whose nodes are pushed aside, with springs of two rows and its nodes in a random order if wanted.
Network stirred_lattice(std::uint32_t nodes_a_side, bool shuffled, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 0.1);
  Lattice shape;
  shape.nodes = {nodes_a_side, nodes_a_side, nodes_a_side};
  shape.diagonals = Diagonals::space;
  Network lattice, net;
  const MaterialIndex material = lattice.add_material(damped(3.0, 2.0));
  lattice.add_lattice("box", shape, Node{}, material);
  std::vector<NodeIndex> order(lattice.nodes().size()), place(order.size());
  std::iota(order.begin(), order.end(), 0u);
  if (shuffled) std::shuffle(order.begin(), order.end(), random);
  net.add_material(lattice.materials()[material]);
  net.add_material(damped(5.0, 1.0));
  for (std::uint32_t k = 0; k < order.size(); ++k) {
    Node node = lattice.nodes()[order[k]];
    node.position += Vector3(noise(random), noise(random), noise(random));
    node.velocity = Vector3(noise(random), noise(random), noise(random));
    net.add_node(node);
    place[order[k]] = k;
  }
  for (const Spring& s : lattice.springs())
    net.add_spring(place[s.first], place[s.second], random() % 9 == 0 ? 1 : 0, s.rest_length);
  return net;
}

}  // namespace

// Chunks with gaps, springs read through a window, springs to the next unit and to one further on, each with springs
// removed in place and laid out again.
TEST_CASE("springs that are removed bit by bit leave the forces of the formulas, in the same bits for all threads") {
  constexpr double rounding = 1e-13;  // as above
  std::mt19937 random(5);
  for (const Network& net : {random_network(70, 3, 1), random_network(9000, 4, 2), stirred_lattice(4, false, 3),
                             stirred_lattice(13, false, 4), stirred_lattice(17, true, 5), random_network(3, 2, 6)}) {
    EvaluatorFixture one(net, InstructionSet::best, 1), four(net, InstructionSet::generic, 4);
    std::vector<std::uint8_t> removed(net.springs().size(), 0);
    for (const double share : {0.0, 0.001, 0.1, 0.4, 0.9}) {
      std::vector<std::uint32_t> now;
      for (std::uint32_t s = 0; s < removed.size(); ++s)
        if (static_cast<double>(random()) * 0x1p-32 < share) now.push_back(s);
      for (const std::uint32_t s : now) removed[s] = 1;
      one.layout.remove(now);
      four.layout.remove(now);
      const std::vector<Vector3> expected = plain_forces(without(net, removed));
      const double scale = greatest(expected);
      one.evaluate();
      four.evaluate();
      double worst = 0.0;
      for (std::uint32_t k = 0; k < net.nodes().size(); ++k) {
        worst = std::max(worst, (one.force(k) - expected[k]).norm());
        REQUIRE(one.force(k) == four.force(k));
      }
      CHECK(worst <= rounding * scale);
    }
  }
}

TEST_CASE("forces are those of tiles as they are finished, whether or not they are wanted as a whole") {
  const Network net = random_network(20000, 4, 9);
  EvaluatorFixture fixture(net, InstructionSet::best, 3);
  fixture.evaluate();
  struct Collected {
    std::vector<double> x, y, z;
    std::vector<int> count;
  } collected{std::vector<double>(20000), std::vector<double>(20000), std::vector<double>(20000),
              std::vector<int>(20000)};
  const layers::TileFinished finished{[](void* user, std::uint32_t, std::uint32_t first, std::uint32_t count,
                                         const layers::ForceArrays& force, springnet_message&) -> springnet_status {
                                        auto& own = *static_cast<Collected*>(user);
                                        for (std::uint32_t i = 0; i < count; ++i) {
                                          own.x[first + i] = force.x[i];
                                          own.y[first + i] = force.y[i];
                                          own.z[first + i] = force.z[i];
                                          ++own.count[first + i];
                                        }
                                        return SPRINGNET_OK;
                                      },
                                      &collected};
  springnet_message message{};
  REQUIRE(fixture.evaluator->evaluate(0.0, fixture.nodes(), fixture.external, {}, finished, message) == SPRINGNET_OK);
  CHECK(collected.x == fixture.f[0]);
  CHECK(collected.y == fixture.f[1]);
  CHECK(collected.z == fixture.f[2]);
  CHECK(collected.count == std::vector<int>(20000, 1));
}

TEST_CASE("results are bitwise equal for every number of threads and every instruction set") {
  const Network net = random_network(30000, 5, 7);
  EvaluatorFixture reference(net, InstructionSet::generic, 1);
  REQUIRE(reference.layout.units().size() >= 4);
  reference.evaluate();
  for (const InstructionSet set : {InstructionSet::generic, InstructionSet::avx2, InstructionSet::avx512}) {
    for (const unsigned threads : {1u, 2u, 3u, 4u}) {
      try {
        static_cast<void>(layers::choose_instruction_set(set));
      } catch (const Error& error) {
        MESSAGE("skipped: " << error.what());
        continue;
      }
      EvaluatorFixture fixture(net, set, threads);
      CHECK(fixture.evaluator->threads() == threads);
      fixture.evaluate();
      for (int c = 0; c < 3; ++c) CHECK(fixture.f[c] == reference.f[c]);
    }
  }
}

TEST_CASE("springs exchange momentum and angular momentum without loss") {
  Network net = random_network(500, 5, 11);
  net.set_gravity(Vector3::Zero());
  EvaluatorFixture fixture(net);
  fixture.evaluate();
  Vector3 sum = Vector3::Zero();
  double scale = 0.0;
  for (std::uint32_t k = 0; k < 500; ++k) {
    sum += fixture.force(k);
    scale = std::max(scale, fixture.force(k).norm());
  }
  CHECK(sum.norm() <= 1e-12 * scale);  // 500 nodes, each sum rounded
}

TEST_CASE("ends that coincide exert no force, and nothing is infinite or nan") {
  Network net;
  net.add_node(point(Vector3::Ones()));
  net.add_node(point(Vector3::Ones()));
  net.add_spring(0, 1, net.add_material(damped(5.0, 1.0)), 1.0);
  EvaluatorFixture fixture(net);
  fixture.evaluate();
  CHECK(fixture.force(0) == Vector3::Zero());
  CHECK(fixture.force(1) == Vector3::Zero());
}
