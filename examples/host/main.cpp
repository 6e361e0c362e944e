// A program that embeds springnet: a block of soft material hangs from its upper side, is pulled, is cut through, and
// its lower half falls. Prints one quantity per line, with its unit in the name.
#include <cstdio>
#include <memory>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

namespace {

using springnet::Vector3;

constexpr double mass = 1e-3;     // kg, of a node
constexpr double gravity = 9.81;  // m/s^2
constexpr springnet::NodeIndex layer = 5 * 5, layers = 4, nodes = layer * layers, first_fixed = nodes - layer;

// 5 x 5 x 4 nodes, 1 cm apart, with all diagonals; the upper layer is fixed.
springnet::Network hanging_block() {
  springnet::Network network;
  const auto material = network.add_material({.spring = springnet::LawUse{"linear", {{"stiffness", 100.0}}},   // N/m
                                              .viscosity = springnet::LawUse{"linear", {{"damping", 0.1}}}});  // N s/m
  network.add_lattice("block",
                      {.nodes = {5, 5, layers},
                       .spacing = Vector3::Constant(0.01),
                       .origin = Vector3::Zero(),
                       .diagonals = springnet::Diagonals::all},
                      {.mass = mass}, material);
  for (springnet::NodeIndex node = first_fixed; node < nodes; ++node) network.fix(node);
  network.set_gravity({0.0, 0.0, -gravity});
  return network;
}

// Upward force that holds the fixed nodes against all springs and their own weight, N.
double holding_force(const springnet::Simulation& simulation) {
  double sum = 0.0;
  for (springnet::NodeIndex node = first_fixed; node < nodes; ++node) sum += simulation.reaction(node).z();
  return sum;
}

// Mean height of the two lower layers, m. The map refers to the engine's own memory; columns() has the column of each
// of the user's nodes.
double height_of_lower_half(const springnet::Simulation& simulation) {
  const springnet::ConstNodeMap positions = simulation.positions();
  double sum = 0.0;
  for (springnet::NodeIndex node = 0; node < 2 * layer; ++node) sum += positions(2, simulation.columns()[node]);
  return sum / (2 * layer);
}

void run() {
  auto plugins = std::make_shared<const springnet::PluginHost>(springnet::PluginHost::with_default_search());
  springnet::Simulation simulation(hanging_block(), plugins, {.time_step = 5e-4});
  std::printf("nodes %zu\nsprings %zu\n", simulation.node_count(), simulation.spring_count());

  simulation.advance_to(1.5);
  std::printf("weight_N %.9g\nholding_force_at_rest_N %.9g\n", nodes * mass * gravity, holding_force(simulation));
  std::printf("lowest_point_at_rest_m %.9g\n", simulation.positions().row(2).minCoeff());

  // An instrument pulls at the middle of the lower side.
  const springnet::NodeIndex middle = layer / 2;
  simulation.set_force(middle, {0.0, 0.0, -0.2});
  simulation.advance_to(3.0);
  std::printf("holding_force_pulled_N %.9g\n", holding_force(simulation));
  std::printf("lowest_point_pulled_m %.9g\n", simulation.positions().row(2).minCoeff());

  // It lets go, and a cut between the second and the third layer releases the lower half.
  simulation.set_force(middle, Vector3::Zero());
  const double before = height_of_lower_half(simulation);
  const std::size_t removed =
      simulation.cut_polygon({{-1, -1, 0.0145}, {1, -1, 0.0145}, {1, 1, 0.0145}, {-1, 1, 0.0145}});
  std::printf("springs_cut %zu\nsprings_left %zu\n", removed, simulation.live_spring_count());
  for (int step = 0; step < 100; ++step) simulation.step();
  std::printf("fall_in_100_steps_m %.9g\n", before - height_of_lower_half(simulation));
}

}  // namespace

int main() {
  try {
    run();
  } catch (const springnet::Error& error) {
    std::fprintf(stderr, "host: %s\n", error.what());
    return 1;
  }
}
