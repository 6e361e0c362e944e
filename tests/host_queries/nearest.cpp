// The nearest node and spring.

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("nearest node and spring are those that a search by hand finds") {
  const Network net = cube(3.0, 2.0, 0.2, 0.02);
  Simulation simulation = simulate(net, recurrent(newton, 1e-10), 0.05);
  simulation.advance_to(1.0);
  simulation.cut({0, 1, 2, 30, 31, 100});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1.0, 4.0);
  for (int k = 0; k < 200; ++k) {
    const Vector3 point(coordinate(random), coordinate(random), coordinate(random));
    const std::optional<NodeIndex> node = simulation.nearest_node(point);
    REQUIRE(node);
    double least = std::numeric_limits<double>::infinity();
    for (NodeIndex n = 0; n < 64; ++n) least = std::min(least, (simulation.position(n) - point).norm());
    CHECK((simulation.position(*node) - point).norm() == least);
    const std::optional<NearestSpring> spring = simulation.nearest_spring(point);
    REQUIRE(spring);
    CHECK(simulation.alive(spring->spring));
    const Spring found = net.springs()[spring->spring];
    const Vector3 a = simulation.position(found.first), b = simulation.position(found.second);
    CHECK((a + spring->along * (b - a) - spring->point).norm() < 1e-14);
    CHECK(spring->distance == doctest::Approx((spring->point - point).norm()).epsilon(1e-14));
    // No point of any spring is nearer.
    for (SpringIndex s = 0; s < net.springs().size(); ++s) {
      if (!simulation.alive(s)) continue;
      const Vector3 from = simulation.position(net.springs()[s].first),
                    to = simulation.position(net.springs()[s].second);
      for (int i = 0; i <= 16; ++i) CHECK((from + i / 16.0 * (to - from) - point).norm() >= spring->distance - 1e-14);
    }
  }
}

TEST_CASE("of nodes and springs that are equally near the lowest number counts") {
  Network net;
  for (int k = 0; k < 6; ++k) net.add_node(point({std::cos(k * M_PI / 3), std::sin(k * M_PI / 3), 0}));
  for (NodeIndex k = 0; k < 6; ++k) net.set_node(k, point({k % 2 == 0 ? 1.0 : -1.0, k < 3 ? 1.0 : -1.0, 0}));
  const MaterialIndex material = net.add_material(damped(1.0, 0.0));
  net.add_spring(0, 1, material);
  net.add_spring(1, 0, material);
  net.add_spring(0, 4, material, 1.0);
  Simulation simulation = simulate(net, recurrent(newton, 1e-10), 0.05);
  CHECK(simulation.nearest_node({0, 0, 0}) == NodeIndex{0});
  CHECK(simulation.nearest_node({-2, -0.1, 0}) == NodeIndex{3});
  CHECK(simulation.nearest_spring({0, 1.5, 0})->spring == 0);
  simulation.cut({0});
  CHECK(simulation.nearest_spring({0, 1.5, 0})->spring == 1);
  CHECK(simulation.nearest_spring({0, 1.5, 0})->along == 0.5);
  simulation.cut({1, 2});
  CHECK_FALSE(simulation.nearest_spring({0, 1.5, 0}));
}

TEST_CASE("points that are not finite are refused") {
  const Simulation simulation = simulate(cube(3.0, 2.0, 0.2, 0.02), recurrent(newton, 1e-10), 0.05);
  const Vector3 bad(0, std::nan(""), 0);
  CHECK_THROWS_AS(static_cast<void>(simulation.nearest_node(bad)), Error);
  CHECK_THROWS_AS(static_cast<void>(simulation.nearest_spring(bad)), Error);
  CHECK_THROWS_AS(static_cast<void>(simulation.cast_ray(bad, {1, 0, 0})), Error);
  CHECK_THROWS_AS(static_cast<void>(simulation.cast_ray({0, 0, 0}, bad)), Error);
  CHECK_THROWS_AS(static_cast<void>(simulation.cast_ray({0, 0, 0}, {0, 0, 0})), Error);
}
