// The tables of core/docs/propagation.md: sweeps per step that each update rule needs, plain and
// accelerated, on filled spheres and on the
// paper's cube, from soft to stiff. Prints Markdown. Counts, not times, so the same on every machine.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/inspection.hpp>
#include <springnet/simulation.hpp>

#include "../elements/bodies.hpp"

namespace {

using namespace springnet;

constexpr double time_step = 0.05;            // s
constexpr double gravity = 0.2;               // m/s^2
constexpr double tolerance = 1e-6 * gravity;  // N: a millionth of a node's weight
constexpr int step_count = 10;
constexpr double most_sweeps = 5000;
constexpr std::array ratios{0.01, 0.1, 1.0, 10.0, 100.0};

// The cube with masses of 1 kg standing on the floor, its nodes with velocities of a few mm/s at random, which excite
// every mode.
Network standing_cube(double elastic_ratio, double viscous_ratio) {
  Network net = testing::cube(elastic_ratio / (time_step * time_step), viscous_ratio / time_step, gravity, 0.0);
  std::mt19937 random(1);
  const auto speed = [&] { return 1e-2 * (static_cast<double>(random()) * 0x1p-32 - 0.5); };
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    const double x = speed(), y = speed(), z = speed();
    node.velocity = {x, y, node.position.z() > 0.0 ? z : -std::abs(z)};
    net.set_node(k, node);
  }
  return net;
}

struct Run {
  Outcome outcome = Outcome::settled;
  double sweeps = 0.0;    // per step; those of the last step if it did not settle
  double residual = 0.0;  // N, the greatest of all steps
  std::vector<Vector3> positions{};
};

// A column: a rule, and the depth of its acceleration.
struct Column {
  const char* rule;
  double acceleration = 0.0;
};
constexpr Column newton_column{"newton"};
// Newton's method last: it settles in all rows, which the test looks for.
constexpr std::array columns{Column{"synchronous"},  Column{"synchronous", 5}, Column{"wavefront"},
                             Column{"wavefront", 5}, Column{"block"},          Column{"block", 5},
                             Column{"coloured"},     Column{"coloured", 5},    newton_column};

void print_columns(std::size_t others) {
  for (const Column& column : columns) {
    fmt::print(" {}", column.rule);
    if (column.acceleration > 0.0) fmt::print(", {:g}", column.acceleration);
    fmt::print(" |");
  }
  fmt::print("\n|");
  for (std::size_t i = 0; i < others + columns.size(); ++i) fmt::print("---|");
  fmt::print("\n");
}

// force_tolerance: N; h: s.
Run run(const Network& net, const Column& column, double force_tolerance, double h) {
  const ParameterValues more{{"max_sweeps", most_sweeps}, {"acceleration", column.acceleration}};
  Simulation simulation =
      testing::simulate(net, testing::recurrent(testing::update_named(column.rule), force_tolerance, more), h);
  Run result;
  for (int step = 0; step < step_count; ++step) {
    try {
      result.residual = std::max(result.residual, simulation.step().residual);
    } catch (const Error&) {
      const StepReport& report = simulation.last_report();
      return {report.outcome, static_cast<double>(report.sweeps)};
    }
  }
  result.sweeps = static_cast<double>(simulation.sweeps()) / step_count;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) result.positions.push_back(simulation.position(k));
  return result;
}

// "12 (0.3)": sweeps per step, and the greatest residual in units of the threshold. Or how it ended, after how many
// sweeps.
std::string text_of(const Run& run, const Run& newton, double force_tolerance) {
  if (run.outcome != Outcome::settled) return fmt::format("{}, {:.0f}", name_of(run.outcome), run.sweeps);
  // A force off by the threshold moves a node by t^2 F / m in a step; this is far above what ten steps add up to.
  constexpr double alike = 1e-6;  // m
  double distance = 0.0;
  for (std::size_t k = 0; k < run.positions.size() && newton.outcome == Outcome::settled; ++k) {
    distance = std::max(distance, (run.positions[k] - newton.positions[k]).norm());
  }
  if (distance > alike) return fmt::format("elsewhere, {:.0f}", run.sweeps);
  return fmt::format("{:.{}f} ({:.2g})", run.sweeps, run.sweeps < 10.0 ? 1 : 0, run.residual / force_tolerance);
}

// The time step over the largest one of a rule, for the cube with its lowest layer held.
std::string over_limit(Network net, const char* rule) {
  for (NodeIndex k = 0; k < 16; ++k) net.fix(k);
  return fmt::format("{:.2g}", time_step / inspect(net, *testing::plugins()).limit(rule).time_constant);
}

// A sphere of 162 nodes of 1 g, radius 0.1 m, with a skin of 20 N/m and 0.01 N s/m, pulled at two nodes. filling:
// N/m^5.
Network filled_sphere(double filling) {
  Network net = testing::filled(testing::icosphere(2, 0.1), 1e-3, 20.0, filling, 0.01);
  for (const NodeIndex node : {0u, 5u}) net.add_load({{node}, {0.02, -0.01, 0.03}});
  return net;
}

void print_fillings() {
  constexpr double sphere_step = 0.01, sphere_tolerance = 4e-8;  // s, N: a millionth of the load
  fmt::print("| stiffness of the filling, N/m^5 |");
  print_columns(1);
  for (const double filling : {0.0, 1e4, 1e5, 1e6, 1e7, 1e8, 1e10, 1e12}) {
    const Network net = filled_sphere(filling);
    fmt::print("| {:g} |", filling);
    const Run newton = run(net, newton_column, sphere_tolerance, sphere_step);
    for (const Column& column : columns)
      fmt::print(" {} |", text_of(run(net, column, sphere_tolerance, sphere_step), newton, sphere_tolerance));
    fmt::print("\n");
    std::fflush(stdout);
  }
  fmt::print("\n");
}

void print_table() {
  fmt::print("| t²k/m | t d/m | t over limit, synchronous | wavefront |");
  print_columns(4);
  for (const double elastic : ratios) {
    for (const double viscous : ratios) {
      const Network net = standing_cube(elastic, viscous);
      fmt::print("| {:g} | {:g} | {} | {} |", elastic, viscous, over_limit(net, "synchronous"),
                 over_limit(net, "wavefront"));
      const Run newton = run(net, newton_column, tolerance, time_step);
      for (const Column& column : columns)
        fmt::print(" {} |", text_of(run(net, column, tolerance, time_step), newton, tolerance));
      fmt::print("\n");
      std::fflush(stdout);
    }
  }
}

}  // namespace

int main() {
  try {
    print_fillings();
    print_table();
  } catch (const springnet::Error& error) {
    fmt::print(stderr, "springnet_sweeps_table: {}\n", error.what());
    return 1;
  }
}
