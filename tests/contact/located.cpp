// Located events in the network: steps that are divided where nodes touch, leave, and springs break or are cut.

#include <doctest/doctest.h>

#include <cmath>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

LawUse located(double update, double theta) { return recurrent(update, 1e-11, {{"theta", theta}, {"events", 1.0}}); }

// A node that falls, with springs to its sides of which one breaks and one is cut.
Network breaking() {
  Network net;
  Node left = point({-1, 0, 0}), right = point({1, 0, 0.1}), above = point({0.1, 0.2, 1});
  left.fixed = right.fixed = above.fixed = true;
  net.add_node(left);
  net.add_node(right);
  net.add_node(above);
  net.add_node(point({0, 0, 0}, 0.5));
  net.add_spring(0, 3, net.add_material(damped(20.0, 0.1)));
  net.add_spring(1, 3, net.add_material({LawUse{"rupturing", {{"stiffness", 20.0}, {"strength", 1.5}}}, std::nullopt}));
  net.add_spring(2, 3, net.add_material(damped(15.0, 0.1)));
  net.set_gravity({0, 0, -9.81});
  net.add_cut({0.3137, {2}, {}});
  return net;
}

}  // namespace

TEST_CASE("with located events a step keeps its order through touch and release") {
  const Friction rough{Friction::Kind::coulomb, 0.2};
  struct Example {
    std::string name;
    Network net;
    double until;  // s
  };
  for (const Example& example :
       {Example{"sphere", thrown_on_sphere(frictionless), 1.2}, Example{"rough sphere", thrown_on_sphere(rough), 1.2},
        Example{"capsule", thrown_on_capsule(frictionless), 1.2}, Example{"pair", thrown_pair(), 0.6},
        Example{"box", thrown_box(), 0.55}}) {
    const Truth truth(example.net, example.until);
    for (const double update : {newton, block, wavefront}) {
      for (const double theta : {1.0, 0.5}) {
        INFO(example.name << ", update " << update << ", theta " << theta);
        double error[3];
        for (const int halving : {0, 1, 2}) {
          const Run run = follow(truth, located(update, theta), 0.004 / (1 << halving));
          error[halving] = run.error;
          CHECK(run.pull <= 1e-9);
        }
        CAPTURE(error[0]);
        CAPTURE(error[1]);
        CAPTURE(error[2]);
        CHECK(0.5 * std::log2(error[0] / error[2]) > (theta == 1.0 ? 0.8 : 1.7));
      }
    }
  }
}

TEST_CASE("with located events a step keeps its order through rupture and cut") {
  const Network net = breaking();
  constexpr double until = 0.6;
  Simulation reference = simulate(net, cvode(1e-11), 0.1);
  reference.advance_to(until);
  REQUIRE(reference.events().size() == 2);
  for (const double update : {newton, block}) {
    double error[3];
    for (const int halving : {0, 1, 2}) {
      Simulation s = simulate(net, located(update, 0.5), 0.004 / (1 << halving));
      s.advance_to(until);
      error[halving] = distance(s, reference);
      REQUIRE(s.events().size() == 2);
      for (const std::size_t i : {0u, 1u})
        CHECK(std::abs(s.events()[i].time - reference.events()[i].time) <= 10.0 * 0.004 * 0.004);
    }
    CAPTURE(error[0]);
    CAPTURE(error[2]);
    CHECK(0.5 * std::log2(error[0] / error[2]) > 1.7);
  }
}
