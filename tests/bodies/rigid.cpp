// Bodies of rigidly connected nodes in contact: what strikes one node moves and turns them all.
#define SPRINGNET_STATIC_PLUGIN rigid_bodies

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/LU>

#include <springnet/error.hpp>
#include <springnet/events.hpp>
#include <springnet/sdk/integrator.hpp>

#include "bodies.hpp"
#include "crossings.hpp"
#include "rigid_bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Mass, kg; inertia about the centre, kg m^2; centre, m; of nodes [first, first + count).
struct RigidBody {
  double mass = 0.0;
  Vector3 centre = Vector3::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  RigidBody(const Network& net, NodeIndex first, NodeIndex count) {
    for (NodeIndex k = first; k < first + count; ++k) {
      mass += net.nodes()[k].mass;
      centre += net.nodes()[k].mass * net.nodes()[k].position;
    }
    centre /= mass;
    for (NodeIndex k = first; k < first + count; ++k) {
      const Vector3 r = net.nodes()[k].position - centre;
      inertia += net.nodes()[k].mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    }
  }
  // Of a point, by an impulse there: its change of velocity, m/s.
  [[nodiscard]] Vector3 answer(const Vector3& at, const Vector3& impulse) const {
    return impulse / mass + turn(at, impulse).cross(at - centre);
  }
  // rad/s
  [[nodiscard]] Vector3 turn(const Vector3& at, const Vector3& impulse) const {
    return inertia.inverse() * (at - centre).cross(impulse);
  }
};

// A rigid body of four nodes and a ball that flies at its first node, 10 mm off.
struct Strike {
  Network net;
  Vector3 along;  // unit, of the flight
  NodeIndex ball = 0;
};
constexpr double ball_mass = 0.4, speed = 2.0;
Strike strike(const Friction& friction, double restitution, const Vector3& along, const Vector3& beside) {
  Strike result;
  Network& net = result.net;
  net.begin_body("rigid");
  const std::array<Vector3, 4> places{Vector3(0, 0, 0), Vector3(0.3, 0.1, 0), Vector3(0.1, 0.4, 0.05),
                                      Vector3(0.05, 0.1, 0.35)};
  for (std::size_t k = 0; k < 4; ++k) net.add_node(point(places[k], 0.2 + 0.15 * static_cast<double>(k)));
  net.end_body();
  net.set_extent(0, 0.0, 0.02);
  join(net, 0, 4);
  result.along = along.normalized();
  result.ball = add_ball(net, "ball", -0.06 * result.along + beside, speed * result.along, ball_mass, 0.03);
  touch(net, 0, 1, friction, restitution);
  return result;
}

// Rigid blocks of 0.2 m above each other, beside each other by some 10 mm, which fall onto a floor.
constexpr double block_mass = 0.4;
Network falling_blocks(int count, double spacing) {
  Network net;
  for (int block = 0; block < count; ++block) {
    const Vector3 origin(0.007 * (block % 4), 0.011 * (block % 3), spacing * block + 0.002);
    add_box(net, "block " + std::to_string(block), origin, Vector3::Constant(0.2), block_mass, 0.003);
  }
  touch_all(net, {Friction::Kind::coulomb, 0.5});
  Plane floor;
  floor.friction = {Friction::Kind::coulomb, 0.5};
  net.add_plane(floor);
  net.set_gravity({0, 0, -g});
  return net;
}

// That they have come to rest above the floor, which carries them.
void check_rest(const Network& net, const Simulation& s, int count) {
  double fastest = 0.0, lowest = 1.0;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    fastest = std::max(fastest, s.velocity(k).norm());
    lowest = std::min(lowest, s.position(k)[2]);
  }
  CHECK(fastest <= 1e-6);
  CHECK(lowest >= -1e-9);
  CHECK(-s.surface_force(0)[2] == doctest::Approx(count * block_mass * g).epsilon(1e-6));
}

void check_lengths(const Network& net, const Simulation& s) {
  for (const Rigid& rod : net.rigids())
    CHECK((s.position(rod.first) - s.position(rod.second)).norm() == doctest::Approx(rod.length).epsilon(1e-9));
}

// Advances to the end of the step in which something meets.
void advance_to_meeting(Simulation& s) {
  for (int i = 0; i < 10000 && s.events().empty(); ++i) s.step();
  REQUIRE(!s.events().empty());
  REQUIRE(s.events().front().kind == Event::Kind::met);
}

// Keeps bodies apart, but not those of rigidly connected nodes.
class OfSpringsOnly : public sdk::Integrator {
 public:
  static constexpr const char* id = "of_springs_only";
  static constexpr const char* summary = "for a test: never runs";
  static constexpr bool keeps_bodies_apart = true;
  OfSpringsOnly(sdk::Host, sdk::Options) {}
  springnet_status advance(double, springnet_step_report&) { return SPRINGNET_FAILED; }
};

}  // namespace

SPRINGNET_PLUGIN("test.bodies", "1.0.0", "springnet", "MIT", OfSpringsOnly);

TEST_CASE("a ball that strikes a rigid body of nodes moves and turns it as rigid bodies do") {
  const double h = 1e-4;
  for (const Method& method : methods(1e-9)) {
    CAPTURE(method.name);
    for (const double e : {0.0, 0.5, 1.0}) {
      CAPTURE(e);
      const Strike scene = strike(frictionless, e, {1.0, 0.4, -0.3}, Vector3::Zero());
      const RigidBody body(scene.net, 0, 4);
      const Vector3 n = scene.along;
      // Newton's law for the speed at which the points in contact approach.
      const double impulse = (1.0 + e) * speed / (1.0 / ball_mass + n.dot(body.answer(Vector3::Zero(), n)));
      Simulation s = simulate(scene.net, method.integrator, h);
      const Vector3 before = momentum(scene.net, s), turning = angular_momentum(scene.net, s);
      advance_to_meeting(s);
      // Within the step the body goes by h speed and turns accordingly: relative to its size 1e-3.
      CHECK(s.events().front().impulse.norm() == doctest::Approx(impulse).epsilon(2e-3));
      CHECK((s.velocity(scene.ball) - (speed - impulse / ball_mass) * n).norm() <= 2e-3 * speed);
      const Vector3 push = impulse * n, turn = body.inertia.inverse() * (-body.centre).cross(push);
      for (NodeIndex k = 0; k < 4; ++k) {
        CAPTURE(k);
        const Vector3 r = scene.net.nodes()[k].position - body.centre;
        CHECK((s.velocity(k) - push / body.mass - turn.cross(r)).norm() <= 2e-3 * speed);
      }
      CHECK((momentum(scene.net, s) - before).norm() <= 1e-12);
      CHECK((angular_momentum(scene.net, s) - turning).norm() <= 1e-4);
      check_lengths(scene.net, s);
      advance(s, 1000);
      check_lengths(scene.net, s);
    }
  }
}

TEST_CASE("friction turns a rigid body that is struck beside its centre") {
  const double h = 1e-4, mu = 0.2, e = 0.3;
  const Vector3 beside(0.012, 0.02, 0.024);  // across the flight, less than the radii
  for (const Method& method : methods(1e-9)) {
    CAPTURE(method.name);
    const Strike scene = strike({Friction::Kind::coulomb, mu}, e, {0.0, 0.768, -0.64}, beside);
    const RigidBody body(scene.net, 0, 4);
    // Where both spheres touch: the line between the centres is as long as the radii.
    const double reach = 0.05, across = beside.norm();
    REQUIRE(std::abs(beside.dot(scene.along)) <= 1e-12);
    const Vector3 n = (beside - std::sqrt(reach * reach - across * across) * scene.along) / reach;  // to the ball
    const Vector3 v = speed * scene.along, slip = v - n * n.dot(v);
    // The impulse on the ball presses along n and is at the border of the cone against the final slip, whose direction
    // is found by a fixed point: J = N (n - mu t), t the direction of the slip after it.
    Vector3 t = slip.normalized();
    double pressing = 0.0;
    for (int i = 0; i < 200; ++i) {
      const Vector3 of_one = n - mu * t, answer = of_one / ball_mass + body.answer(Vector3::Zero(), of_one);
      pressing = -(1.0 + e) * n.dot(v) / n.dot(answer);
      const Vector3 after = v + pressing * answer;
      t = (after - n * n.dot(after)).normalized();
    }
    const Vector3 impulse = pressing * (n - mu * t);
    Simulation s = simulate(scene.net, method.integrator, h);
    advance_to_meeting(s);
    CHECK((s.velocity(scene.ball) - v - impulse / ball_mass).norm() <= 5e-3 * speed);
    const Vector3 turn = body.inertia.inverse() * (-body.centre).cross(-impulse);
    for (NodeIndex k = 0; k < 4; ++k) {
      CAPTURE(k);
      const Vector3 r = scene.net.nodes()[k].position - body.centre;
      CHECK((s.velocity(k) + impulse / body.mass - turn.cross(r)).norm() <= 5e-3 * speed);
    }
  }
}

TEST_CASE("a rigid block on an incline sticks below the angle of friction, and slides above it") {
  const double mu = 0.5, time = 0.2, mass = 0.1, h = 0.002;
  for (const Method& method : methods(1e-7)) {
    CAPTURE(method.name);
    for (const double angle : {std::atan(mu) - 2e-3, std::atan(mu) + 2e-3, 0.6}) {
      CAPTURE(angle);
      Network net;
      add_sheet(net, "incline", 9, 2.0, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(), 0.02, 1.0, true);
      net.begin_body("block");
      const auto first = static_cast<NodeIndex>(net.nodes().size());
      for (int k = 0; k < 8; ++k)  // flat, so that it does not tip over
        net.add_node(point({-0.5 + 0.4 * (k & 1), 0.03 + 0.3 * (k >> 1 & 1), 0.03 + 0.1 * (k >> 2)}, mass));
      net.end_body();
      net.set_extent(net.bodies().size() - 1, 0.0, 0.02);
      join(net, first, 8);
      touch(net, 0, 1, {Friction::Kind::coulomb, mu});
      net.set_gravity(g * Vector3(std::sin(angle), 0, -std::cos(angle)));
      Simulation s = simulate(net, method.integrator, h);
      const double a = std::max(0.0, g * (std::sin(angle) - mu * std::cos(angle)));
      const auto force_error = [&] {
        Vector3 force = Vector3::Zero();
        for (const BodyTouch& each : s.body_touches()) force += (each.nodes[0] >= first ? 1.0 : -1.0) * each.force;
        return (force - 8.0 * mass * (Vector3(a, 0, 0) - net.gravity())).norm();
      };
      for (int i = 0; i < 100; ++i) {
        s.step();
        // Also where corners slide from face to face.
        if (method.name == "verlet" && i > 1) CHECK(force_error() <= 1e-3);
      }
      const double path = 0.5 * a * time * (time + (2.0 * method.theta - 1.0) * h);  // h: at theta 1 the method's error
      for (NodeIndex k = first; k < first + 8; ++k) {
        CAPTURE(k);
        CHECK((s.position(k) - net.nodes()[k].position - path * Vector3::UnitX()).norm() <= 1e-5);
        CHECK((s.velocity(k) - a * Vector3::UnitX() * time).norm() <= 1e-4);
      }
      CHECK(force_error() <= 1e-3);
    }
  }
}

TEST_CASE("rigid blocks that fall on each other come to rest, and the floor carries them") {
  const Network net = falling_blocks(3, 0.21);
  for (const std::string rule : update_rules) {
    CAPTURE(rule);
    Simulation s = simulate(net, recurrent(update_named(rule), 1e-8), 0.002);
    advance(s, 400);
    check_rest(net, s, 3);
  }
  // The second and the third land on one that rests on another: impacts go on to the floor when they happen.
  for (const auto& [integrator, h] : {std::pair(verlet, 0.002), std::pair(reference(1e-7), 0.01)}) {
    CAPTURE(integrator.id);
    Simulation s = simulate(net, integrator, h);
    double energy = 1e9;
    while (s.time() < 0.3) {
      s.step();
      const double now = s.kinetic_energy() + s.potential_energy();
      CHECK(now <= energy + 1e-9);
      energy = now;
    }
    check_rest(net, s, 3);
    CHECK(count_crossings(net, s) == 0);
  }
}

// Feet press or lift: of all subsets that press, the one whose impulses push and whose other feet rise.
double impulse_on_feet(const RigidBody& body, const std::array<Vector3, 3>& feet, const Vector3& at, const Vector3& n,
                       double approach) {
  const auto answer = [&](std::size_t moved, std::size_t struck) {
    const auto place = [&](std::size_t i) { return i == 0 ? at : feet[i - 1]; };
    const auto along = [&](std::size_t i) -> Vector3 { return i == 0 ? n : Vector3::UnitZ(); };
    const Vector3 change = body.answer(place(struck), along(struck)) +
                           body.turn(place(struck), along(struck)).cross(place(moved) - place(struck));
    return along(moved).dot(change);
  };
  Eigen::Matrix4d all;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) all(Eigen::Index(i), Eigen::Index(j)) = answer(i, j);
  all(0, 0) += 1.0 / 0.2;
  const Eigen::Vector4d free(-approach, 0.0, 0.0, 0.0);
  for (unsigned pressing = 0; pressing < 8; ++pressing) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (Eigen::Index i = 0; i < 4; ++i) {
      if (i > 0 && (pressing >> (i - 1) & 1u) == 0) continue;
      matrix.row(i) = all.row(i);
      right[i] = -free[i];
    }
    const Eigen::Vector4d impulses = matrix.fullPivLu().solve(right);
    if ((impulses.array() >= -1e-12).all() && ((all * impulses + free).array() >= -1e-12).all()) return impulses[0];
  }
  return 0.0;
}

TEST_CASE("a ball strikes a rigid body that stands on a floor, and its feet press or lift") {
  const std::array<Vector3, 4> places{Vector3(0, 0, 0), Vector3(0.4, 0, 0), Vector3(0.2, 0.35, 0),
                                      Vector3(0.2, 0.12, 0.3)};
  for (const Vector3& direction : {Vector3(1, 0.3, -0.5), Vector3(0.3, 0.1, -1), Vector3(1, 0.2, 0.3)})
    for (const double e : {0.0, 0.3}) {
      CAPTURE(direction[2]);
      CAPTURE(e);
      Network net;
      net.begin_body("stool");
      for (const Vector3& place : places) net.add_node(point(place, 0.3));
      net.end_body();
      net.set_extent(0, 0.0, 0.02);
      join(net, 0, 4);
      const Vector3 n = direction.normalized();
      const NodeIndex ball = add_ball(net, "ball", places[3] - 0.0502 * n, speed * n, 0.2, 0.03);
      touch_all(net, frictionless, e);
      Plane floor;
      floor.friction = frictionless;
      net.add_plane(floor);
      net.set_gravity({0, 0, -g});
      const RigidBody body(net, 0, 4);
      const double exact = impulse_on_feet(body, {places[0], places[1], places[2]}, places[3], n, (1.0 + e) * speed);
      for (const auto& [integrator, h] : {std::pair(verlet, 1e-4), std::pair(reference(1e-9), 1e-4)}) {
        CAPTURE(integrator.id);
        Simulation s = simulate(net, integrator, h);
        advance(s, 3);  // they meet at 1e-4 s
        // Gravity for a few steps, 1e-3 m/s; where feet lift at once it turns the body meanwhile.
        CHECK(0.2 * (speed * n - s.velocity(ball)).dot(n) == doctest::Approx(exact).epsilon(3e-3));
      }
    }
}

// Up to three thicknesses deep, where corners are just beside borders: what is deep in each other has the direction in
// which it met.
TEST_CASE("rigid blocks that arrive deep in each other are pushed apart, not through") {
  const Network net = falling_blocks(8, 0.37);
  Simulation s = simulate(net, recurrent(newton, 1e-6), 0.004);
  advance(s, 225);
  CHECK(count_crossings(net, s) == 0);
  check_rest(net, s, 8);
}

// They meet at up to 5 m/s, three times the thickness in a step.
TEST_CASE("a dropped stack of ten rigid blocks comes to rest, and none enters another") {
  const Network net = falling_blocks(10, 0.3);
  Simulation s = simulate(net, recurrent(newton, 1e-6, {{"unsettled", on_unsettled_adapt}}), 0.004);
  double energy = 1e9;
  while (s.time() < 1.6) {
    s.step();
    double now = 0.0;
    for (NodeIndex k = 0; k < net.nodes().size(); ++k)
      now += block_mass / 8.0 * (0.5 * s.velocity(k).squaredNorm() + g * s.position(k)[2]);
    REQUIRE(now <= energy + 1e-4);  // backward Euler gains nothing; settling to 1e-6 N
    energy = now;
    if (s.steps() % 10 == 0) REQUIRE(count_crossings(net, s) == 0);
  }
  check_rest(net, s, 10);
}

// A turned block between a wall and a load: with friction of the floor the wall bears between the load and what
// friction leaves of it. Nothing moves, so that pairs stay, with the same force.
TEST_CASE("a rigid block that is pressed against a wall goes on touching it") {
  const double load = 5.0, mass = 0.8;
  for (const double mu : {0.0, 0.2}) {
    for (const Method& method : methods(1e-8)) {
      if (method.network && method.theta < 1.0) continue;
      CAPTURE(mu);
      CAPTURE(method.name);
      Network net;
      const Friction friction = mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless;
      add_sheet(net, "wall", 5, 1.0, {0, 0, 0.3}, Vector3::UnitY(), Vector3::UnitZ(), 0.02, 1.0, true);
      net.begin_body("block");
      const auto first = static_cast<NodeIndex>(net.nodes().size());
      for (int k = 0; k < 8; ++k)
        net.add_node(point({0.03 + 0.2 * (k & 1), 0.013 + 0.2 * (k >> 1 & 1), 0.2 * (k >> 2)}, mass / 8.0));
      net.end_body();
      net.set_extent(1, 0.0, 0.02);
      join(net, first, 8);
      touch(net, 0, 1, friction);
      Plane floor;
      floor.friction = friction;
      net.add_plane(floor);
      Load push;
      for (NodeIndex k = first; k < first + 8; ++k) push.nodes.push_back(k);
      push.force = Vector3(-load / 8.0, 0, 0);
      net.add_load(push);
      net.set_gravity({0, 0, -g});
      Simulation s = simulate(net, method.integrator, 0.005);
      advance(s, 20);
      const std::size_t events = s.events().size();
      const auto pressing = [&] {
        double sum = 0.0;
        for (const BodyTouch& each : s.body_touches()) sum += std::abs(each.force[0]);
        return sum;
      };
      const double before = pressing();
      advance(s, 20);
      CHECK(s.events().size() == events);
      // The wall's share of friction is not unique; in verlet it creeps.
      CHECK(pressing() == doctest::Approx(before).epsilon(method.name == "verlet" ? 3e-3 : 1e-6));
      CHECK(pressing() <= load * (1.0 + 1e-6));
      CHECK(pressing() >= (load - mu * (mass * g + mu * load)) * (1.0 - 1e-6));
      for (NodeIndex k = first; k < first + 8; ++k) CHECK(s.velocity(k).norm() <= 1e-7);
    }
  }
}

TEST_CASE("what rests on a rigid frame presses through its connections") {
  const double frame = 0.2, mass = 0.3, height = 0.4, side = 0.3;
  for (const Method& method : methods(1e-10)) {
    CAPTURE(method.name);
    Network net;
    net.begin_body("tripod");
    for (int k = 0; k < 3; ++k) {
      const double angle = std::acos(-1.0) * 2.0 * k / 3.0;
      Node foot = point({side * std::cos(angle), side * std::sin(angle), 0.0}, 1.0);
      foot.fixed = true;
      net.add_node(foot);
    }
    const NodeIndex top = net.add_node(point({0, 0, height}, frame));
    for (NodeIndex k = 0; k < 3; ++k) net.add_rigid(k, top);
    net.end_body();
    net.set_extent(0, 0.0, 0.05);
    add_ball(net, "ball", {0, 0, height + 0.1}, at_rest, mass, 0.05);
    touch(net, 0, 1, frictionless);
    net.set_gravity({0, 0, -g});
    Simulation s = simulate(net, method.integrator, 0.01);
    advance(s, 10);
    const double weight = (frame + mass) * g, length = std::hypot(height, side);
    for (NodeIndex k = 0; k < 3; ++k) {
      CHECK(s.rigid_force(k) == doctest::Approx(-weight / 3.0 * length / height).epsilon(1e-7));
      CHECK(s.reaction(k)[2] == doctest::Approx(g + weight / 3.0).epsilon(1e-7));
    }
    REQUIRE(s.body_touches().size() == 1);
    CHECK(s.body_touches()[0].force.norm() == doctest::Approx(mass * g).epsilon(1e-7));
  }
}

TEST_CASE("an integrator that keeps only other bodies apart refuses rigid ones, with what to do") {
  const Strike scene = strike(frictionless, 0.0, Vector3::UnitX(), Vector3::Zero());
  auto plugin_host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  REQUIRE(plugin_host->add(springnet_plugin_entry_rigid_bodies));
  SimulationOptions options;
  options.time_step = 1e-3;
  options.integrator = {"of_springs_only", {}};
  CHECK_THROWS_WITH_AS(
      Simulation(scene.net, plugin_host, options),
      "integrator 'of_springs_only' does not handle contact of bodies whose nodes have rigid connections, which "
      "this network has; use recurrent, verlet or cvode, leave such nodes out of [[contact]], or make stiff springs "
      "of the connections",
      Error);
}
