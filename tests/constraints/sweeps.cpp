// Contact within the sweeps of the recurrent network against closed forms: leaving curved surfaces, the cone of
// friction, edges between surfaces, rebounds, and events that divide a time step.

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "constraints/edge.hpp"
#include "schemes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

std::vector<Scheme> network_schemes(double force_tolerance) {
  std::vector<Scheme> schemes = stepping_schemes(force_tolerance);
  schemes.resize(schemes.size() - 2);  // verlet, generalized_alpha
  return schemes;
}

Plane plane_at(const Vector3& point, const Vector3& normal, const Friction& friction) {
  Plane plane;
  plane.point = point;
  plane.normal = normal;
  plane.friction = friction;
  return plane;
}

// From rest, 0.1 m beside the top of a fixed sphere of 1 m, gravity 1 m/s^2.
Network on_sphere() {
  Network net;
  net.add_node(point({0.1, 0, 0.99498743710662}, 2.0));
  net.set_gravity({0, 0, -1});
  Instrument sphere;
  sphere.friction = frictionless;
  sphere.radius = 1.0;
  net.add_instrument(sphere);
  return net;
}
// It leaves where its height is 2/3 of that at the start: the integral of dphi / sqrt(2 (cos phi_0 - cos phi)) up to
// there, s.
constexpr double sphere_release_time = 2.839490494;

std::size_t count(const Simulation& simulation, Event::Kind kind) {
  return static_cast<std::size_t>(std::count_if(simulation.events().begin(), simulation.events().end(),
                                                [kind](const Event& event) { return event.kind == kind; }));
}

// Greatest errors against `truth` with h, h/2, h/4.
std::vector<double> errors(const Network& net, LawUse integrator, bool located, double h, double until,
                           const Simulation& truth) {
  integrator.parameters["events"] = located ? 1.0 : 0.0;
  std::vector<double> result;
  for (int i = 0; i < 3; ++i) {
    Simulation s = simulate(net, integrator, h / (1 << i));
    s.advance_to(until);
    result.push_back(distance(s, truth));
  }
  return result;
}

}  // namespace

TEST_CASE("a sliding node leaves a sphere once, in the step in which its reaction vanishes, and is never pulled") {
  for (const Scheme& scheme : network_schemes(1e-10)) {
    for (const double h : {0.004, 0.002, 0.001}) {
      INFO(scheme.name << ", " << h);
      Simulation s = simulate(on_sphere(), scheme.integrator, h);
      double left = 0.0, pull = 0.0;
      while (s.time() < 3.0 - 0.5 * h) {
        s.step();
        pull = std::max(pull, -s.reaction(0).dot(s.position(0).normalized()));
        if (left == 0.0 && !s.touching(0)) left = s.time();
      }
      CHECK(pull <= 1e-8);
      CHECK(count(s, Event::Kind::released) == 1);
      // Backward Euler's node is faster by first order in h.
      CHECK(std::abs(left - sphere_release_time) <= (scheme.order == 1.0 ? 1.5 * h : h));
    }
  }
}

TEST_CASE("nodes leave a plane that rises and stops abruptly, held ones too") {
  for (const auto kind : {Friction::Kind::held, Friction::Kind::none, Friction::Kind::coulomb}) {
    Network net;
    net.add_node(point(Vector3::Zero(), 0.5));
    net.set_gravity({0, 0, -10});
    Plane plane = plane_at(Vector3::Zero(), Vector3::UnitZ(), {kind, kind == Friction::Kind::coulomb ? 0.5 : 0.0});
    plane.motion.emplace();
    plane.motion->interpolation = Motion::Interpolation::linear;
    plane.motion->times = {0.0, 0.375};
    plane.motion->displacements = {Vector3::Zero(), {0, 0, 0.375}};
    net.add_plane(plane);
    for (const Scheme& scheme : network_schemes(1e-10)) {
      // With the stop where a step ends, and within one.
      for (const double h : {0.005, 0.0043}) {
        INFO(scheme.name << ", " << h);
        Simulation s = simulate(net, scheme.integrator, h);
        double top = 0.0;
        while (s.time() < 0.6) {
          s.step();
          top = std::max(top, s.position(0).z());
        }
        // 1 m/s rises by 0.05 m against 10 m/s^2; the step of the stop is of first order.
        CHECK(top == doctest::Approx(0.425).epsilon(0.02));
        CHECK(count(s, Event::Kind::released) == 1);
      }
    }
  }
}

TEST_CASE("the cone of friction is as wide as its coefficient, to a per cent") {
  // On a slope of 0.3 a node with friction 0.303 stays, with 0.297 it slides.
  for (const Scheme& scheme : network_schemes(1e-10)) {
    for (const double coefficient : {0.303, 0.297}) {
      INFO(scheme.name << ", " << coefficient);
      Network net;
      net.add_node(point(Vector3::Zero(), 0.7));
      net.add_node(point({0, 0.5, 0}, 0.3));
      net.add_spring(0, 1, net.add_material(damped(200.0, 3.0)), 0.5);
      net.set_gravity({3, 0, -10});
      net.add_plane(plane_at(Vector3::Zero(), Vector3::UnitZ(), {Friction::Kind::coulomb, coefficient}));
      Simulation s = simulate(net, scheme.integrator, 0.01);
      s.advance_to(1.0);
      const double slide = s.position(0).x();
      if (coefficient > 0.3)
        CHECK(slide <= 1e-12);
      else
        CHECK(slide == doctest::Approx(0.5 * 0.03).epsilon(0.02));
    }
  }
}

TEST_CASE("reactions of two obstacles on a node where they meet") {
  const Vector3 a = Vector3::UnitZ(), b = Vector3::UnitX();
  Eigen::Matrix3d mobility = Eigen::Matrix3d::Identity() / 2.0;
  const Vector3 relative(-3, 5, -4);
  SUBCASE("without friction it keeps what it has along the edge") {
    const EdgeResponse answer = solve_edge(mobility, relative, a, b, 0.0, 0.0);
    CHECK((answer.velocity - Vector3(0, 5, 0)).norm() <= 1e-15);
    CHECK(answer.first == doctest::Approx(8.0));
    CHECK(answer.second == doctest::Approx(6.0));
    CHECK_FALSE(answer.sticks);
  }
  SUBCASE("friction sums up") {
    const EdgeResponse slips = solve_edge(mobility, relative, a, b, 0.5, 0.9);
    CHECK(slips.velocity.y() == doctest::Approx(5.0 - 0.5 * (0.5 * 8.0 + 0.9 * 6.0)));
    CHECK_FALSE(slips.sticks);
    const EdgeResponse sticks = solve_edge(mobility, relative, a, b, 0.5, 1.01);
    CHECK(sticks.sticks);
    CHECK(sticks.velocity.norm() == 0.0);
    CHECK_FALSE(solve_edge(mobility, relative, a, b, 0.5, 0.99).sticks);
  }
  SUBCASE("an obstacle that would have to pull is reported") {
    const EdgeResponse answer = solve_edge(mobility, {3, 5, -4}, a, b, 0.0, 0.0);
    CHECK(answer.first > 0.0);
    CHECK(answer.second < 0.0);
  }
  SUBCASE("normals at an angle, and mobility with directions of its own") {
    mobility << 2, 0.3, 0.1, 0.3, 1, 0.2, 0.1, 0.2, 0.5;
    const Vector3 c = Vector3(1, 0.2, 1).normalized();
    for (const double friction : {0.0, 0.2}) {
      const EdgeResponse answer = solve_edge(mobility, {-1, 0.5, -2}, a, c, friction, 0.0);
      CHECK(std::abs(a.dot(answer.velocity)) <= 1e-14);
      CHECK(std::abs(c.dot(answer.velocity)) <= 1e-14);
      CHECK((mobility * answer.impulse + Vector3(-1, 0.5, -2) - answer.velocity).norm() <= 1e-14);
      const Vector3 e = a.cross(c).normalized();
      CHECK(std::abs(e.dot(answer.impulse)) == doctest::Approx(friction * answer.first));
      CHECK(e.dot(answer.impulse) * e.dot(answer.velocity) <= 0.0);
    }
  }
}

TEST_CASE("a node slides on along the edge of two surfaces, braked by both") {
  for (const double rough : {0.0, 0.2}) {
    const Friction floor{rough > 0.0 ? Friction::Kind::coulomb : Friction::Kind::none, rough};
    Network net;
    net.add_node(point({0.2, 0, 0}, 0.5, {-1, 2, 0}));
    net.set_gravity({-3, 0, -4});
    net.add_plane(plane_at(Vector3::Zero(), Vector3::UnitZ(), floor));
    net.add_plane(plane_at(Vector3::Zero(), Vector3::UnitX(), frictionless));
    for (const Scheme& scheme : network_schemes(1e-10)) {
      INFO(scheme.name << ", " << rough);
      Simulation s = simulate(net, scheme.integrator, 0.002);
      s.advance_to(0.3);
      CHECK(s.touching(0));
      CHECK(std::abs(s.position(0).x()) <= 1e-12);
      CHECK(std::abs(s.position(0).z()) <= 1e-12);
      // From there on the floor alone rubs: 0.2 of 4 m/s^2.
      const double y = s.position(0).y(), v = s.velocity(0).y();
      s.advance_to(0.8);
      CHECK(s.velocity(0).y() == doctest::Approx(v - 0.5 * rough * 4.0).epsilon(1e-6));
      CHECK(s.position(0).y() == doctest::Approx(y + 0.5 * v - 0.125 * rough * 4.0).epsilon(2e-3));
      CHECK(count(s, Event::Kind::touched) == 2);
    }
  }
}

TEST_CASE("a node rebounds with its surface's coefficient, and comes to rest") {
  Network net;
  net.add_node(point({0, 0, 0.5}, 1.0, {0.4, 0, 0}));
  net.set_gravity({0, 0, -10});
  Plane plane = plane_at(Vector3::Zero(), Vector3::UnitZ(), frictionless);
  plane.restitution = 0.6;
  net.add_plane(plane);
  for (const Scheme& scheme : network_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, 0.0005);
    double top = 0.0;
    while (s.time() < 0.7) {
      s.step();
      if (s.time() > 0.33) top = std::max(top, s.position(0).z());
    }
    CHECK(top == doctest::Approx(0.36 * 0.5).epsilon(0.02));
    s.advance_to(2.0);
    CHECK(s.touching(0));
    CHECK(std::abs(s.position(0).z()) <= 1e-12);
    CHECK(s.velocity(0).x() == doctest::Approx(0.4));
  }
}

TEST_CASE("events that divide the time step leave theta 1/2 of second order") {
  struct Example {
    const char* name;
    Network net;
    double until, h;
  };
  std::vector<Example> examples;
  examples.push_back({"leaving a sphere", on_sphere(), 3.0, 0.02});
  {
    Network net;  // a pair falls on a plane
    net.add_node(point({0, 0, 0.5}, 1.0, {0.3, 0, -1}));
    net.add_node(point({0, 0, 1.7}, 1.5, {0, 0.1, -1.2}));
    net.add_spring(0, 1, net.add_material(damped(60.0, 0.3)), 1.0);
    net.set_gravity({0, 0, -4});
    net.add_plane(plane_at(Vector3::Zero(), Vector3::UnitZ(), frictionless));
    examples.push_back({"touch", net, 0.6, 0.02});
    Network torn = net;
    Cut cut;
    cut.time = 0.2137;
    cut.springs = {0};
    torn.add_cut(cut);
    examples.push_back({"cut", torn, 0.35, 0.02});
  }
  {
    Network net =
        oscillator({LawUse{"rupturing", {{"stiffness", 20.0}, {"strength", 4.0}}}, std::nullopt}, 0.5, 0.0, 2.0);
    examples.push_back({"rupture", net, 0.5, 0.02});
  }
  for (const Example& example : examples) {
    Simulation truth = simulate(example.net, cvode(1e-11), example.h);
    truth.advance_to(example.until);
    for (const double rule : {synchronous, block, newton}) {
      INFO(example.name << ", " << rule);
      const auto second =
          errors(example.net, recurrent(rule, 1e-11, {{"theta", 0.5}}), true, example.h, example.until, truth);
      CAPTURE(second[0]);
      CAPTURE(second[1]);
      CAPTURE(second[2]);
      CHECK(std::log2(second[0] / second[1]) == doctest::Approx(2.0).epsilon(0.06));
      CHECK(std::log2(second[1] / second[2]) == doctest::Approx(2.0).epsilon(0.06));
      const auto first = errors(example.net, recurrent(rule, 1e-11), true, example.h, example.until, truth);
      CHECK(std::log2(first[1] / first[2]) == doctest::Approx(1.0).epsilon(0.15));
    }
  }
}
