// Numbers at the limits of their precision: coordinates far from the origin, time steps longer than the simulation.

#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include <springnet/error.hpp>

#include "facts.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Network pair_at(double origin, double rest_length) {
  Network net;
  net.add_node(point({origin, 0, 0}));
  net.add_node(point({origin + 1.0, 0, 0}));
  net.add_spring(0, 1, net.add_material(damped(1.0, 0.0)), rest_length);
  return net;
}

// The message of refusal; empty if the network is accepted.
std::string refusal(const Network& net) {
  try {
    simulate(net, single_sweep(), 0.1);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("networks whose lengths are lost in the rounding of coordinates are refused") {
  CHECK(has_all(refusal(pair_at(1e20, 1.0)), {"spring 0", "node 0", "node 1", " 1 m", "1e+20 m", "1.6e+04 m"}));
  CHECK(has_all(refusal(pair_at(1e14, 1.0)), {"spring 0", "0.016 m"}));
  CHECK(refusal(pair_at(1e12, 1.0)).empty());
  // Only the rest length is lost.
  CHECK(refusal(pair_at(1e12, 1e-3)).find("spring 0") != std::string::npos);

  Network area;
  for (const Vector3& p : {Vector3(0, 1e14, 0), Vector3(1, 1e14, 0), Vector3(0, 1e14 + 1.0, 0)})
    area.add_node(point(p));
  area.add_element(Invariant::area, {0, 1, 2}, area.add_material(damped(1.0, 0.0)), 0.5);
  CHECK(has_all(refusal(area), {"element 0", "node 0", "node 1", " 1 m"}));

  // A rigid connection keeps its length to 1e-8 of it.
  Network rigid = chain(2, {1e9, 0, 0}, {1, 0, 0}, damped(1.0, 0.0));
  rigid.add_rigid(0, 1);
  CHECK(refusal(rigid).find("rigid connection from node 0 to node 1") != std::string::npos);
  Network near = chain(2, {1e6, 0, 0}, {1, 0, 0}, damped(1.0, 0.0));
  near.add_rigid(0, 1);
  CHECK(refusal(near).empty());
}

TEST_CASE("a time step longer than the simulation is shortened to its end") {
  for (const double time_step : {0.02, 1.0, 1e5, 1e9, 1e300}) {
    CAPTURE(time_step);
    const Network net = oscillator(damped(100.0, 0.0), 1.0, 0.1);
    Simulation simulation = simulate(net, recurrent(newton, 1e-9), time_step);
    simulation.advance_to(0.02);
    CHECK(simulation.steps() == 1);
    CHECK(simulation.time() == 0.02);
    CHECK(simulation.position(1)[0] == doctest::Approx(1.0 + 0.1 / (1.0 + 100.0 * 0.02 * 0.02)));  // backward Euler
    simulation.advance_to(0.05);
    CHECK(simulation.time() == 0.05);
  }
}

TEST_CASE("a difference of times within rounding makes no step") {
  Simulation simulation = simulate(oscillator(damped(100.0, 0.0), 1.0, 0.1), recurrent(newton, 1e-9), 0.1);
  simulation.advance_to(3 * 0.1);  // 0.30000000000000004
  CHECK(simulation.steps() == 3);
  simulation.advance_to(simulation.time() + 1e-9);
  CHECK(simulation.steps() == 3);
}

TEST_CASE("a cut waits for its time, however long the time step is") {
  Network net = oscillator(damped(100.0, 0.0), 1.0, 0.1);
  net.add_cut({0.5, {0}, {}});
  Simulation simulation = simulate(net, recurrent(newton, 1e-9), 1e12);
  CHECK(simulation.alive(0));
  simulation.advance_to(0.25);
  CHECK(simulation.alive(0));
  simulation.advance_to(1.0);
  CHECK_FALSE(simulation.alive(0));
}

TEST_CASE("times in messages have no rounding error; nan and infinity are spelled out") {
  const auto text_of = [](auto&& act) -> std::string {
    try {
      act();
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  const Network net = oscillator(damped(100.0, 0.0), 1.0, 0.1);
  for (const double wrong : {std::nan(""), -std::nan(""), HUGE_VAL}) {
    CAPTURE(wrong);
    Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.01);
    for (const std::string& text :
         {text_of([&] { simulation.advance_to(wrong); }), text_of([&] { simulate(net, single_sweep(), wrong); }),
          text_of([&] { simulation.move_node(0, Vector3::Zero(), wrong); })}) {
      CAPTURE(text);
      CHECK(text.find(std::isnan(wrong) ? "not a number" : "infinity") != std::string::npos);
      CHECK(text.find("nan s") == std::string::npos);
      CHECK(text.find("inf s") == std::string::npos);
    }
  }
  // 57 steps of 0.01 s end at 0.5700000000000001 s.
  Network late = net;
  late.add_load({{1}, {1e300, 0, 0}, 0.57});
  Simulation simulation = simulate(late, recurrent(synchronous, 1e-9), 0.01);
  CHECK(text_of([&] { simulation.advance_to(1.0); }).find("step from 0.57 s to 0.58 s: ") == 0);
}
