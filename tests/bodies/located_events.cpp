// Contact of bodies whose events are located: many events, moved and changed bodies, what goes on in other ways.

#include <doctest/doctest.h>

#include <cmath>

#include <springnet/error.hpp>
#include <springnet/events.hpp>

#include "bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {}  // namespace

TEST_CASE("the reference: springs between balls, a cradle") {
  // Rods of two balls with a spring: the first is struck, its momentum passes on. Energy and momentum are kept.
  Network net;
  const MaterialIndex material = net.add_material(damped(2000.0, 0.0));
  for (int i = 0; i < 3; ++i) {
    net.begin_body("rod " + std::to_string(i));
    const NodeIndex first = net.add_node(point({0.6 * i + (i > 0 ? 0.1 : 0.0), 0, 0}, 0.2, {i == 0 ? 1.0 : 0.0, 0, 0}));
    const NodeIndex second =
        net.add_node(point({0.6 * i + 0.3 + (i > 0 ? 0.1 : 0.0), 0, 0}, 0.2, {i == 0 ? 1.0 : 0.0, 0, 0}));
    net.add_spring(first, second, material);
    net.end_body();
    net.set_extent(net.bodies().size() - 1, 0.0, 0.1);
  }
  touch_all(net, frictionless, 1.0);
  Simulation s = simulate(net, reference(), 0.01);
  const double energy = s.kinetic_energy() + s.potential_energy();
  const Vector3 p = momentum(net, s);
  advance(s, 300);
  CHECK(count_events(s).met >= 2);
  CHECK(s.kinetic_energy() + s.potential_energy() == doctest::Approx(energy).epsilon(1e-7));
  CHECK((momentum(net, s) - p).norm() <= 1e-12);
}

TEST_CASE("the reference: a block on a block, with and without friction, on an incline that has none") {
  // Whatever the two do to each other, the sum of their momenta is that of gravity along the incline.
  for (const double mu : {0.0, 0.3}) {
    CAPTURE(mu);
    Network net;
    add_block(net, "low", 2, 0.1, {0, 0, 0}, at_rest, 0.05, 0.01, 2000.0, 5.0);
    add_block(net, "high", 2, 0.1, {0.013, 0.007, 0.115}, at_rest, 0.05, 0.01, 2000.0, 5.0);
    touch(net, 0, 1, {Friction::Kind::coulomb, mu});
    Plane floor;
    floor.friction = frictionless;
    net.add_plane(floor);
    const double angle = 0.2;
    net.set_gravity({g * std::sin(angle), 0, -g * std::cos(angle)});
    Simulation s = simulate(net, reference(1e-6), 0.01);
    double energy = s.kinetic_energy() + s.potential_energy();
    for (int i = 0; i < 30; ++i) {
      s.step();
      const double now = s.kinetic_energy() + s.potential_energy();
      CHECK(now <= energy + 1e-6);
      energy = now;
    }
    CHECK(count_events(s).met >= 1);
    Vector3 sum = Vector3::Zero();
    for (NodeIndex k = 0; k < 16; ++k) sum += s.velocity(k) / 16.0;
    // Forces without friction have no part in it; with friction Newton's iterations end within the tolerance, 1e-6 of
    // the speeds in each of some hundred short steps.
    CHECK(sum[0] == doctest::Approx(g * std::sin(angle) * 0.3).epsilon(mu > 0.0 ? 1e-4 : 1e-9));
    CHECK(std::abs(sum[1]) <= (mu > 0.0 ? 1e-4 : 1e-12));
  }
}

TEST_CASE(
    "the reference: a ball that a moved one pushes goes on where that stops, and is struck where it turns round") {
  const double speed = 2.0;
  for (const double e : {0.0, 0.5}) {
    CAPTURE(e);
    Network net;
    const NodeIndex club = add_ball(net, "club", {0, 0, 0}, at_rest, 1.0, 0.1);
    add_ball(net, "ball", {0.2, 0, 0}, at_rest, 0.4, 0.1);
    add_ball(net, "wall", {1.6, 0, 0}, at_rest, 1.0, 0.1, true);
    touch_all(net, frictionless, e);
    Motion motion;  // to 0.4, where it waits until 0.5 s, and back
    motion.interpolation = Motion::Interpolation::linear;
    motion.times = {0.0, 0.2, 0.5, 0.7};
    motion.displacements = {Vector3::Zero(), Vector3(0.4, 0, 0), Vector3(0.4, 0, 0), Vector3::Zero()};
    net.add_move({{club}, motion});
    Simulation s = simulate(net, reference(), 0.007);
    while (s.time() < 0.3) s.step();
    // Struck at the start, with (1 + e) of the club's speed; without restitution it is pushed until the club stops.
    const double leaves = (1.0 + e) * speed;
    CHECK(s.velocity(1)[0] == doctest::Approx(leaves).epsilon(1e-9));
    CHECK(s.position(1)[0] == doctest::Approx(0.2 + leaves * s.time()).epsilon(1e-9));
    while (s.time() < 0.65) s.step();
    // It reaches the wall 1.2 m further on.
    const double arrives = 1.2 / leaves;
    CHECK(s.velocity(1)[0] == doctest::Approx(-e * leaves).epsilon(1e-9));
    CHECK(s.position(1)[0] == doctest::Approx(1.4 - e * leaves * (s.time() - arrives)).epsilon(1e-9));
  }
}

TEST_CASE("the reference: pairs that the program moves apart part, and those whose speed it sets are struck") {
  Network net = pile_of_balls(2, 0.3, 0.1);
  Simulation s = simulate(net, reference(), 0.01);
  advance(s, 5);
  REQUIRE(s.body_touches().size() == 2);
  s.set_position(2, {0, 0, 0.5});
  s.step();
  CHECK(s.body_touches().size() == 1);
  CHECK(s.position(2)[2] == doctest::Approx(0.5 - 0.5 * g * 1e-4).epsilon(1e-9));
  CHECK(s.position(1)[2] == doctest::Approx(0.2).epsilon(1e-9));
  s.set_velocity(1, {0, 0, -3});  // into the fixed one
  s.step();
  CHECK(s.velocity(1).norm() <= 1e-9);
  s.set_velocity(1, {0, 0, 1});
  s.step();
  CHECK(s.body_touches().empty());
  CHECK(s.velocity(1)[2] == doctest::Approx(1.0 - g * 0.01).epsilon(1e-9));
}

TEST_CASE("the reference goes on with contacts of the network, and the network with those of the reference") {
  const double m = 0.3, radius = 0.1;
  const int count = 3;
  for (const bool first : {true, false}) {
    CAPTURE(first);
    const Network net = pile_of_balls(count, m, radius);
    const LawUse network{"recurrent", {}}, located = reference(1e-8);
    Simulation before = simulate(net, first ? network : located, 0.01);
    advance(before, 20);
    REQUIRE(before.body_touches().size() == static_cast<std::size_t>(count));
    before.set_integrator(first ? located : network);
    advance(before, 20);
    check_pile(before, count, m, radius);
  }
}

TEST_CASE("the reference: what touches nothing moves as without contact, in all bits") {
  const auto run = [](bool with) {
    Network net;
    add_block(net, "one", 3, 0.1, {0, 0, 0}, {0.3, 0.1, 0}, 0.05, 0.01, 1500.0, 1.0);
    add_block(net, "other", 3, 0.1, {0, 0, 0.6}, {0, 0.2, -0.1}, 0.05, 0.01, 1500.0, 1.0);
    if (with) touch_all(net, {});
    Simulation s = simulate(net, reference(1e-8), 0.01);
    s.set_velocity(5, {2, 0, 1});
    advance(s, 40);
    return Eigen::Matrix3Xd(s.positions());
  };
  CHECK(run(true) == run(false));
}

TEST_CASE("the reference: the same bits for any number of threads, after a saved state, and where nothing is added") {
  check_bits(pile_of_balls(3, 0.3, 0.1), reference(1e-8), 0.01, 10, 20);
}

TEST_CASE("the reference: the network comes to the same motion as its steps become short") {
  // A sheet falls on a fixed ridge and drapes: corners, edges and faces come and go.
  Network net;
  add_sheet(net, "sheet", 5, 0.4, {0.013, 0.007, 0.03}, Vector3::UnitX(), Vector3::UnitY(), 0.02, 0.01, false, 200.0);
  net.begin_body("ridge");
  const NodeIndex first = net.add_node(point({-0.5, 0.021, 0}, 1.0));
  net.add_node(point({0.5, 0.043, -0.02}, 1.0));
  net.add_node(point({0.0, 0.0, -0.6}, 1.0));
  net.add_face({first, first + 1, first + 2});
  net.end_body();
  net.set_extent(1, 0.02, 0.0);
  for (NodeIndex k = first; k < first + 3; ++k) net.fix(k);
  touch(net, 0, 1, {Friction::Kind::coulomb, 0.3});
  net.set_gravity({0, 0, -g});
  const auto after = [&](const LawUse& integrator, double step) {
    Simulation s = simulate(net, integrator, step);
    while (s.time() < 0.15 - 1e-9) s.step();
    CHECK(count_events(s).met >= 3);
    return Eigen::Matrix3Xd(s.positions());
  };
  const Eigen::Matrix3Xd exact = after(reference(1e-7), 0.01);
  double last = 4e-3;
  for (const double h : {2e-3, 5e-4}) {
    const Eigen::Matrix3Xd now = after({"recurrent", {{"theta", 1.0}, {"force_tolerance", 1e-10}}}, h);
    const double error = (now - exact).colwise().norm().maxCoeff();
    CHECK(error <= 0.4 * last);  // of first order: a quarter each
    last = error;
  }
}

TEST_CASE("the reference: a ball that bounces on a face comes to rest, and never sinks in") {
  // The times of flight are a geometric series: it rests at t = sqrt(2 h / g) (1 + e) / (1 - e).
  const double h = 0.3;
  for (const double tolerance : {1e-6, 1e-10})
    for (const double radius : {0.1, 0.0999, 0.1013})
      for (const double e : {0.3, 0.7}) {
        CAPTURE(tolerance);
        CAPTURE(radius);
        CAPTURE(e);
        Network net;
        add_sheet(net, "sheet", 2, 1.0, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(), 0.02, 1.0, true);
        const NodeIndex ball = add_ball(net, "ball", {0.11, 0.05, 0.01 + radius + h}, at_rest, 0.4, radius);
        touch_all(net, frictionless, e);
        net.set_gravity({0, 0, -g});
        Simulation s = simulate(net, reference(tolerance), 0.01);
        const double rests = std::sqrt(2.0 * h / g) * (1.0 + e) / (1.0 - e);
        while (s.time() < 1.1 * rests) {
          s.step();
          REQUIRE(s.position(ball)[2] >= 0.01 + radius - 20.0 * tolerance);  // of positions: 10 times the tolerance
        }
        CHECK(s.velocity(ball).norm() <= 1e-9);
        REQUIRE(s.body_touches().size() == 1);
        CHECK(s.body_touches()[0].force.norm() == doctest::Approx(0.4 * g).epsilon(1e-6));
        const std::size_t met = count_events(s).met;
        CHECK(met <= 40);
        // The first rebounds, before tolerances show: each e times as fast as the one before.
        double fast = std::sqrt(2.0 * g * h);
        for (std::size_t i = 0, k = 0; i < s.events().size() && k < 4; ++i) {
          if (s.events()[i].kind != Event::Kind::met) continue;
          CHECK(s.events()[i].impulse.norm() ==
                doctest::Approx(0.4 * (1.0 + e) * fast).epsilon(300.0 * tolerance / fast));
          fast *= e;
          ++k;
        }
      }
}

TEST_CASE("the reference: a ball slides straight over flat faces, their edges and corners") {
  for (const double tolerance : {1e-6, 1e-10, 1e-12}) {
    CAPTURE(tolerance);
    Network net;
    add_sheet(net, "sheet", 5, 4.0, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(), 0.02, 1.0, true);
    const NodeIndex ball = add_ball(net, "ball", {-1.3, -0.91, 0.11}, {2.0, 1.4, 0}, 0.3, 0.1);
    touch_all(net, frictionless);
    net.set_gravity({0, 0, -g});
    Simulation s = simulate(net, reference(tolerance), 0.01);
    advance(s, 100);  // over the middle of the sheet, where six faces meet
    CHECK((s.position(ball) - Vector3(0.7, 0.49, 0.11)).norm() <= 1e-8 + 200.0 * tolerance);
    CHECK((s.velocity(ball) - Vector3(2.0, 1.4, 0)).norm() <= 1e-8 + 200.0 * tolerance);
  }
}

TEST_CASE(
    "the reference: a tray that jumps away leaves what lies on it, and one that jumps aside takes it along by "
    "friction") {
  const double mu = 0.3, jump = 0.05, start = 0.1;
  for (const bool aside : {false, true}) {
    CAPTURE(aside);
    Network net;
    add_sheet(net, "tray", 2, 4.0, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(), 0.02, 1.0, false);
    const NodeIndex ball = add_ball(net, "ball", {0.3, 0.1, 0.11}, at_rest, 0.5, 0.1);
    touch_all(net, {Friction::Kind::coulomb, mu});
    net.set_gravity({0, 0, -g});
    Motion motion;
    motion.interpolation = Motion::Interpolation::linear;
    motion.times = {0.0, start, 1.0};
    const Vector3 velocity = aside ? Vector3(1, 0, 0) : Vector3(0, 0, -20);
    motion.displacements = {Vector3::Zero(), Vector3::Zero(), Vector3((1.0 - start) * velocity)};
    net.add_move({{0, 1, 2, 3}, motion});
    Simulation s = simulate(net, reference(), 0.01);
    while (s.time() < start + jump - 1e-9) s.step();
    // It falls freely, or gains mu g until it goes with the tray, after 0.34 s.
    const Vector3 gained = aside ? Vector3(mu * g, 0, 0) : Vector3(0, 0, -g);
    CHECK((s.velocity(ball) - gained * jump).norm() <= 1e-8);
    CHECK(s.body_touches().size() == (aside ? 1u : 0u));
    if (!aside) continue;
    CHECK(count_events(s).slipped == 1);
    while (s.time() < 0.6) s.step();
    CHECK((s.velocity(ball) - velocity).norm() <= 1e-8);
    CHECK(count_events(s).stuck == 1);
    const double takes = 1.0 / (mu * g);
    CHECK(s.position(ball)[0] == doctest::Approx(0.3 + s.time() - start - 0.5 * takes).epsilon(1e-8));
  }
}

TEST_CASE("the reference: bodies that nothing can move may pass each other") {
  Network net;
  add_ball(net, "post", {0, 0, 0}, at_rest, 1.0, 0.1, true);
  const NodeIndex moved = add_ball(net, "moved", {-0.5, 0.02, 0}, at_rest, 1.0, 0.1);
  const NodeIndex free = add_ball(net, "free", {0, 5, 0}, {0, 1, 0}, 1.0, 0.1);
  touch_all(net, frictionless);
  Motion motion;
  motion.interpolation = Motion::Interpolation::linear;
  motion.times = {0.0, 1.0};
  motion.displacements = {Vector3::Zero(), Vector3(1, 0, 0)};
  net.add_move({{moved}, motion});
  Simulation s = simulate(net, reference(), 0.01);
  advance(s, 90);
  CHECK(s.position(free)[1] == doctest::Approx(5.9).epsilon(1e-9));
  CHECK(count_events(s).met == 0);
}

// How a slip goes on changes the events that end it, and with them the sizes of the integrator's arrays: each change
// has to be told as a new revision. Blocks of this kind wrote beyond these arrays.
TEST_CASE("the reference: each change of a slip counts as a change of the network") {
  Network net;
  add_block(net, "block", 3, 0.1, {0.013, -0.021, 0.01}, at_rest, 0.02, 0.01, 1500.0, 1.0);
  Plane floor;
  floor.friction = {Friction::Kind::coulomb, 0.1};
  net.add_plane(floor);
  net.set_gravity({0, 0, -g});
  Simulation s = simulate(net, reference(1e-6), 0.005);
  advance(s, 20);
  CHECK(count_events(s).stuck >= 5);
}
