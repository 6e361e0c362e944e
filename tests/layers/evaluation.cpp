// Net forces by tiles against the formulas in plain code, spring by spring.

#include <doctest/doctest.h>

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
