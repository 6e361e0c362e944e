// What integrators keep, their dense output, and what they declare: optional parts of springnet_integrator.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include <springnet/error.hpp>

#include "probe.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

class Floating : public Probe {
 public:
  using Probe::Probe;
  static constexpr const char* id = "floating";
  static constexpr bool without_contact = true;
  static constexpr bool without_rigid = true;
};

Network thrown_body() {
  Network net = cube(200.0, 0.5, 9.81, 0.3);
  Node node = net.nodes()[5];
  node.velocity = {1.0, -0.5, 0.2};
  net.set_node(5, node);
  return net;
}

bool same(const Simulation& a, const Simulation& b) {
  return a.positions() == b.positions() && a.velocities() == b.velocities();
}

}  // namespace

TEST_CASE("with its memory an integrator goes on with the same bits, without it with others") {
  const Network net = thrown_body();
  Simulation whole = simulate(net, generalized_alpha(0.5), 0.004);
  Simulation restored = simulate(net, generalized_alpha(0.5), 0.004);
  Simulation forgotten = simulate(net, generalized_alpha(0.5), 0.004);
  std::string memory;
  for (int i = 0; i < 120; ++i) {  // lands after some 60
    if (i == 30 || i == 90) {
      memory = restored.integrator_memory();
      restored.drop_history();
      restored.set_integrator_memory(memory);
      forgotten.drop_history();
    }
    for (Simulation* each : {&whole, &restored, &forgotten}) each->step();
    if (i == 31) CHECK_FALSE(same(whole, forgotten));
    CHECK(same(whole, restored));
  }
  CHECK(whole.nodes_touching(0) > 0);

  // What is not its own is refused, and then it has none.
  const auto refused = [&](const std::string& bytes) {
    CHECK_THROWS_AS(restored.set_integrator_memory(bytes), Error);
    Simulation fresh = simulate(net, generalized_alpha(0.5), 0.004);
    CHECK_THROWS_AS(fresh.set_integrator_memory(bytes), Error);
    fresh.step();
    Simulation untouched = simulate(net, generalized_alpha(0.5), 0.004);
    untouched.step();
    CHECK(same(fresh, untouched));
  };
  refused(memory.substr(0, memory.size() - 1));
  refused(memory + "x");
  refused("");
  refused("other@test 1\n" + memory);
  Simulation stiffer = simulate(net, generalized_alpha(0.8), 0.004);
  CHECK_THROWS_WITH_AS(stiffer.set_integrator_memory(memory), doctest::Contains("another spectral_radius"), Error);
  Simulation verlet = simulate(net, {"verlet", {}}, 0.004);
  CHECK(verlet.integrator_memory().empty());
  CHECK_THROWS_WITH_AS(verlet.set_integrator_memory(memory), doctest::Contains("takes up no memory"), Error);
}

TEST_CASE("dense output: the cubic through both ends of the last step, and nothing elsewhere") {
  const double omega = 3.0, h = 0.1;
  Simulation s = simulate(oscillator(damped(omega * omega, 0.0), 1.0, 0.25), generalized_alpha(1.0), h);
  CHECK_FALSE(s.between(0.0));
  for (int i = 0; i < 5; ++i) {
    const Eigen::Matrix3Xd p = s.positions(), v = s.velocities();
    s.step();
    const double from = h * i, middle = h * (i + 0.5), until = s.time();
    const auto start = s.between(from), end = s.between(until), half = s.between(middle);
    REQUIRE(start);
    REQUIRE(end);
    REQUIRE(half);
    CHECK((start->positions - p).norm() <= 1e-14);
    CHECK((start->velocities - v).norm() <= 1e-13);
    CHECK((end->positions - s.positions()).norm() <= 1e-14);
    CHECK((end->velocities - s.velocities()).norm() <= 1e-13);
    CHECK((half->positions - 0.5 * (p + s.positions()) - h / 8.0 * (v - s.velocities())).norm() <= 1e-14);
    CHECK((half->velocities - 1.5 / h * (s.positions() - p) + 0.25 * (v + s.velocities())).norm() <= 1e-13);
    CHECK_FALSE(s.between(from - 0.01));
    CHECK_FALSE(s.between(until + 0.01));
  }
  const double until = s.time();
  s.set_position(1, {0.7, 0, 0});
  CHECK(s.between(until)->positions == s.positions());
  CHECK_FALSE(s.between(until - 0.1 * h));  // the end of that step is gone
  s.drop_history();
  CHECK_FALSE(s.between(s.time()));
  Simulation without = simulate(oscillator(damped(9.0, 0.0), 1.0, 0.25), {"verlet", {}}, h);
  without.step();
  CHECK_FALSE(without.between(0.5 * h));
}

TEST_CASE("dense output of cvode is the state that it would have committed there, with events and jumps of loads") {
  Network net = oscillator(damped(9.0, 0.3), 1.0, 0.25, 0.4);
  net.add_load({{1}, {0, 0.5, -2.0}, 0.6, 1.3});
  net.add_plane({"floor", {0, 0, -0.3}, {0, 0.1, 1}});
  for (const double method : {0.0, 1.0}) {
    CAPTURE(method);
    const double h = 0.25;
    Simulation s = simulate(net, cvode(1e-9, {{"method", method}, {"dense_output", 1.0}}), h);
    Simulation fine = simulate(net, cvode(1e-9, {{"method", method}}), h / 32.0);
    Simulation plain = simulate(net, cvode(1e-9, {{"method", method}}), h);
    CHECK_FALSE(s.between(0.0));
    for (int i = 0; i < 8; ++i) {
      s.step();
      plain.step();
      CHECK(s.positions() == plain.positions());  // what is kept changes nothing
      for (int k = 1; k <= 32; ++k) {
        fine.step();
        const auto there = s.between(fine.time());
        REQUIRE(there);
        // The same polynomials, by their derivatives in place of differences: rounding.
        CHECK((there->positions - fine.positions()).norm() <= 1e-13);
        CHECK((there->velocities - fine.velocities()).norm() <= 1e-12);
      }
      CHECK_FALSE(s.between(s.time() - 1.01 * h));
      CHECK_FALSE(s.between(s.time() + 1e-6));
    }
    CHECK(s.events().size() > 0);
    s.drop_history();
    CHECK_FALSE(s.between(s.time()));
    CHECK_FALSE(plain.between(plain.time()));
  }
}

TEST_CASE("an integrator that declares to be without contact or rigid connections is refused where there are any") {
  const auto with = [](const Network& net) {
    SimulationOptions options;
    options.integrator = {"floating", {}};
    options.time_step = 0.1;
    return Simulation(net, plugins_with<Floating>(), options);
  };
  task() = [](const sdk::Host&) {};
  Network net;
  net.add_node(point({0, 0, 1}));
  net.add_node(point({1, 0, 1}));
  CHECK_NOTHROW(with(net).step());
  Network bound = net;
  bound.add_rigid(0, 1);
  CHECK_THROWS_WITH_AS(with(bound), doctest::Contains("'floating' does not handle rigid connections"), Error);
  net.add_plane({.name = "floor"});
  CHECK_THROWS_WITH_AS(with(net), doctest::Contains("'floating' does not handle contact"), Error);
}
