// A moved node whose velocity jumps (a linear table) pulls a rod along: the impulses of that, on surfaces and on what
// moves the node, against the equations of one blow.

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double first_mass = 2.0, second_mass = 0.5;  // kg
constexpr double at = 0.1;                             // s
const Vector3 rod(0.6, 0, -0.8);                       // from the moved node, m

// `jump`: of the velocity of the upper node at `at`, m/s. Without a floor there is no gravity either.
Network pulled(const Vector3& jump, bool floor) {
  Network net;
  net.add_node(point({0, 0, 1}, first_mass));
  net.add_node(point(Vector3(0, 0, 1) + rod, second_mass));
  net.add_rigid(0, 1);
  Move move;
  move.nodes = {0};
  move.motion.interpolation = Motion::Interpolation::linear;
  move.motion.times = {0.0, at, 2.0 * at};
  move.motion.displacements = {Vector3::Zero(), Vector3::Zero(), at * jump};
  net.add_move(move);
  if (!floor) return net;
  Plane plane;
  plane.point = {0, 0, 0.2};
  plane.friction = {Friction::Kind::coulomb, 0.3};
  net.add_plane(plane);
  net.set_gravity({0, 0, -1});
  return net;
}

struct Jump {
  std::string name;
  Vector3 jump;
  bool floor;
  Vector3 velocity, surface;  // of the second node, m/s; what the floor gives it, N s
};

std::vector<Jump> jumps() {
  const auto along = [](const Vector3& jump) { return Vector3(rod * rod.dot(jump)); };  // nothing else acts
  // In the floor, v = rod . jump / 0.6; with the rod's impulse X and the floor's N: m v = 0.6 X - 0.3 N, N = 0.8 X.
  const auto on_floor = [](double v) {
    const double normal = 0.8 * second_mass * v / (0.6 - 0.3 * 0.8);
    return Vector3(-0.3 * normal, 0, normal);
  };
  const Vector3 up(0, 0, 0.1), down(0, 0, -0.1), aside(1, 0, 0), back(-1, 0, 0);
  return {{"free", up, false, along(up), Vector3::Zero()},
          {"lifted off", up, true, along(up), Vector3::Zero()},
          {"dragged off", back, true, along(back), Vector3::Zero()},
          {"pressed on", down, true, {0.08 / 0.6, 0, 0}, on_floor(0.08 / 0.6)},
          {"pushed along", aside, true, {1, 0, 0}, on_floor(1.0)}};
}

}  // namespace

TEST_CASE("a jump of a moved node gives impulses to the nodes joined to it, to obstacles and to its motion") {
  for (const Jump& jump : jumps()) {
    const Network net = pulled(jump.jump, jump.floor);
    for (const LawUse& integrator :
         {cvode(1e-10), recurrent(newton, 1e-11), recurrent(newton, 1e-11, {{"theta", 0.5}}),
          recurrent(newton, 1e-11, {{"events", 1.0}}), LawUse{"verlet", {}}, generalized_alpha()}) {
      INFO(jump.name << ", " << integrator.id);
      constexpr double step = 1e-3;
      Simulation s = simulate(net, integrator, step);
      s.advance_to(at - step);
      const Vector3 moved = s.contact_impulse(0), hung = s.contact_impulse(1);
      s.advance_to(at);
      // Rods that hang between what holds them have undetermined forces: those told and those of a step of the network
      // differ by up to the weight, 0.5 N, which is booked as an impulse.
      const double tolerance = jump.floor ? step * 0.5 + 1e-9 : 1e-12;
      // Steps before the jump keep the rod to 1e-8 of its length.
      CHECK((s.velocity(1) - jump.velocity).norm() <= 1e-7);
      CHECK((s.velocity(0) - jump.jump).norm() <= 1e-12);
      CHECK((s.contact_impulse(1) - hung - jump.surface).norm() <= tolerance);
      const Vector3 mover = first_mass * jump.jump + second_mass * jump.velocity - jump.surface;
      CHECK((s.contact_impulse(0) - moved - mover).norm() <= tolerance);
      CHECK(s.touching(1) == !jump.surface.isZero(0.0));
      if (jump.floor) CHECK((s.surface_impulse(0) + s.contact_impulse(1)).norm() <= 1e-12);
    }
  }
}

TEST_CASE("a node that a program moves from one moment to the next has the impulse of that") {
  for (const LawUse& integrator : {cvode(1e-10), recurrent(newton, 1e-11), LawUse{"verlet", {}}, generalized_alpha()}) {
    INFO(integrator.id);
    const Vector3 target(0.02, 0, 1.01);
    Simulation s = simulate(pulled(Vector3::Zero(), false), integrator, 0.001);
    s.advance_to(0.01);
    s.move_node(0, target, 0.02);
    s.advance_to(0.011);
    const Vector3 speed = (target - Vector3(0, 0, 1)) / 0.01;
    CHECK((s.velocity(0) - speed).norm() <= 1e-9);
    const Vector3 given = first_mass * speed + second_mass * rod * rod.dot(speed);
    // In the network also what reactions at the ends of a step leave of it.
    CHECK((s.contact_impulse(0) - given).norm() <= 1e-7);
  }
}

TEST_CASE("a jump within a step of the network is booked too, also without surfaces") {
  const Jump jump = jumps().front();
  constexpr double step = 0.003;  // the jump is in the thirty-fourth
  const Vector3 given = first_mass * jump.jump + second_mass * jump.velocity;
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    Simulation s = simulate(pulled(jump.jump, jump.floor), recurrent(newton, 1e-11, {{"theta", theta}}), step);
    for (int i = 0; i < 34; ++i) s.step();
    // The rod turns by 0.1 m/s in a step meanwhile, of 1 m.
    CHECK((s.contact_impulse(0) - given).norm() <= 2.0 * step * given.norm());
  }
}
