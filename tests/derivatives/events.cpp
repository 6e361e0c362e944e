// Derivatives of event functions: gaps of obstacles that move, margins of rupture.

#include <doctest/doctest.h>

#include "../elements/bodies.hpp"
#include "host_at.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Values event_values(HostAt& at) {
  Values values(at.host.network().event_count);
  at.host.event_values(at.evaluation(), values.data(), nullptr);
  return values;
}

// Of every event by positions, velocities and time; returns how many events have derivatives.
std::size_t check_events(HostAt& at, bool time_too) {
  const auto size = static_cast<std::size_t>(at.position.size());
  const Eigen::VectorXd dp = random_vector(size, 1), dv = random_vector(size, 2), p = at.position, v = at.velocity;
  const double time = at.time;
  const auto values = [&](double h) {
    at.position = p + h * dp;
    at.velocity = v + h * dv;
    if (time_too) at.time = time + h;
    const Values found = event_values(at);
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(found.data(), static_cast<Eigen::Index>(found.size())));
  };
  const Eigen::VectorXd expected = difference(values);
  at.position = p;
  at.velocity = v;
  at.time = time;
  std::size_t count = 0;
  for (std::uint32_t e = 0; e < at.host.network().event_count; ++e) {
    Eigen::VectorXd by_position(p.size()), by_velocity(p.size());
    try {
      const double by_time = at.host.event_derivative(at.evaluation(), e, by_position.data(), by_velocity.data());
      const double rate = by_position.dot(dp) + by_velocity.dot(dv) + (time_too ? by_time : 0.0);
      CAPTURE(e);
      CHECK(std::abs(rate - expected[e]) <= of_differences * (1.0 + std::abs(rate)));
      ++count;
    } catch (const sdk::Failure& failure) {
      CHECK(std::string(failure.what()).find("derivatives are given of gaps and margins") != std::string::npos);
    }
  }
  return count;
}

}  // namespace

TEST_CASE("gaps of a plane that moves and turns, and of a sphere that swings") {
  Network net;
  for (NodeIndex k = 0; k < 5; ++k)
    net.add_node(point({0.4 * k, 0.3 * k * k, 1.0 + 0.2 * k}, 1.0, {0.1, -0.2, 0.3 * k}));
  Plane floor{"floor", Vector3::Zero(), {0.1, 0.2, 1.0}};
  floor.motion = Motion{};
  floor.motion->amplitude = {0.1, 0.2, 0.3};
  floor.motion->frequency = 1.5;
  floor.turn = Turn{};
  floor.turn->axis = {0.0, 1.0, 0.2};
  floor.turn->rate = 0.4;
  net.add_plane(floor);
  Instrument sphere;
  sphere.name = "sphere";
  sphere.first = sphere.second = {0.5, 4.0, 3.0};
  sphere.radius = 0.5;
  sphere.motion = Motion{};
  sphere.motion->amplitude = {0.3, 0.0, 0.2};
  sphere.motion->frequency = 1.0;
  net.add_instrument(sphere);
  HostAt at(net);
  at.time = 0.1;
  CHECK(check_events(at, true) == 10);
}

TEST_CASE("margins of springs and elements that may break, also by parameters") {
  for (const char* law : {"rupturing", "damaging"}) {
    CAPTURE(law);
    const bool damaging = std::string(law) == "damaging";
    Parametrised given;
    const char* const names[] = {damaging ? "breaking_damage" : "strength", "stiffness"};
    given.sets.resize(3);
    given.sets[0].set.kind = SPRINGNET_BY_REFERENCE;
    given.sets[0].values = {0.7, 0.8, 0.9, 0.75};
    for (std::size_t i = 0; i < 2; ++i) {
      given.sets[1 + i].set.kind = SPRINGNET_BY_SPRING_PARAMETER;
      given.sets[1 + i].set.parameter = names[i];
      for (std::size_t s = 0; s < 4; ++s)
        given.sets[1 + i].values.push_back(i == 0 && damaging ? 0.9 - 0.02 * static_cast<double>(s)
                                                              : (i == 0 ? 20.0 : 3.0) + static_cast<double>(s));
    }
    given.make = [=](const std::vector<Parametrised::Set>& sets) {
      Network net;
      const Eigen::VectorXd x = random_vector(30, 5);
      for (Eigen::Index k = 0; k < 5; ++k)
        net.add_node(
            point(Vector3(static_cast<double>(k), 0, 0) + 0.2 * x.segment<3>(6 * k), 1.0, x.segment<3>(6 * k + 3)));
      for (NodeIndex s = 0; s < 4; ++s) {
        LawUse use{law, {{names[0], sets[1].values[s]}, {names[1], sets[2].values[s]}}};
        if (damaging)
          use.parameters.merge(
              ParameterValues{{"threshold_strain", 0.05}, {"softening_strain", 0.5}, {"relaxation_time", 0.2}});
        net.add_spring(s, s + 1, net.add_material({use, std::nullopt}), sets[0].values[s]);
      }
      return net;
    };
    HostAt at(given.net());
    REQUIRE(at.host.network().event_count == 4);
    if (damaging)
      for (double& z : at.internal) z = 0.3;
    CHECK(check_events(at, false) == 4);
    for (std::uint32_t e = 0; e < 4; ++e) {
      std::vector<Values> by(3, Values(4, 0.0));
      std::vector<sdk::Host::ParameterSet> sets;
      for (std::size_t i = 0; i < 3; ++i) {
        sets.push_back(given.sets[i].set);
        sets.back().values = by[i];
      }
      static_cast<void>(at.host.event_derivative(at.evaluation(), e, nullptr, nullptr, sets));
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t s = 0; s < 4; ++s) {
          const Eigen::VectorXd expected = difference([&](double h) {
            std::vector<Parametrised::Set> moved = given.sets;
            moved[i].values[s] += h;
            HostAt other(given.make(moved));
            other.take_state(at);
            return Eigen::VectorXd(Eigen::VectorXd::Constant(1, event_values(other)[e]));
          });
          CHECK(std::abs(by[i][s] - expected[0]) <= of_differences);
          CHECK((s == e || by[i][s] == 0.0));
        }
    }
  }
}

TEST_CASE("margins of elements of every invariant that may break") {
  const Network plain = all_kinds(5);
  Network net;
  for (const Node& node : plain.nodes()) net.add_node(node);
  const MaterialIndex material =
      net.add_material({LawUse{"rupturing", {{"stiffness", 0.3}, {"strength", 40.0}}}, std::nullopt});
  for (const Element& element : plain.elements())
    net.add_element(element.invariant, element.nodes, material, element.reference);
  HostAt at(net);
  CHECK(check_events(at, false) == plain.elements().size());
}
