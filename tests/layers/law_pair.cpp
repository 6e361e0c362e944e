// Both laws of a batch at once, and the queries about springs that are made of them.

#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "layers/failure.hpp"
#include "layers/law_pair.hpp"
#include "layers/springs/queries.hpp"
#include "random_net.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr std::size_t count = 150;  // more than two blocks of parameters

// Springs of one group, with `different` rest lengths, between pairs of nodes.
Network pairs_of_nodes(const Material& material, bool different) {
  Network net;
  const MaterialIndex index = net.add_material(material);
  for (std::size_t k = 0; k < count; ++k) {
    const double at = static_cast<double>(k);
    const NodeIndex first = net.add_node(point({0.0, at, 0.0}, 1.0, {0.0, 0.0, 0.0}));
    const NodeIndex second = net.add_node(point({1.0 + 0.01 * at, at, 0.0}, 1.0, {0.02 * at - 1.0, 0.5, 0.0}));
    net.add_spring(first, second, index, different ? 1.0 + 0.003 * at : 1.25);
  }
  return net;
}

// All springs of such a network, evaluated in one batch.
struct Evaluated {
  explicit Evaluated(const Network& net) : fixture(net, InstructionSet::generic) {
    std::vector<std::uint32_t> springs(count);
    std::iota(springs.begin(), springs.end(), 0u);
    layers::PairOutputs out = answers.outputs(true, true);
    for (std::size_t k = 0; k < 2; ++k) {
      margin[k].assign(count, 0.0);
      out[k].margin = margin[k].data();
    }
    status = layers::evaluate_springs(fixture.layout, InstructionSet::generic, 0.0, fixture.nodes(), 0, springs.data(),
                                      count, geometry, out, message);
  }
  EvaluatorFixture fixture;
  layers::SegmentGeometry geometry;
  layers::PairAnswers<count> answers;
  std::vector<double> margin[2];
  springnet_message message{};
  springnet_status status;
};

}  // namespace

TEST_CASE("both laws of a batch follow their formulas, with neutral values for what a law does not have") {
  constexpr double k = 3.0, d = 2.0;
  for (const bool different : {false, true}) {
    const Evaluated at(
        pairs_of_nodes({LawUse{"linear", {{"stiffness", k}}}, LawUse{"linear", {{"damping", d}}}}, different));
    REQUIRE(at.status == SPRINGNET_OK);
    for (std::size_t i = 0; i < count; ++i) {
      const double rest = different ? 1.0 + 0.003 * static_cast<double>(i) : 1.25;
      const double stretch = at.geometry.length[i] - rest;
      CHECK(at.answers.force[0][i] == doctest::Approx(k * stretch).epsilon(1e-15));
      CHECK(at.answers.by_q[0][i] == k);
      CHECK(at.answers.by_rate[0][i] == 0.0);
      CHECK(at.answers.energy[0][i] == doctest::Approx(0.5 * k * stretch * stretch).epsilon(1e-15));
      CHECK(at.answers.force[1][i] == doctest::Approx(d * at.geometry.rate[i]).epsilon(1e-15));
      CHECK(at.answers.by_q[1][i] == 0.0);
      CHECK(at.answers.by_rate[1][i] == d);
      CHECK(std::isnan(at.answers.energy[1][i]));
      CHECK(std::isinf(at.margin[0][i]));
      CHECK(std::isinf(at.margin[1][i]));
    }
  }
}

TEST_CASE("a law along the relative velocity reads the speed") {
  const Evaluated at(pairs_of_nodes({std::nullopt, LawUse{"relative", {{"damping", 2.0}}}}, false));
  REQUIRE(at.status == SPRINGNET_OK);
  for (std::size_t i = 0; i < count; ++i)
    CHECK(at.answers.force[1][i] == doctest::Approx(2.0 * at.geometry.speed[i]).epsilon(1e-15));
}

TEST_CASE("a law without an array for its force is not evaluated") {
  const EvaluatorFixture fixture(
      pairs_of_nodes({LawUse{"linear", {{"stiffness", 3.0}}}, LawUse{"linear", {{"damping", 2.0}}}}, true));
  layers::SegmentGeometry geometry;
  const std::uint32_t spring = 7;
  double force = 0.0, untouched = 42.0;
  layers::PairOutputs out{};
  out[0].energy = &untouched;
  out[1].force = &force;
  springnet_message message{};
  REQUIRE(layers::evaluate_springs(fixture.layout, InstructionSet::generic, 0.0, fixture.nodes(), 0, &spring, 1,
                                   geometry, out, message) == SPRINGNET_OK);
  CHECK(untouched == 42.0);
  CHECK(force == doctest::Approx(2.0 * geometry.rate[0]).epsilon(1e-15));
}

TEST_CASE("queries about all springs agree with those about one") {
  const Network net = random_network(300, 6, 4);
  EvaluatorFixture fixture(net);
  const InstructionSet set = InstructionSet::best;
  fixture.layout.remove({5, 17});
  const std::size_t springs = net.springs().size();
  std::vector<double> tensions(springs), energies(springs);
  layers::spring_tensions(fixture.layout, set, 0.0, fixture.nodes(), tensions.data());
  layers::spring_energies(fixture.layout, set, 0.0, fixture.nodes(), energies.data());
  double sum = 0.0;
  for (std::uint32_t s = 0; s < springs; ++s) {
    const bool removed = s == 5 || s == 17;
    CAPTURE(s);
    CHECK(tensions[s] == (removed ? 0.0 : layers::spring_tension(fixture.layout, set, 0.0, fixture.nodes(), s)));
    if (removed || !net.materials()[net.springs()[s].material].spring) CHECK(energies[s] == 0.0);
    sum += energies[s];
  }
  // The same terms in another order.
  CHECK(layers::spring_energy(fixture.layout, set, 0.0, fixture.nodes()) == doctest::Approx(sum).epsilon(1e-13));
  CHECK(sum > 0.0);
  CHECK(layers::explain_failure(fixture.layout, set, 0.0, fixture.nodes(), layers::Requested::forces_and_derivatives) ==
        "");
}

TEST_CASE("margins to rupture are those of the law that can rupture") {
  const LawUse rupturing{"rupturing", {{"stiffness", 3.0}, {"strength", 1.5}}};
  const EvaluatorFixture fixture(pairs_of_nodes({rupturing, LawUse{"linear", {{"damping", 2.0}}}}, true));
  const std::vector<std::uint32_t> springs = layers::rupturing_springs(fixture.layout);
  REQUIRE(springs.size() == count);
  std::vector<double> margins(count, -1.0);
  springnet_message message{};
  REQUIRE(layers::spring_margins(fixture.layout, InstructionSet::generic, 0.0, fixture.nodes(), springs, margins.data(),
                                 message) == SPRINGNET_OK);
  // 1 - stiffness elongation / strength, elongation 0.007 m times the number of the spring.
  CHECK(margins.front() > 0.0);
  CHECK(margins.back() < 0.0);
  for (std::size_t i = 1; i < count; ++i) CHECK(margins[i] < margins[i - 1]);
}
