// Bodies that are far stiffer than their masses fall aslant on a floor, in steps in which they move by half of their
// spacing: nearly all steps settle, and those satisfy their equations of motion and contact when evaluated by other
// code.
#include <doctest/doctest.h>
#include <springnet/simulation.hpp>

#include "judge.hpp"
#include "nets.hpp"

using namespace springnet;

namespace {

constexpr double frame = 1.0 / 30.0;  // s
constexpr double mass = 1.5e-4;       // kg

struct Body {
  double stiffness, damping, friction;  // N/m, N s/m; of the floor
};

// The floor is level, and gravity comes from aside.
Network falling_block(const Body& body) {
  Network net;
  Lattice lattice;
  lattice.nodes = {5, 4, 3};
  lattice.spacing = Vector3::Constant(0.01);
  lattice.origin = {0, 0, 0.003};
  lattice.diagonals = Diagonals::all;
  net.add_lattice("block", lattice, testing::point(Vector3::Zero(), mass, {0.1, -0.05, -0.3}),
                  net.add_material(testing::damped(body.stiffness, body.damping)));
  Plane floor;
  floor.friction = {body.friction > 0.0 ? Friction::Kind::coulomb : Friction::Kind::none, body.friction};
  net.add_plane(floor);
  net.set_gravity({-4.3, -2.1, -8.6});
  return net;
}

}  // namespace

TEST_CASE(
    "stiff bodies on a floor: no settled step is wrong, and nearly all bodies settle, with friction and without") {
  int settled = 0, bodies = 0;
  for (const double stiffness : {13.5, 50.0, 135.0}) {
    for (const double damping : {0.002, 0.02}) {
      for (const double friction : {0.0, 0.4, 1.0}) {
        CAPTURE(stiffness);
        CAPTURE(damping);
        CAPTURE(friction);
        const Network net = falling_block({stiffness, damping, friction});
        SimulationOptions options;
        options.time_step = frame / 4.0;
        const double tolerance = 1e-8;  // N; a node weighs 1.5e-3 N
        options.integrator = testing::recurrent(testing::newton, tolerance);
        ++bodies;
        settled += testing::settles(net, options, tolerance, 60) ? 1 : 0;
      }
    }
  }
  MESSAGE(settled << " of " << bodies << " bodies settled in every step");
  CHECK(settled >= 15);
}
