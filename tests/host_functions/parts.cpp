// Forces by parts, springs and elements one by one, energy and momentum: springnet_host::part_forces, view_elements,
// balance.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "probe.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr std::uint32_t all_parts[] = {SPRINGNET_PART_SPRINGS,  SPRINGNET_PART_VISCOSITIES,
                                       SPRINGNET_PART_ELEMENTS, SPRINGNET_PART_ELEMENT_VISCOSITIES,
                                       SPRINGNET_PART_GRAVITY,  SPRINGNET_PART_LOADS};

Vectors part(const sdk::Host& host, const springnet_evaluation& at, std::uint32_t parts) {
  Vectors force(host.network().node_count);
  host.part_forces(at, parts, force.out());
  return force;
}

// Springs, or elements, at a state.
struct View {
  std::vector<std::uint64_t> start;
  std::vector<std::uint32_t> nodes, relative;
  std::vector<double> gradients, value, rate, reference, force, by_value, by_rate;

  View(const sdk::Host& host, const springnet_evaluation& at, bool of_elements, std::uint64_t first,
       std::uint64_t count) {
    springnet_element_view view{};
    view.of_elements = of_elements ? 1 : 0;
    view.first = first;
    view.count = count;
    view.at = &at;
    host.view_elements(view);  // how many nodes
    start.resize(count + 1);
    nodes.resize(view.node_total);
    gradients.resize(3 * view.node_total);
    relative.resize(count);
    for (std::vector<double>* each : {&value, &rate, &reference}) each->resize(count);
    for (std::vector<double>* each : {&force, &by_value, &by_rate}) each->resize(2 * count);
    view.node_capacity = view.node_total;
    view.node_start = start.data();
    view.nodes = nodes.data();
    view.gradients = gradients.data();
    view.value = value.data();
    view.rate = rate.data();
    view.reference = reference.data();
    view.force = force.data();
    view.by_value = by_value.data();
    view.by_rate = by_rate.data();
    view.relative = relative.data();
    host.view_elements(view);
  }
  [[nodiscard]] Vector3 gradient(std::uint64_t place) const { return Eigen::Map<const Vector3>(&gradients[3 * place]); }
};

}  // namespace

TEST_CASE("forces of all parts add up to the net forces") {
  within_step(of_everything(), [](const sdk::Host& host) {
    const At at(host);
    springnet_evaluation evaluation = at.evaluation();
    Vectors net(at.n), sum(at.n);
    evaluation.force = net.out();
    host.evaluate(evaluation);
    evaluation.force = {};
    std::uint32_t together = 0;
    for (const std::uint32_t each : all_parts) {
      const Vectors force = part(host, evaluation, each);
      CHECK(*std::max_element(force.values.begin(), force.values.end()) > 0.1);  // each part is there
      for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += force.values[i];
      together |= each;
    }
    const Vectors whole = part(host, evaluation, together);
    for (std::size_t i = 0; i < sum.values.size(); ++i) {
      CHECK(std::abs(sum.values[i] - net.values[i]) <= 1e-11);
      CHECK(std::abs(whole.values[i] - net.values[i]) <= 1e-11);
    }
  });
}

TEST_CASE("parts of one oscillator are those of the formulas") {
  Network net = oscillator(damped(30.0, 2.0), 0.5, 0.1, 0.4);
  net.set_gravity({0, 0, -10});
  net.add_load({{1}, {0, 7, 0}});
  within_step(net, [](const sdk::Host& host) {
    const At at(host);
    const std::size_t k = host.network().user_number[0] == 1 ? 0 : 1;
    const springnet_evaluation evaluation = at.evaluation();
    const auto force = [&](std::uint32_t parts) { return part(host, evaluation, parts).at(k); };
    CHECK((force(SPRINGNET_PART_SPRINGS) - Vector3(-3, 0, 0)).norm() <= 1e-13);
    CHECK((force(SPRINGNET_PART_VISCOSITIES) - Vector3(-0.8, 0, 0)).norm() <= 1e-13);
    CHECK((force(SPRINGNET_PART_GRAVITY | SPRINGNET_PART_LOADS) - Vector3(0, 7, -5)).norm() <= 1e-13);
    CHECK(force(SPRINGNET_PART_ELEMENTS).norm() == 0.0);
    CHECK_THROWS_AS(force(64), sdk::Failure);
  });
}

TEST_CASE("springs and elements one by one: nodes, gradients and forces are those of the parts") {
  within_step(of_everything(), [](const sdk::Host& host) {
    const At at(host);
    const springnet_evaluation evaluation = at.evaluation();
    for (const bool elements : {false, true}) {
      CAPTURE(elements);
      const std::uint64_t count = elements ? 5 : host.network().spring_count;
      const View view(host, evaluation, elements, 0, count);
      Vectors force(at.n);
      for (std::uint64_t i = 0; i < count; ++i) {
        CHECK(view.start[i + 1] - view.start[i] == (elements ? std::vector<std::uint64_t>{3, 4, 3, 4, 26}[i] : 2));
        for (std::uint64_t j = view.start[i]; j < view.start[i + 1]; ++j)
          force.add(view.nodes[j], -(view.force[2 * i] + view.force[2 * i + 1]) * view.gradient(j));
        CHECK(view.relative[i] == (!elements && i == 3 ? 1 : 0));
      }
      Vectors expected =
          part(host, evaluation,
               elements ? SPRINGNET_PART_ELEMENTS | SPRINGNET_PART_ELEMENT_VISCOSITIES : SPRINGNET_PART_SPRINGS);
      if (!elements) {  // viscosities without the relative one, by the view's own rate
        const View one(host, evaluation, false, 3, 1);
        CHECK(one.force[1] == 0.0);
        CHECK(one.force[0] == doctest::Approx(20.0 * (one.value[0] - one.reference[0])).epsilon(1e-12));
        for (std::uint64_t i = 0; i < count; ++i)
          if (i != 3) CHECK(view.force[2 * i + 1] == doctest::Approx(view.rate[i]).epsilon(1e-12));  // 1 N s/m
        for (std::uint64_t i = 0; i < count; ++i)
          for (std::uint64_t j = view.start[i]; j < view.start[i + 1]; ++j)
            expected.add(view.nodes[j], -view.force[2 * i + 1] * view.gradient(j));
      }
      for (std::size_t i = 0; i < force.values.size(); ++i)
        CHECK(std::abs(force.values[i] - expected.values[i]) <= 1e-11);
    }
  });
}

TEST_CASE("gradients, rates and stiffnesses of the view are derivatives of its values and forces") {
  within_step(of_everything(), [](const sdk::Host& host) {
    for (const bool elements : {false, true}) {
      At at(host);
      const std::uint64_t count = elements ? 5 : 20;
      const View view(host, at.evaluation(), elements, 0, count);
      constexpr double step = 1e-6;
      for (std::uint64_t i = 0; i < count; ++i) {
        CAPTURE(i);
        double rate = 0.0;
        for (std::uint64_t j = view.start[i]; j < view.start[i + 1]; ++j)
          rate += view.gradient(j).dot(at.velocity.at(view.nodes[j]));
        CHECK(rate == doctest::Approx(view.rate[i]).epsilon(1e-9).scale(1));
        const std::uint64_t j = view.start[i];
        At moved = at;
        const Vector3 way = view.gradient(j).normalized();
        moved.position.add(view.nodes[j], step * way);
        const View other(host, moved.evaluation(), elements, i, 1);
        const double change = other.value[0] - view.value[i];
        CHECK(change / step == doctest::Approx(view.gradient(j).norm()).epsilon(1e-4));
        CHECK((other.force[0] - view.force[2 * i]) / change == doctest::Approx(view.by_value[2 * i]).epsilon(1e-4));
        At faster = at;
        faster.velocity.add(view.nodes[j], step * way);
        const View quick(host, faster.evaluation(), elements, i, 1);
        CHECK((quick.force[1] - view.force[2 * i + 1]) ==
              doctest::Approx(view.by_rate[2 * i + 1] * (quick.rate[0] - view.rate[i])).epsilon(1e-4).scale(1e-6));
      }
    }
  });
}

TEST_CASE("removed springs have no nodes and no force; ranges and room are checked") {
  task() = [](const sdk::Host& host) {
    if (host.committed().time == 0.0) return;
    const At at(host);
    const springnet_evaluation evaluation = at.evaluation();
    const View view(host, evaluation, false, 0, 3);
    CHECK(view.start[2] == view.start[1]);
    CHECK(view.force[2] == 0.0);
    CHECK(view.start[3] == 4);
    springnet_element_view small{};
    small.at = &evaluation;
    small.count = 3;
    small.nodes = const_cast<std::uint32_t*>(view.nodes.data());
    small.node_capacity = 3;
    CHECK_THROWS_WITH_AS(host.view_elements(small), doctest::Contains("4 nodes need room"), sdk::Failure);
    CHECK_THROWS_WITH_AS(View(host, evaluation, true, 4, 2), doctest::Contains("the network has 5"), sdk::Failure);
  };
  Simulation s = probe(of_everything());
  s.step();
  s.cut({1});
  s.step();
}

TEST_CASE("elements over several scalars, one by one") {
  // A tetrahedron with a fibre solid and a viscosity, a hinge, a triangle with a law of one scalar.
  Network net;
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(30, -1.0, 1.0).array().sin();
  const Vector3 places[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}};
  for (Eigen::Index k = 0; k < 5; ++k)
    net.add_node(
        point(places[k] + 0.1 * x.segment<3>(3 * k), 1.0 + 0.1 * static_cast<double>(k), x.segment<3>(3 * k + 15)));
  const LawUse fibres{
      "fibre_solid",
      {{"youngs_modulus", 3.0}, {"poisson_ratio", 0.2}, {"fibre_modulus", 2.0}, {"fibre_stiffening", 1.0}}};
  const LawUse shell{"shell", {{"youngs_modulus", 90.0}, {"poisson_ratio", 0.3}, {"thickness", 0.3}}};
  const LawUse viscous{"viscous_solid", {{"shear_viscosity", 0.6}, {"bulk_viscosity", 0.3}}};
  net.add_element(Invariant::tetrahedron, {0, 1, 2, 3}, net.add_material({fibres, viscous}),
                  {places[0], places[1], places[2], places[3]}, Vector3(1, 2, 3));
  net.add_element(Invariant::hinge, {1, 2, 0, 4}, net.add_material({shell, std::nullopt}),
                  {places[1], places[2], places[0] + Vector3(0, 0, 0.1), places[4]});
  net.add_element(Invariant::area, {0, 1, 2}, net.add_material({LawUse{"linear", {{"stiffness", 2.0}}}, std::nullopt}));
  within_step(net, [](const sdk::Host& host) {
    const At at(host);
    const springnet_evaluation evaluation = at.evaluation();
    constexpr double step = 1e-5;
    for (const std::uint32_t e : {0u, 1u}) {
      CAPTURE(e);
      const springnet_scalar_view view = host.view_scalars(evaluation, e);
      REQUIRE(view.node_count == 4);
      REQUIRE(view.scalar_count == (e == 0 ? 7 : 4));
      const auto gradient = [](const springnet_scalar_view& of, std::size_t s, std::size_t k) {
        return Vector3(Eigen::Map<const Vector3>(of.gradient[s][k]));
      };
      // Forces on the nodes, of this element alone, are those that move energy and momentum: against differences.
      for (std::size_t s = 0; s < view.scalar_count; ++s) {
        CAPTURE(s);
        const bool is_read = view.reference_only[s] == 0;
        CHECK(is_read == (e == 0 || view.kind[s] == SPRINGNET_DIHEDRAL));
        CHECK(view.reference[s] != 0.0);
        double rate = 0.0;
        for (std::size_t k = 0; k < 4; ++k) rate += gradient(view, s, k).dot(at.velocity.at(view.nodes[k]));
        CHECK(rate == doctest::Approx(view.rate[s]).epsilon(1e-9).scale(1));
        if (view.kind[s] == SPRINGNET_LENGTH && is_read)
          CHECK(view.value[s] == doctest::Approx((at.position.at(view.nodes[view.corners[s][0]]) -
                                                  at.position.at(view.nodes[view.corners[s][1]]))
                                                     .norm()));
      }
      for (std::size_t k = 0; k < 4; ++k) {
        At moved = at, faster = at;
        const Vector3 way = Vector3(0.3, -0.5, 0.8);
        moved.position.add(view.nodes[k], step * way);
        faster.velocity.add(view.nodes[k], step * way);
        const springnet_scalar_view other = host.view_scalars(moved.evaluation(), e);
        const springnet_scalar_view quick = host.view_scalars(faster.evaluation(), e);
        for (std::size_t i = 0; i < view.scalar_count; ++i) {
          CHECK((other.value[i] - view.value[i]) / step ==
                doctest::Approx(gradient(view, i, k).dot(way)).epsilon(1e-3).scale(1e-2));
          double by_value = 0.0, by_rate = 0.0, by_rate_alone = 0.0;
          for (std::size_t j = 0; j < view.scalar_count; ++j) {
            const double change = other.value[j] - view.value[j];
            by_value += (view.by_value[0][i][j] + view.by_value[1][i][j]) * change;
            by_rate += view.by_rate[1][i][j] * (other.rate[j] - view.rate[j]);
            by_rate_alone += view.by_rate[1][i][j] * (quick.rate[j] - view.rate[j]);
          }
          const double changes = other.force[0][i] + other.force[1][i] - view.force[0][i] - view.force[1][i];
          CHECK(changes / step == doctest::Approx((by_value + by_rate) / step).epsilon(1e-3).scale(1e-2));
          CHECK((quick.force[1][i] - view.force[1][i]) / step ==
                doctest::Approx(by_rate_alone / step).epsilon(1e-6).scale(1e-4));
        }
      }
      CHECK(view.by_rate[0][0][0] == 0.0);
    }
    // All of them, and the forces by parts: each law's share.
    for (const std::uint32_t parts : {SPRINGNET_PART_ELEMENTS, SPRINGNET_PART_ELEMENT_VISCOSITIES}) {
      Vectors sum = part(host, evaluation, parts);
      double size = 0.0;
      for (std::uint32_t node = 0; node < at.n; ++node) size += sum.at(node).norm();
      CHECK(size > 0.01);
      const std::size_t law = parts == SPRINGNET_PART_ELEMENTS ? 0 : 1;
      for (const std::uint32_t e : {0u, 1u}) {
        const springnet_scalar_view view = host.view_scalars(evaluation, e);
        for (std::size_t k = 0; k < 4; ++k)
          for (std::size_t s = 0; s < view.scalar_count; ++s)
            sum.add(view.nodes[k], view.force[law][s] * Vector3(Eigen::Map<const Vector3>(view.gradient[s][k])));
      }
      if (law == 0) {
        const View plain(host, evaluation, true, 2, 1);
        for (std::size_t k = 0; k < 3; ++k) sum.add(plain.nodes[k], plain.force[0] * plain.gradient(k));
      }
      for (std::uint32_t node = 0; node < at.n; ++node) CHECK(sum.at(node).norm() <= 1e-13 * size);
    }
    // One by one they are what batches of them are.
    Vectors net_force(at.n);
    springnet_evaluation whole = evaluation;
    whole.force = net_force.out();
    host.evaluate(whole);
    const Vectors elastic = part(host, evaluation, SPRINGNET_PART_ELEMENTS);
    const Vectors damping = part(host, evaluation, SPRINGNET_PART_ELEMENT_VISCOSITIES);
    for (std::uint32_t node = 0; node < at.n; ++node)
      CHECK((elastic.at(node) + damping.at(node) - net_force.at(node)).norm() <= 1e-12);
    CHECK_THROWS_WITH_AS(static_cast<void>(host.view_scalars(evaluation, 2)),
                         doctest::Contains("the laws of element 2 read one scalar"), sdk::Failure);
    CHECK_THROWS_WITH_AS(static_cast<void>(host.view_scalars(evaluation, 3)), doctest::Contains("the network has 3"),
                         sdk::Failure);
  });
}

TEST_CASE("energy and momentum of a state are those of the simulation") {
  task() = [](const sdk::Host&) {};
  const Network net = of_everything();
  const Simulation twin = probe(net);
  const double potential = const_cast<Simulation&>(twin).potential_energy();
  within_step(net, [&](const sdk::Host& host) {
    At at(host);
    const springnet_balance balance = host.balance(at.evaluation());
    CHECK(balance.potential == doctest::Approx(potential).epsilon(1e-13));
    CHECK(balance.kinetic == doctest::Approx(twin.kinetic_energy()).epsilon(1e-13));
    CHECK((Eigen::Map<const Vector3>(balance.momentum) - twin.momentum()).norm() <= 1e-11);
    CHECK((Eigen::Map<const Vector3>(balance.angular_momentum) - twin.angular_momentum()).norm() <= 1e-11);
    // At another state: twice as fast.
    for (double& v : at.velocity.values) v *= 2.0;
    CHECK(host.balance(at.evaluation()).kinetic == doctest::Approx(4.0 * twin.kinetic_energy()).epsilon(1e-13));
  });
}
