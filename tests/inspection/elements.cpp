// Inspection of nets with elements, against closed forms and the engine's own derivatives.
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/inspection.hpp>

#include "../elements/bodies.hpp"
#include "../layers/random_net.hpp"
#include "eigenvalues.hpp"
#include "layers/linear/linearisation.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

double limit(const Inspection& found, const char* rule) {
  REQUIRE(found.limit(rule).kind == TimeConstantLimit::Kind::known);
  return found.limit(rule).time_constant;
}

}  // namespace

TEST_CASE("a node on a volume, of a tetrahedron or enclosed, has the limit of an oscillator") {
  for (const bool enclosed : {false, true}) {
    Network net;
    for (const Vector3& p : {Vector3(0, 0, 0), Vector3(3, 0, 0), Vector3(0, 2, 0)}) net.fix(net.add_node(point(p)));
    net.add_node(point({0.5, 0.4, 1.5}, 0.7));
    const MaterialIndex material = net.add_material(damped(5.0, 0.0));
    if (enclosed)
      net.add_element(Invariant::enclosed_volume, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}, material);
    else
      net.add_element(Invariant::volume, {0, 1, 2, 3}, material);
    const Inspection found = inspect(net, *plugins());
    // dV/dz = 1 m^2: t^2 k / m = 1. Searched to 1e-3.
    CHECK(limit(found, "synchronous") == doctest::Approx(std::sqrt(0.7 / 5.0)).epsilon(2e-3));
    const auto& set_by = found.limit("synchronous").set_by;
    REQUIRE(set_by);
    CHECK(set_by->node == 3);
    CHECK(set_by->element == ElementIndex{0});
    CHECK_FALSE(set_by->spring);
    CHECK(set_by->stiffness == doctest::Approx(5.0));
    CHECK(found.elements.at(enclosed ? "enclosed_volume" : "volume") == 1);
    CHECK(found.nodes_without_springs == 0);
    CHECK(found.parts.size() == 1);
    CHECK(to_json(found).find(enclosed ? "\"enclosed_volume\": 1" : "\"volume\": 1") != std::string::npos);
  }
}

TEST_CASE("an area that pushes buckles out of its plane: up to there a step has a unique solution") {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1.6, 0, 0)}) net.fix(net.add_node(point(p)));
  net.add_node(point({0.4, 0, 1.5}, 0.7));
  // Q = k (A - A_0) = -2 N/m, stiffness out of the plane Q base / (2 height).
  net.add_element(Invariant::area, {0, 1, 2}, net.add_material(damped(5.0, 0.0)), 1.2 + 0.4);
  const Inspection found = inspect(net, *plugins());
  REQUIRE(found.unique_time_constant);
  CHECK(*found.unique_time_constant == doctest::Approx(std::sqrt(0.7 * 2.0 * 1.5 / (2.0 * 1.6))).epsilon(2e-3));
}

TEST_CASE("the synchronous limit is that of the engine's own stiffness, with a load on every kind of element") {
  Network net = all_kinds(6, false);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    node.velocity.setZero();
    net.set_node(k, node);
  }
  const Inspection found = inspect(net, *plugins());
  EvaluatorFixture fixture(net);
  const std::uint32_t n = fixture.layout.node_count();
  const std::vector<std::uint8_t> constrained(n, 0);
  layers::Linearisation linearisation(fixture.layout, *fixture.evaluator, constrained);
  springnet_message message{};
  REQUIRE(linearisation.update(0.0, fixture.nodes(), fixture.external, message) == SPRINGNET_OK);
  const auto size = static_cast<Eigen::Index>(3 * n);
  Eigen::MatrixXd by_p(size, size);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(size, j);
    linearisation.times(unit.data(), zero.data(), by_p.col(j).data());
  }
  const double radius = spectral_radius(by_p);
  CHECK(limit(found, "synchronous") == doctest::Approx(1.0 / std::sqrt(radius)).epsilon(1e-2));
}

TEST_CASE("the wavefront's limit with an enclosed volume is where its sweeps stop settling") {
  const Network net = [] {
    Network filling = filled(icosphere(1, 1.0), 1.0, 5.0, 60.0, 0.0);
    filling.add_load({{3}, {0, 0, 0.01}});
    return filling;
  }();
  const double t = limit(inspect(net, *plugins()), "wavefront");
  const auto settles = [&](double step) {
    Simulation simulation = simulate(net, recurrent(wavefront, 1e-9, {{"max_sweeps", 3000}}), step);
    try {
      return simulation.step().outcome == Outcome::settled;
    } catch (const Error&) {
      return false;
    }
  };
  // The order of a run moves the limit by some per cent.
  CHECK(settles(0.9 * t));
  CHECK_FALSE(settles(1.15 * t));
}

TEST_CASE("elements resist mechanisms") {
  const auto mechanisms = [](const Network& net) {
    const Inspection found = inspect(net, *plugins());
    REQUIRE(found.mobility.known);
    return found.mobility.mechanisms;
  };
  const auto chain_with = [](bool angle) {
    Network net = chain(3, Vector3::Zero(), {1, 0, 0}, damped(1.0, 0.0));
    if (angle) net.add_element(Invariant::angle, {0, 1, 2}, 0, std::numbers::pi);
    return net;
  };
  CHECK(mechanisms(chain_with(false)) == 2);  // it bends, both ways
  CHECK(mechanisms(chain_with(true)) == 0);
  // Twelve coordinates, six motions as a rigid body, one volume.
  for (const bool enclosed : {false, true}) {
    Network net;
    for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)})
      net.add_node(point(p));
    const MaterialIndex material = net.add_material(damped(1.0, 0.0));
    if (enclosed)
      net.add_element(Invariant::enclosed_volume, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}, material);
    else
      net.add_element(Invariant::volume, {0, 1, 2, 3}, material);
    CHECK(mechanisms(net) == 5);
  }
  // A triangulated sphere is rigid; without one of its springs it has a mechanism, and no filling takes one that keeps
  // the volume to first order.
  const TriangleMesh mesh = icosphere(1, 1.0);
  CHECK(mechanisms(filled(mesh, 1.0, 1.0, 1.0, 0.0)) == 0);
}
