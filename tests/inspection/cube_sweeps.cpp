// The paper's cube from soft to stiff: rules with a limit settle exactly below it, the others always.
#include <array>
#include <random>
#include <string>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/inspection.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"

using namespace springnet;

namespace {

constexpr double time_step = 0.05;       // s
constexpr double cube_tolerance = 1e-7;  // N; rounding leaves 1e-10 N of the stiffest springs, 40,000 N/m

// Fixed at its lower nodes, with small random velocities, so that every motion occurs. Without a floor: contact would
// stop divergence.
Network held_cube(double elastic_ratio, double viscous_ratio) {
  Network net;
  Lattice lattice;
  lattice.nodes = {4, 4, 4};
  lattice.diagonals = Diagonals::space;
  const Material material = testing::damped(elastic_ratio / (time_step * time_step), viscous_ratio / time_step);
  net.add_lattice("cube", lattice, Node{}, net.add_material(material));
  std::mt19937 random(1);
  const auto speed = [&] { return 1e-3 * (static_cast<double>(random()) * 0x1p-32 - 0.5); };
  for (NodeIndex k = 16; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    const double x = speed(), y = speed(), z = speed();
    node.velocity = {x, y, z};
    net.set_node(k, node);
  }
  for (NodeIndex k = 0; k < 16; ++k) net.fix(k);
  return net;
}

bool settles(const Network& net, const char* rule) {
  Simulation simulation = testing::simulate(
      net, testing::recurrent(testing::update_named(rule), cube_tolerance, {{"max_sweeps", 5000.0}}), time_step);
  try {
    simulation.step();
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

TEST_CASE("the cube, from soft to stiff, settles exactly below the limit of the rule") {
  constexpr std::array ratios{0.01, 0.1, 1.0, 10.0, 100.0};
  for (const double elastic : ratios) {
    for (const double viscous : ratios) {
      const Network net = held_cube(elastic, viscous);
      const Inspection found = inspect(net, *testing::plugins());
      for (const char* const rule : testing::update_rules) {
        CAPTURE(elastic);
        CAPTURE(viscous);
        const std::string name(rule);
        CAPTURE(name);
        const TimeConstantLimit& limit = found.limit(rule);
        // None of the 25 lies within a tenth of a limit.
        const bool expected = limit.kind == TimeConstantLimit::Kind::none || time_step < limit.time_constant;
        CHECK(settles(net, rule) == expected);
      }
    }
  }
}
