// Touches between the ends of steps: thin obstacles, arcs that just reach a surface, what swings and turns fast. All
// integrators find them; those that locate events find their times.

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct Thin {
  std::string name;
  Network net;
  double until;      // s
  double touch;      // s, the first
  Vector3 velocity;  // m/s, right after it
};

// 3 mm a step through a plate of 2 mm.
Thin plate() {
  Thin scene{"plate", {}, 0.5, 0.0095 / 0.3, Vector3::Zero()};
  scene.net.add_node(point({0, 0, 0.0105}, 1.0, {0, 0, -0.3}));
  Instrument box;
  box.box = BoxShape{{1, 1, 0.002}, Eigen::Matrix3d::Identity(), 0.0};
  scene.net.add_instrument(box);
  return scene;
}

// 10 cm a step past the side of a bead of 1 cm.
Thin bead() {
  Thin scene{"bead", {}, 0.5, 0.2997, {-6.4, 4.8, 0}};
  scene.net.add_node(point({3, 0.004, 0}, 1.0, {-10, 0, 0}));
  Instrument sphere;
  sphere.radius = 0.005;
  sphere.friction = frictionless;
  scene.net.add_instrument(sphere);
  return scene;
}

// The top of its arc is 0.1 mm above the ceiling.
Thin ceiling() {
  const double before = std::sqrt(2e-4);  // s, of the top
  Thin scene{"ceiling", {}, 1.5, 1.0 - before, {1, 0, 0}};
  scene.net.add_node(point({0, 0, 0}, 1.0, {1, 0, 1}));
  scene.net.set_gravity({0, 0, -1});
  Plane plane;
  plane.point = {0, 0, 0.4999};
  plane.normal = {0, 0, -1};
  plane.friction = frictionless;
  scene.net.add_plane(plane);
  return scene;
}

// A blade 1 cm thick that turns at 20 rad/s strikes what rests: as its face moves there.
Thin blade() {
  const double arm = std::hypot(1.0, 0.3), thin = std::asin(0.005 / arm);
  Thin scene{"blade", {}, 0.145, (std::numbers::pi - std::atan(0.3) - thin) / 20.0, {}};
  const double angle = 20.0 * scene.touch, along = std::sqrt(arm * arm - 0.005 * 0.005);
  scene.velocity = 20.0 * along * Vector3(std::sin(angle), -std::cos(angle), 0);
  scene.net.add_node(point({1, 0, 0}));
  Instrument box;
  box.box = BoxShape{{2.2, 0.01, 0.5}, Eigen::Matrix3d::Identity(), 0.0};
  box.first = box.second = {0, 0.3, 0};
  box.friction = frictionless;
  box.turn.emplace();
  box.turn->rate = 20.0;
  scene.net.add_instrument(box);
  return scene;
}

// Only the top of a fast swing comes so high. The first one: what rests is not stepped with.
Thin shaker() {
  constexpr double rate = 2.0 * std::numbers::pi * 50.0;
  Thin scene{"shaker", {}, 0.3, std::asin(0.995) / rate, {}};
  scene.velocity = {0, 0, 0.01 * rate * std::cos(rate * scene.touch)};
  scene.net.add_node(point({0, 0, 0.00995}));
  Plane plane;
  plane.friction = frictionless;
  plane.motion.emplace();
  plane.motion->amplitude = {0, 0, 0.01};
  plane.motion->frequency = 50.0;
  scene.net.add_plane(plane);
  return scene;
}

Simulation to_end(const Thin& scene, const LawUse& integrator) {
  Simulation s = simulate(scene.net, integrator, 0.01);
  s.advance_to(scene.until);
  return s;
}

double first_touch(const Simulation& s) {
  for (const Event& event : s.events())
    if (event.kind == Event::Kind::touched) return event.time;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

TEST_CASE("a node that enters and leaves an obstacle within a step touches it, at the right time") {
  for (const Thin& scene : {plate(), bead(), ceiling(), blade(), shaker()}) {
    INFO(scene.name);
    for (const double tolerance : {1e-7, 1e-10}) {
      CAPTURE(tolerance);
      const Simulation s = to_end(scene, cvode(tolerance));
      const Event* touch = nullptr;
      for (const Event& event : s.events())
        if (touch == nullptr && event.kind == Event::Kind::touched) touch = &event;
      REQUIRE(touch != nullptr);
      // How far it goes towards the surface in that time; its mass is 1 kg.
      CHECK(std::abs(touch->time - scene.touch) * touch->impulse.norm() <= 1e2 * tolerance);
      const Vector3 before = scene.net.nodes()[0].velocity + touch->time * scene.net.gravity();
      CHECK((before + touch->impulse - scene.velocity).norm() <= 1e-4 * (1.0 + before.norm()));
    }
    for (const double theta : {1.0, 0.5}) {
      CAPTURE(theta);
      const Simulation s = to_end(scene, recurrent(newton, 1e-11, {{"events", 1.0}, {"theta", theta}}));
      // Backward Euler stays 5 mm below the top of the arc: it never reaches the ceiling.
      if (scene.name == "ceiling" && theta == 1.0)
        CHECK(std::isnan(first_touch(s)));
      else
        CHECK(first_touch(s) == doctest::Approx(scene.touch).epsilon(1e-6));
    }
  }
}

TEST_CASE("integrators that decide contact within a step stop at thin obstacles") {
  for (const Thin& scene : {plate(), bead()}) {
    INFO(scene.name);
    for (const LawUse& integrator :
         {recurrent(newton, 1e-11), recurrent(block, 1e-11), LawUse{"verlet", {}}, generalized_alpha()}) {
      INFO(integrator.id);
      CHECK(std::abs(first_touch(to_end(scene, integrator)) - scene.touch) <= 0.01);  // the end of its step
    }
  }
}

TEST_CASE("the time of a touch within a step does not depend on where outputs are") {
  for (const Thin& scene : {bead(), ceiling(), blade()}) {
    INFO(scene.name);
    const double whole = first_touch(to_end(scene, cvode(1e-8)));
    Simulation s = simulate(scene.net, cvode(1e-8), 0.01);
    for (double time = 0.0037; time < scene.until; time += 0.0037) s.advance_to(time);
    // Where an output falls into an obstacle CVODE itself finds the touch, to a hundred roundings of its step.
    CHECK(std::abs(first_touch(s) - whole) <= 1e-12);
  }
}

TEST_CASE("a node that passes by an obstacle does not touch it") {
  Thin past = plate();
  past.net = Network{};
  past.net.add_node(point({0.6, 0, 0.0105}, 1.0, {0, 0, -0.3}));
  Thin above = bead();
  above.net = Network{};
  above.net.add_node(point({3, 0.00501, 0}, 1.0, {-10, 0, 0}));
  for (Thin* scene : {&past, &above}) {
    const Thin full = scene == &past ? plate() : bead();
    for (const Instrument& instrument : full.net.instruments()) scene->net.add_instrument(instrument);
    INFO(scene->name);
    for (const LawUse& integrator : {cvode(1e-8), recurrent(newton, 1e-11, {{"events", 1.0}}), recurrent(newton, 1e-11),
                                     LawUse{"verlet", {}}, generalized_alpha()})
      CHECK(std::isnan(first_touch(to_end(*scene, integrator))));
  }
}

TEST_CASE("the cost of an obstacle that turns about its own axis does not grow with its rate") {
  const auto roots = [](double rate) {
    Network net;
    net.add_node(point({0.3, 0, 0.5}, 1.0, {0.1, 0, 0}));
    net.set_gravity({0, 0, -1});
    Plane table;
    table.friction = frictionless;
    table.turn.emplace();
    table.turn->rate = rate;
    net.add_plane(table);
    Instrument drill;
    drill.second = {0, 0, 1};
    drill.radius = 0.1;
    drill.friction = frictionless;
    drill.turn = table.turn;
    net.add_instrument(drill);
    Simulation s = simulate(net, cvode(1e-8), 0.5);
    s.advance_to(2.0);
    CHECK(first_touch(s) == doctest::Approx(1.0).epsilon(1e-7));
    return s.statistics().at("internal_steps");
  };
  CHECK(roots(1e9) <= roots(1.0));
}
