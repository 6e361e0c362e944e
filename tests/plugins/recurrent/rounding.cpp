// Thresholds below the rounding error of the forces: steps settle to the rounding error, note it, and agree with closed
// forms to the rounding of positions.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "../../elements/bodies.hpp"
#include "facts.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double gravity = 9.81;  // m/s^2

// Masses of 1 kg under each other, 1 m apart, the uppermost fixed.
Network hanging_chain(std::uint32_t count, double stiffness, double origin) {
  Network net = chain(count, {origin, 0, origin}, {0, 0, -1}, damped(stiffness, 0.0));
  net.fix(0);
  net.set_gravity({0, 0, -gravity});
  return net;
}

// A bar of 4 x 3 x 3 nodes of 1 g, 1 cm apart, held at one end.
Network bar(double stiffness) {
  Network net;
  Lattice lattice;
  lattice.nodes = {4, 3, 3};
  lattice.spacing = {0.01, 0.01, 0.01};
  lattice.diagonals = Diagonals::all;
  net.add_lattice("bar", lattice, point(Vector3::Zero(), 1e-3), net.add_material(damped(stiffness, 0.0)));
  for (NodeIndex k = 0; k < 36; ++k)
    if (net.nodes()[k].position.x() < 0.001) net.fix(k);
  net.set_gravity({0, 0, -gravity});
  return net;
}

// The note on the limit; empty if there is none.
std::string note_of(const Simulation& simulation) {
  for (const std::string& note : simulation.notes())
    if (note.find("rounding error") != std::string::npos) return note;
  return {};
}

}  // namespace

TEST_CASE("a chain too stiff for its threshold settles, and hangs as the closed form predicts") {
  for (const double origin : {0.0, 1e3}) {
    for (const LawUse& integrator : {recurrent(newton, 0.0), recurrent(automatic, 0.0), recurrent(newton, 1e-12)}) {
      CAPTURE(origin);
      const double stiffness = 1e12;
      const std::uint32_t count = 8;
      Simulation simulation = simulate(hanging_chain(count, stiffness, origin), integrator, 1.0);
      for (int i = 0; i < 5; ++i) CHECK(simulation.step().outcome == Outcome::settled);
      CHECK(simulation.sweeps() <= 30);
      const std::string note = note_of(simulation);
      CAPTURE(note);
      const bool given = integrator.parameters.at("force_tolerance") > 0.0;
      CHECK(has_all(note, {"force_tolerance", given ? " 1e-12 N" : " 9.81e-06 N"}));
      CHECK((note.find("1e-6 of the force scale") == std::string::npos) == given);
      CHECK(simulation.statistics().at("force_rounding") > 0.0);
      const double far = origin + count;
      for (NodeIndex k = 1; k < count; ++k) {
        const double stretch = (simulation.position(k - 1) - simulation.position(k)).norm() - 1.0;
        CHECK(std::abs(stretch - (count - k) * gravity / stiffness) <= 16.0 * eps * far);
      }
    }
  }
}

TEST_CASE("a stiff bar sags as a soft one does, over the stiffness") {
  const Network net = bar(1e10);
  Simulation stiff = simulate(net, recurrent(newton, 0.0), 1.0), soft = simulate(bar(1e4), recurrent(newton, 0.0), 1.0);
  for (int i = 0; i < 3; ++i) {
    CHECK(stiff.step().outcome == Outcome::settled);
    soft.step();
  }
  CHECK(stiff.sweeps() <= 15);
  CHECK_FALSE(note_of(stiff).empty());
  CHECK(note_of(soft).empty());
  // Positions are known to eps, the sag of the soft one has strains of 1e-3.
  for (NodeIndex k = 0; k < 36; ++k) {
    const Vector3 start = net.nodes()[k].position, expected = 1e-6 * (soft.position(k) - start);
    CHECK((stiff.position(k) - start - expected).norm() <= 0.01 * expected.norm() + 100.0 * eps * 0.03);
  }
}

TEST_CASE("rules without derivatives find the rounding limit in a step that does not settle") {
  for (const double update : {synchronous, wavefront, block}) {
    CAPTURE(update);
    Network net = hanging_chain(6, 30.0, 100.0);
    Simulation simulation = simulate(net, recurrent(update, 1e-20), 0.05);
    for (int i = 0; i < 20; ++i) CHECK(simulation.step().outcome == Outcome::settled);
    CHECK_FALSE(note_of(simulation).empty());
    // From then on the limit is known: no later step uses up all its sweeps.
    const std::uint64_t before = simulation.sweeps();
    simulation.step();
    CHECK(simulation.sweeps() - before < 100);
    Simulation exact = simulate(net, recurrent(newton, 1e-12), 0.05);
    exact.advance_to(simulation.time());
    for (NodeIndex k = 0; k < 6; ++k) CHECK((exact.position(k) - simulation.position(k)).norm() <= 1e-10);
  }
}

TEST_CASE("a stiff filling settles to the rounding error of its volume") {
  Network net = filled(icosphere(2, 0.1), 1e-3, 20.0, 1e17, 0.01);
  for (const NodeIndex node : {0u, 5u}) net.add_load({{node}, {0.02, -0.01, 0.03}});
  Simulation simulation = simulate(net, recurrent(newton, 0.0), 0.01);
  for (int i = 0; i < 5; ++i) CHECK(simulation.step().outcome == Outcome::settled);
  CHECK(simulation.sweeps() <= 40);
  CHECK_FALSE(note_of(simulation).empty());
}

TEST_CASE("a well-scaled net has no note on rounding, and keeps its threshold") {
  Simulation simulation = simulate(cube(30.0, 1.0, 1.0, 0.05), recurrent(newton, 0.0), 0.05);
  simulation.advance_to(3.0);
  CHECK(note_of(simulation).empty());
  CHECK(simulation.statistics().count("force_rounding") == 0);
}
