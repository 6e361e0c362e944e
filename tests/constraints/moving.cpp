// Nodes whose position is prescribed: where they are, what moving them takes, what they move.

#include <doctest/doctest.h>

#include <numbers>

#include "schemes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double frequency = 0.8, amplitude = 0.05, stiffness = 50.0, mass = 0.4;  // Hz, m, N/m, kg
constexpr double turn = 2.0 * std::numbers::pi * frequency;                        // rad/s

// A mass on a spring whose other end is shaken along it.
Network shaken() {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}, mass));
  net.add_spring(0, 1, net.add_material(damped(stiffness, 0.0)), 1.0);
  Move move;
  move.nodes = {0};
  move.motion.amplitude = {amplitude, 0, 0};
  move.motion.frequency = frequency;
  net.add_move(move);
  return net;
}

}  // namespace

TEST_CASE("a mass on a shaken spring follows the closed form, and moving the spring takes its force") {
  // m x'' = -k (x - A sin wt), from rest: x = A w0^2 / (w0^2 - w^2) (sin wt - w / w0 sin w0 t).
  const Network net = shaken();
  const double natural = std::sqrt(stiffness / mass), time = 0.9;
  const double gain = amplitude * natural * natural / (natural * natural - turn * turn);
  const double x = gain * (std::sin(turn * time) - turn / natural * std::sin(natural * time));
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation simulation = simulate(net, scheme.integrator, 0.001);
    simulation.advance_to(time);
    // Phase errors of order h w0^2 t / 2 and h^2 w0^3 t / 12 a radian.
    const double share = scheme.order == 1.0 ? 0.06 : scheme.order == 2.0 ? 3e-4 : 1e-6;
    CHECK(std::abs(simulation.position(1)[0] - 1.0 - x) <= share * gain);
    const double moved = amplitude * std::sin(turn * time);
    CHECK(simulation.position(0)[0] == doctest::Approx(moved).epsilon(1e-14));
    CHECK(simulation.velocity(0)[0] == doctest::Approx(amplitude * turn * std::cos(turn * time)).epsilon(1e-12));
    // What moves the node accelerates its own mass, 1 kg, and stretches the spring.
    const double stretch = simulation.position(1)[0] - simulation.position(0)[0] - 1.0;
    const double force = -amplitude * turn * turn * std::sin(turn * time) - stiffness * stretch;
    CHECK(simulation.reaction(0)[0] == doctest::Approx(force).epsilon(1e-9));
  }
}

TEST_CASE("the work of moving a node goes into the net") {
  // A spring between a node that is pulled 0.2 m in 1 s, then rests, and a fixed one; the work is the spring's energy.
  Network net;
  net.add_node(point({0, 0, 0}, 0.1));
  net.add_node(point({1, 0, 0}, 0.1));
  net.fix(1);
  net.add_spring(0, 1, net.add_material(damped(stiffness, 0.0)), 1.0);
  Move move;
  move.nodes = {0};
  move.motion.times = {0.0, 1.0};
  move.motion.displacements = {Vector3::Zero(), Vector3(-0.2, 0, 0)};
  net.add_move(move);
  for (const Scheme& scheme : all_schemes(1e-9)) {
    INFO(scheme.name);
    Simulation simulation = simulate(net, scheme.integrator, 0.005);
    double work = 0.0;
    Vector3 force = simulation.reaction(0), velocity = simulation.velocity(0);
    for (int i = 0; i < 240; ++i) {
      simulation.step();
      const double power = force.dot(velocity);
      force = simulation.reaction(0);
      velocity = simulation.velocity(0);
      work += 0.5 * 0.005 * (power + force.dot(velocity));
    }
    CHECK((simulation.position(0) - Vector3(-0.2, 0, 0)).norm() <= 1e-12);
    CHECK(simulation.velocity(0).norm() == 0.0);
    // The trapezoidal sum over 200 steps of a smooth power: relative error about (pi / 200)^2 / 12.
    CHECK(work == doctest::Approx(0.5 * stiffness * 0.04).epsilon(1e-3));
  }
}

TEST_CASE("a host moves a node and a surface from where they are to where it says") {
  Network net = shaken();
  Plane floor;
  floor.name = "floor";
  floor.point = {0, 0, -1};
  net.add_plane(floor);
  for (const Scheme& scheme :
       {Scheme{"recurrent", recurrent(newton, 1e-9), 1.0}, Scheme{"cvode", cvode(1e-8), 0.0},
        Scheme{"verlet", {"verlet", {}}, 2.0}, Scheme{"generalized_alpha", generalized_alpha(), 2.0}}) {
    INFO(scheme.name);
    Simulation simulation = simulate(net, scheme.integrator, 0.01);
    simulation.advance_to(0.1);
    const Vector3 before = simulation.position(0);
    simulation.move_node(0, before + Vector3(0, 0.1, 0), 0.2);
    simulation.move_surface(0, {0, 0, -0.9}, 0.3);
    simulation.advance_to(0.15);
    // To the rounding of the times.
    CHECK((simulation.position(0) - before - Vector3(0, 0.05, 0)).norm() <= 1e-12);
    CHECK((simulation.velocity(0) - Vector3(0, 1.0, 0)).norm() <= 1e-9);
    CHECK((simulation.surface_position(0) - Vector3(0, 0, -0.975)).norm() <= 1e-12);
    simulation.advance_to(0.4);
    CHECK((simulation.position(0) - before - Vector3(0, 0.1, 0)).norm() <= 1e-12);
    CHECK(simulation.velocity(0).norm() == 0.0);
    CHECK((simulation.surface_position(0) - Vector3(0, 0, -0.9)).norm() <= 1e-12);
    CHECK_THROWS_AS(simulation.move_node(0, before, 0.3), std::exception);  // that time is past
  }
}

namespace {

// A node of 0.1 kg on a table that moves.
Network on_table(const Motion& motion, const Friction& friction, double drag, double gravity) {
  Network net;
  Node node = point({0, 0, 0}, 0.1);
  if (drag > 0.0) node.neuron = net.add_neuron({"dragged", {{"drag", drag}}});
  net.add_node(node);
  net.set_gravity({0, 0, -gravity});
  Plane table;
  table.friction = friction;
  table.motion = motion;
  net.add_plane(table);
  return net;
}

Motion path(const std::vector<double>& times, const std::vector<Vector3>& places,
            Motion::Interpolation interpolation = Motion::Interpolation::smooth) {
  Motion motion;
  motion.times = times;
  motion.displacements = places;
  motion.interpolation = interpolation;
  return motion;
}

}  // namespace

TEST_CASE("a table that sinks fast leaves a node in a viscous medium behind, held or not") {
  // It sinks at its terminal velocity m g / b, not faster: 0.05 m/s, reached with a time constant of 0.1 s, while the
  // table goes 0.08 m in 1 s.
  const Motion motion = path({0, 1}, {Vector3::Zero(), {0, 0, -0.08}});
  double height = 0.0;
  for (const Friction::Kind kind : {Friction::Kind::none, Friction::Kind::held}) {
    Friction friction;
    friction.kind = kind;
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name);
      Simulation simulation = simulate(on_table(motion, friction, 1.0, 0.5), scheme.integrator, 0.002);
      simulation.advance_to(1.0);
      if (height == 0.0) height = simulation.position(0).z();
      CHECK(simulation.position(0).z() > -0.046);
      CHECK(simulation.position(0).z() == doctest::Approx(height).epsilon(0.01));  // released within a step or so
      CHECK(simulation.velocity(0).z() == doctest::Approx(-0.05).epsilon(0.01));
    }
  }
}

TEST_CASE("results of the reference do not depend on how often they are queried, where nodes leave a shaken table") {
  Motion motion;
  motion.frequency = 2.0;
  for (const bool drags : {false, true}) {
    CAPTURE(drags);
    motion.amplitude = {0.1, 0, drags ? 0.05 : 0.065};  // m: it throws the node, with up to 0.8 m/s
    const Network net = on_table(motion, {}, drags ? 1.0 : 0.0, 9.81);
    double x[2];
    for (int i = 0; i < 2; ++i) {
      Simulation simulation = simulate(net, cvode(1e-9), i == 0 ? 0.01 : 0.0002);
      simulation.advance_to(0.5);
      x[i] = simulation.position(0).x();
      CHECK(simulation.events().size() < 10);  // held, thrown, held again
    }
    CHECK(x[0] > 0.03);  // where it came down
    CHECK(x[0] == doctest::Approx(x[1]).epsilon(1e-6));
  }
}

TEST_CASE("a table without friction that moves along itself leaves a node where it is") {
  Friction none;
  none.kind = Friction::Kind::none;
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation simulation =
        simulate(on_table(path({0, 0.5}, {Vector3::Zero(), {1, 0, 0}}), none, 0.0, 9.81), scheme.integrator, 0.02);
    simulation.advance_to(0.5);
    CHECK(simulation.position(0).norm() <= 1e-15);
  }
}

TEST_CASE("a table whose velocity jumps to its opposite throws nodes that do not stick to it") {
  // 3 m/s up for 0.1 s, then down: the node flies from 0.3 m on, 0.3 + 3 t - g t^2 / 2.
  const Motion motion =
      path({0, 0.1, 0.2}, {Vector3::Zero(), {0, 0, 0.3}, Vector3::Zero()}, Motion::Interpolation::linear);
  for (const double coefficient : {0.0, 0.5}) {
    Friction friction;
    friction.kind = coefficient > 0.0 ? Friction::Kind::coulomb : Friction::Kind::none;
    friction.coefficient = coefficient;
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name);
      Simulation simulation = simulate(on_table(motion, friction, 0.0, 9.81), scheme.integrator, 0.001);
      simulation.advance_to(0.3);
      // First order: g t h / 2 behind in the fall.
      CHECK(simulation.position(0).z() == doctest::Approx(0.3 + 0.6 - 0.5 * 9.81 * 0.04).epsilon(0.005));
    }
  }
}

TEST_CASE(
    "a surface that leaves nodes behind at the kinks of a sampled table is named once, and advised to be smooth") {
  for (const bool sampled : {true, false}) {
    Network net;
    for (const double x : {0.0, 0.5}) net.add_node(point({x, 0, 0}));
    net.set_gravity({0, 0, -0.1});
    Plane plane;
    plane.name = "lift";
    plane.motion.emplace();
    plane.motion->interpolation = Motion::Interpolation::linear;
    // Up to 0.4 m and down again as a cosine, or up and still as somebody wrote it down.
    const int entries = sampled ? 21 : 3;
    for (int i = 0; i < entries; ++i) {
      plane.motion->times.push_back(0.1 * i);
      plane.motion->displacements.emplace_back(
          0, 0, sampled ? 0.2 * (1.0 - std::cos(3.14159265 * 0.1 * i)) : std::min(0.05 * i, 0.05));
    }
    net.add_plane(plane);
    for (const Scheme& scheme : all_schemes(1e-9)) {
      INFO(scheme.name);
      Simulation s = simulate(net, scheme.integrator, 0.01);
      s.advance_to(0.9);
      std::size_t released = 0, events = 0;
      for (const Event& event : s.events()) released += event.kind == Event::Kind::released ? 1 : 0;
      for (const std::string& note : s.notes()) {
        if (note.find("plane 'lift'") == std::string::npos) continue;
        ++events;
        CHECK(note.find("linear table") != std::string::npos);
        CHECK(note.find("interpolation = \"smooth\"") != std::string::npos);
      }
      CHECK(released >= 2);
      CHECK(events == (sampled ? 1 : 0));
    }
  }
}

TEST_CASE("a tool that a program tells before each step where it is at its end keeps what it presses") {
  // A node on a spring between the floor and a plate that comes down, more and less slowly, by up to 0.1 m.
  constexpr double step = 0.01, mass = 0.05;
  Network net;
  Node foot = point({0, 0, 0});
  foot.fixed = true;
  net.add_node(foot);
  net.add_node(point({0, 0, 1}, mass));
  net.add_spring(0, 1, net.add_material(damped(200.0, 1.0)));
  const auto height = [](double time) { return 0.95 + 0.05 * std::cos(4.0 * time); };
  for (const Friction::Kind kind : {Friction::Kind::held, Friction::Kind::none, Friction::Kind::coulomb}) {
    Network pressed = net;
    pressed.add_plane({.name = "plate", .point = {0, 0, height(0.0)}, .normal = {0, 0, -1}, .friction = {kind, 0.5}});
    for (const double update : {newton, synchronous, wavefront, block}) {
      CAPTURE(update);
      Simulation s = simulate(pressed, recurrent(update, 1e-9), step);
      s.move_surface(0, {0, 0, height(step)}, step);
      s.step();
      const std::size_t events = s.events().size();
      for (int i = 2; i * step < 0.75; ++i) {  // the plate turns back at 0.785 s
        s.move_surface(0, {0, 0, height(i * step)}, i * step);
        s.step();
        // It is where it was told, and still moves as it did.
        const double speed = (height(i * step) - height((i - 1) * step)) / step;
        CHECK(s.surface_position(0).z() == doctest::Approx(height(i * step)).epsilon(1e-12));
        CHECK(s.surface_velocity(0).z() == doctest::Approx(speed).epsilon(1e-9));
        CHECK(s.touching(1));
        CHECK(s.position(1).z() == doctest::Approx(height(i * step)).epsilon(1e-12));
        // Spring and damper press; the plate feels no stop.
        CHECK(s.surface_force(0).z() == doctest::Approx(200.0 * (1.0 - height(i * step)) - 1.0 * speed).epsilon(1e-9));
      }
      CHECK(s.events().size() == events);  // no node separates where the plate becomes slower
      // Told nothing more, it stops: at once for the next step, in which the spring holds the node against it.
      s.step();
      CHECK(s.surface_velocity(0) == Vector3::Zero());
      CHECK(s.touching(1));
    }
  }
}

TEST_CASE("impulses of a tool that a program moves by fits and starts are what the node's momentum shows") {
  constexpr double step = 0.01, mass = 0.05;
  Network net;
  net.add_node(point({0, 0, 0}, mass));
  net.add_plane({.name = "bat", .point = {0, 0, 0}, .normal = {0, 0, 1}, .friction = {Friction::Kind::none}});
  for (const LawUse& integrator : {recurrent(newton, 1e-12), recurrent(wavefront, 1e-12), cvode(1e-10),
                                   LawUse{"verlet", {}}, generalized_alpha()}) {
    INFO(integrator.id);
    Simulation s = simulate(net, integrator, step);
    double height = 0.0;
    int i = 0;
    for (const double speed : {0.1, 0.0, 0.2, 0.5, 0.5, 0.3, 0.9, 0.0, 1.0, 1.0}) {
      height += speed * step;
      s.move_surface(0, {0, 0, height}, ++i * step);
      s.step();
      CHECK(s.position(0).z() >= height - 1e-12);
      CHECK((mass * s.velocity(0) - s.contact_impulse(0)).norm() <= 1e-9);
      CHECK((s.surface_impulse(0) + s.contact_impulse(0)).norm() <= 1e-12);
    }
    // It flew off when the bat stopped, which has not caught up with it.
    CHECK(s.velocity(0).z() == doctest::Approx(0.9).epsilon(1e-6));
  }
}

TEST_CASE("until the next step a tool has the velocity that it had, whatever it is told") {
  constexpr double step = 0.01;
  Network net;
  net.add_node(point({0, 0, 0}, 0.1));
  net.set_gravity({0, 0, -9.81});
  net.add_plane({.name = "belt", .friction = {Friction::Kind::coulomb, 0.2}});
  for (const LawUse& integrator : {recurrent(newton, 1e-12), cvode(1e-10), LawUse{"verlet", {}}, generalized_alpha()}) {
    INFO(integrator.id);
    Simulation s = simulate(net, integrator, step);
    for (int i = 1; i <= 3; ++i) {
      s.move_surface(0, {0.5 * i * step, 0, 0}, i * step);
      s.step();
    }
    // The node slips back on the belt, which pulls it on by 0.2 times its weight: as read before and after the next
    // call.
    const Vector3 pull = s.reaction(0);
    CHECK(pull.x() == doctest::Approx(0.2 * 0.981).epsilon(1e-6));
    const Vector3 velocity = s.surface_velocity(0);
    CHECK(velocity.x() == doctest::Approx(0.5).epsilon(1e-9));
    const LocalForce before = s.local_surface_force(0);
    for (const double x : {0.0, 0.5 * 4 * step}) {  // told twice
      s.move_surface(0, {x, 0, 0}, 4 * step);
      CHECK(s.surface_velocity(0).x() == doctest::Approx(velocity.x()).epsilon(1e-9));
      CHECK((s.reaction(0) - pull).norm() <= 1e-9);
      CHECK((s.surface_force(0) + pull).norm() <= 1e-9);
      CHECK((s.local_surface_force(0).stiffness - before.stiffness).norm() <= 1e-6 * (1.0 + before.stiffness.norm()));
    }
    s.step();
    CHECK(s.touching(0));
    CHECK(s.surface_position(0).x() == doctest::Approx(0.5 * 4 * step));
  }
}
