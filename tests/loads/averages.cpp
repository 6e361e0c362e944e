// Loads alone: their values in a step, at a time, on each node, against integrals in closed form.
#include <cmath>
#include <limits>
#include <numbers>

#include <doctest/doctest.h>

#include "../layers/random_net.hpp"
#include "loaded.hpp"
#include "simulation/loads.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double forever = std::numeric_limits<double>::infinity();
using LoadChange = Loads::Change;

// Nodes far apart, in an order that the engine changes.
Network points(std::uint32_t count) {
  Network net;
  for (std::uint32_t k = 0; k < count; ++k) net.add_node(point({static_cast<double>(k * 7 % count), 0, 0}));
  return net;
}

Load window(const Vector3& force, double from, double until, std::vector<NodeIndex> nodes = {0}) {
  return {std::move(nodes), force, from, until};
}

struct Loaded {
  explicit Loaded(const Network& network) : net(network), layout(net, *plugins(), true), loads(net, layout) {}
  // On a node of the user's, N.
  [[nodiscard]] Vector3 on(NodeIndex node) {
    const layers::ForceArrays force = loads.external().loads;
    const std::uint32_t k = layout.ordering().engine[node];
    return force.x == nullptr ? Vector3::Zero() : Vector3(force.x[k], force.y[k], force.z[k]);
  }
  Network net;
  layers::Layout layout;
  Loads loads;
};

}  // namespace

TEST_CASE("a load has the share of a step that lies in its window") {
  Network net = points(3);
  const Vector3 force(3, -1, 2);
  net.add_load(window(force, 1.0, 2.0, {2}));
  Loaded loaded(net);
  Loads& loads = loaded.loads;
  CHECK(loads.set_interval(0.0, 0.5) == LoadChange::none);
  CHECK(loaded.on(2) == Vector3::Zero());
  CHECK(loads.set_interval(0.75, 1.25) == LoadChange::switched);
  CHECK(loaded.on(2) == Vector3(0.5 * force));
  CHECK(loaded.on(0) == Vector3::Zero());
  CHECK(loads.set_interval(1.25, 1.5) == LoadChange::switched);
  CHECK(loaded.on(2) == force);
  CHECK(loads.set_interval(1.5, 1.75) == LoadChange::none);
  CHECK(loads.set_interval(0.0, 4.0) == LoadChange::switched);  // all of it within one step
  CHECK(loaded.on(2) == Vector3(0.25 * force));
  CHECK(loads.set_interval(2.0, 3.0) == LoadChange::switched);
  CHECK(loaded.on(2) == Vector3::Zero());
  // By the rounding of times steps end a little beside the window.
  CHECK(loads.set_interval(1.0 - 1e-13, 2.0 + 1e-13) == LoadChange::switched);
  CHECK(loaded.on(2) == force);
  CHECK(loads.set_interval(2.0 - 1e-13, 3.0) == LoadChange::switched);
  CHECK(loaded.on(2) == Vector3::Zero());
}

TEST_CASE("a step without a length, or without an end, has the loads right after its beginning") {
  Network net = points(1);
  net.add_load(window({1, 0, 0}, 1.0, 2.0));
  Loaded loaded(net);
  for (const double until : {1.0, 0.5, forever}) {
    loaded.loads.set_interval(1.0, until);
    CHECK(loaded.on(0).x() == 1.0);
    loaded.loads.set_interval(2.0, until);
    CHECK(loaded.on(0).x() == 0.0);
  }
}

TEST_CASE("averages of courses are their integrals, from the beginning of the window on") {
  Course ramp, sinusoid, table;
  ramp.ramp = 0.5;
  sinusoid.frequency = 0.4;
  sinusoid.phase = 0.3;
  sinusoid.mean = 0.2;
  sinusoid.amplitude = 1.5;
  table.times = {1.0, 2.0, 4.0};
  table.factors = {1.0, 3.0, -1.0};
  table.interpolation = Motion::Interpolation::linear;
  const double from = 1.0, until = 3.5;
  // Antiderivatives with respect to the time since the window began, or the simulation's.
  const auto of_ramp = [](double t) { return t < 1.5 ? (t - 1.0) * (t - 1.0) : 0.25 + (t - 1.5); };
  const auto of_sinusoid = [](double t) {
    const double rate = 2.0 * std::numbers::pi * 0.4;
    return 0.2 * t - 1.5 / rate * std::cos(rate * (t - 1.0) + 0.3);
  };
  const auto of_table = [](double t) {
    return t < 2.0 ? t - 1.0 + (t - 1.0) * (t - 1.0) : 2.0 + 3.0 * (t - 2.0) - (t - 2.0) * (t - 2.0);
  };
  const auto check = [&](const Course& course, auto&& integral) {
    Network net = points(1);
    Load load = window({0, 2, 0}, from, until);
    load.course = course;
    net.add_load(load);
    Loaded loaded(net);
    for (const auto& interval : {std::pair{0.5, 1.25}, {1.0, 1.5}, {1.25, 1.75}, {1.5, 3.0}, {3.0, 5.0}, {0.0, 8.0}}) {
      const double a = interval.first, b = interval.second;  // not bindings: Clang 14 cannot capture them in CAPTURE
      const double begin = std::max(a, from), end = std::min(b, until);
      loaded.loads.set_interval(a, b);
      CAPTURE(a);
      CHECK(loaded.on(0).y() == doctest::Approx(2.0 * (integral(end) - integral(begin)) / (b - a)).epsilon(1e-13));
    }
    // A load whose factor alone changes is varied, not switched.
    loaded.loads.set_interval(1.1, 1.2);
    CHECK(loaded.loads.set_interval(1.2, 1.3) == LoadChange::varied);
  };
  check(ramp, of_ramp);
  check(sinusoid, of_sinusoid);
  check(table, of_table);
}

TEST_CASE("instantaneous loads have their value at that time, and their mean again in the next step") {
  Network net = points(1);
  Load load = window({0, 0, 1}, 1.0, 2.0);
  load.course.ramp = 4.0;
  net.add_load(load);
  Loaded loaded(net);
  loaded.loads.begin_following(1.5);
  CHECK(loaded.on(0).z() == 0.125);
  loaded.loads.follow(1.75);
  CHECK(loaded.on(0).z() == 0.1875);
  loaded.loads.follow(2.0);
  CHECK(loaded.on(0).z() == 0.0);
  loaded.loads.set_interval(1.0, 2.0);
  CHECK(loaded.on(0).z() == 0.125);
  loaded.loads.follow(1.75);  // an average does not follow
  CHECK(loaded.on(0).z() == 0.125);
}

TEST_CASE("the next switch is the next beginning, end or kink, each once") {
  Network net = points(1);
  net.add_load(window({1, 0, 0}, 0.5, 3.0));
  Load ramp = window({1, 0, 0}, 1.0, 2.0);
  ramp.course.ramp = 0.25;
  net.add_load(ramp);
  Load table = window({1, 0, 0}, -forever, 2.5);
  table.course.times = {0.75, 4.0};
  table.course.factors = {1.0, 2.0};
  table.course.interpolation = Motion::Interpolation::linear;
  net.add_load(table);
  Loaded loaded(net);
  double time = -1.0;
  // Of the table what lies behind its window does not count.
  for (const double expected : {0.5, 0.75, 1.0, 1.25, 2.0, 2.5, 3.0, forever}) {
    time = loaded.loads.next_switch(time);
    CHECK(time == expected);
  }
}

TEST_CASE("loads, faces and the host's forces add up on a node, gravity is separate") {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(3, 0, 0), Vector3(0, 2, 0), Vector3(9, 9, 9)})
    net.add_node(point(p));
  net.set_gravity({0, 0, -9.81});
  net.add_load(window({1, 0, 0}, -forever, forever, {0, 3}));
  Load traction;
  traction.faces = {{0, 1, 2}};
  traction.traction = {0, 0, 2};
  traction.pressure = 5.0;
  net.add_load(traction);
  net.add_load(pressed({{0, 1, 2}}, 7.0, true));
  Loaded loaded(net);
  loaded.loads.set_interval(0.0, 1.0);
  // 3 m^2 of which each node has a third: the traction upward, a pressure of constant direction against the normal.
  CHECK((loaded.on(0) - Vector3(1, 0, 2.0 - 5.0)).norm() <= 1e-15);
  CHECK((loaded.on(1) - Vector3(0, 0, -3)).norm() <= 1e-15);
  CHECK(loaded.on(3) == Vector3(1, 0, 0));
  loaded.loads.set_host_force(loaded.layout.ordering().engine[3], {0, 4, 0});
  CHECK(loaded.on(3) == Vector3(1, 4, 0));
  loaded.loads.set_host_force(loaded.layout.ordering().engine[3], Vector3::Zero());
  CHECK(loaded.on(3) == Vector3(1, 0, 0));
  const layers::ExternalForces external = loaded.loads.external();
  CHECK(external.gravity == Vector3(0, 0, -9.81));
  REQUIRE(external.pressure != nullptr);
  CHECK(external.pressure[0] == 0.0);
  CHECK(external.pressure[1] == 0.0);
  CHECK(external.pressure[2] == 7.0);  // where the faces are then
  // One load's most on a node: 7 N of the following pressure beside 3 N and 1 N.
  CHECK(loaded.loads.greatest() == doctest::Approx(7.0).epsilon(1e-15));
  // The faces of the traction go, then those of the pressure.
  static_cast<void>(loaded.layout.remove_faces({0}));
  loaded.loads.faces_changed();
  CHECK(loaded.on(1) == Vector3::Zero());
}
