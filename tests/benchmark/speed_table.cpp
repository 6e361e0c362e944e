// Speed of whole explicit steps against the naive loop (naive.h) of the same net, in the same run, and what each
// computes: the program fails if results differ. Prints Markdown for core/docs/propagation.md.
//
// A step is one synchronous sweep, symplectic Euler. Each figure is that of the fastest of many short stretches of
// steps, taken in turn with those of the naive loop: what else runs on the machine is left out as far as possible.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <springnet/mesh.hpp>
#include <springnet/simulation.hpp>

#include "clock.hpp"
#include "layers/instruction_set.hpp"
#include "naive_net.hpp"
#include "nets.hpp"
#include "simulation/model.hpp"
#include "steps_report.hpp"
#include "table_nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::benchmark;

constexpr const char* usage =
    "usage: springnet_speed_table [OPTION ...]\n"
    "Prints the speed of explicit steps and that of the naive loop, in millions of springs a second, as Markdown.\n"
    "  --only NAME   only this row\n"
    "  --quick       smaller nets, a few steps: shows that results are right\n"
    "  --list        print the names of the rows\n";

constexpr double time_step = 1e-3;  // s
constexpr double stiffness = 100.0, damping = 0.1;

// ---- nets -----------------------------------------------------------------------------------------------------------

// Small velocities of all nodes: a net at rest would time multiplications with zero.
Network stirred(Network net) {
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    node.velocity = 1e-2 * Vector3(std::sin(1.0 + k), std::sin(2.0 + 3.0 * k), std::sin(3.0 + 7.0 * k));
    net.set_node(k, node);
  }
  return net;
}

// Axial and space-diagonal springs between n^3 masses of 1 kg, 1 m apart.
Network lattice(std::uint32_t n, const Material& material) {
  Network net;
  Lattice shape;
  shape.nodes = {n, n, n};
  shape.diagonals = Diagonals::space;
  net.add_lattice("lattice", shape, Node{}, net.add_material(material));
  return stirred(std::move(net));
}

// The same with a stiffness, a damping and a rest length for each spring.
Network varied_lattice(std::uint32_t n) {
  Network net = lattice(n, testing::damped(stiffness, damping));
  std::mt19937 random(1);
  const auto factor = [&] { return 0.9 + 0.2 * static_cast<double>(random()) * 0x1p-32; };
  for (SpringIndex s = 0; s < net.springs().size(); ++s) {
    net.set_spring_material(s, net.add_material(testing::damped(stiffness * factor(), damping * factor())));
    net.set_rest_length(s, net.springs()[s].rest_length * factor());
  }
  return net;
}

// Edges of tetrahedra whose points are numbered at random, of one material; 53 points a side have a million.
Network tetrahedra(std::uint32_t points_a_side) {
  const Mesh mesh = tissue_mesh(points_a_side);
  Network net;
  for (const Vector3& point : mesh.points) net.add_node(testing::point(1000.0 * point));
  const MaterialIndex material = net.add_material(testing::damped(stiffness, damping));
  for (const Edge& edge : edges_of(mesh)) net.add_spring(edge.first, edge.second, material);
  return stirred(std::move(net));
}

LawUse use(const char* id, ParameterValues values) { return {id, std::move(values)}; }
const LawUse dashpot = use("linear", {{"damping", damping}});

struct Row {
  const char* name;
  std::function<Network(bool quick)> make;
  // Floors of the ratios to the naive loop, for one and two threads; 0: none.
  double floor = 0.0, floor_2 = 0.0;
  const char* beside = nullptr;  // a row before, whose speed its own is compared with
  double floor_beside = 0.0;
  bool is_of_file = false;  // against the naive loop in the order of the file
  bool is_plain = true;     // the naive loop has its laws
};

std::vector<Row> rows() {
  const auto plain = [](std::uint32_t n, std::uint32_t fewer) {
    return [=](bool quick) { return lattice(quick ? fewer : n, testing::damped(stiffness, damping)); };
  };
  const auto of = [](LawUse spring, LawUse viscosity) {
    return [=](bool quick) { return lattice(quick ? 12 : 32, {spring, viscosity}); };
  };
  const auto mesh = [](bool quick) { return tetrahedra(quick ? 16 : 53); };
  return {
      {"lattice-4", plain(4, 4), 1.3, 1.3},
      {"lattice-32", plain(32, 20), 2.2, 4.0},
      {"lattice-100", plain(100, 26), 1.8, 3.4},
      {"tetrahedra", mesh, 1.6, 2.9},
      {"tetrahedra-of-file", mesh, 4.0, 7.0, nullptr, 0.0, true},
      {"parameters", [](bool quick) { return varied_lattice(quick ? 12 : 32); }, 1.5, 2.7},
      {"rupturing", of(use("rupturing", {{"stiffness", stiffness}, {"strength", 1e3}}), dashpot), 0.0, 0.0,
       "lattice-32", 0.9},
      {"exponential", of(use("exponential", {{"stiffness", stiffness}, {"exponent", 3.0}}), dashpot), 0.0, 0.0,
       "lattice-32", 1.0 / 1.6, false, false},
      {"power", of(use("linear", {{"stiffness", stiffness}}), use("power", {{"damping", damping}, {"exponent", 1.5}})),
       0.0, 0.0, "lattice-32", 1.0 / 1.6, false, false},
  };
}

// ---- measuring ------------------------------------------------------------------------------------------------------

// The fastest of stretches of steps, s for a step.
class Stretches {
 public:
  Stretches(std::function<void()> step, Clock clock) : step_(std::move(step)), clock_(clock) {}

  void take(double least) {
    const double start = now(clock_);
    for (std::size_t i = 0; i < count_; ++i) step_();
    const double spent = now(clock_) - start;
    fastest_ = std::min(fastest_, spent / static_cast<double>(count_));
    if (spent < least) count_ *= 2;
  }
  [[nodiscard]] double fastest() const noexcept { return fastest_; }

 private:
  std::function<void()> step_;
  Clock clock_;
  std::size_t count_ = 1;
  double fastest_ = std::numeric_limits<double>::infinity();
};

SimulationOptions single_sweeps(unsigned threads, InstructionSet set = InstructionSet::best) {
  SimulationOptions options;
  options.time_step = time_step;
  options.integrator = testing::single_sweep();
  options.threads = threads;
  options.instruction_set = set;
  return options;
}

// Positions by the user's numbers, m.
std::vector<Vector3> positions_of(const Simulation& simulation) {
  std::vector<Vector3> result;
  for (const std::uint32_t column : simulation.columns()) result.emplace_back(simulation.positions().col(column));
  return result;
}

// After some steps the bits must be those of one thread and the plainest instructions, and the positions those of the
// naive loop but for rounding. Throws std::runtime_error.
void check_results(const Network& net, bool is_plain) {
  constexpr int steps = 10;
  // Sums of some tens of terms in other orders, and the naive loop contracts: some ulps of coordinates of up to 1000 m
  // in each of the steps.
  constexpr double rounding = 1e-11;  // m
  const auto run = [&](const SimulationOptions& options) {
    Simulation simulation(net, testing::plugins(), options);
    for (int i = 0; i < steps; ++i) simulation.step();
    return positions_of(simulation);
  };
  const std::vector<Vector3> reference = run(single_sweeps(1, InstructionSet::generic));
  for (const unsigned threads : {1u, 2u})
    if (run(single_sweeps(threads)) != reference)
      throw std::runtime_error(fmt::format("checksum: {} threads do not give the bits of the generic code", threads));
  if (!is_plain) return;
  const Model model(net, *testing::plugins(), single_sweeps(1));
  PlainNet naive(net, model.layout);
  for (int i = 0; i < steps; ++i) naive.step(time_step);
  double worst = 0.0;
  for (std::uint32_t k = 0; k < naive.nodes().size(); ++k) {
    const double* const p = naive.nodes()[k].position;
    worst = std::max(worst, (Vector3(p[0], p[1], p[2]) - reference[model.layout.ordering().user[k]]).norm());
  }
  if (!(worst <= rounding))
    throw std::runtime_error(fmt::format("checksum: positions differ by {:.3g} m from those of the naive loop", worst));
}

struct Speeds {
  std::size_t nodes = 0, springs = 0;
  double naive = std::nan(""), one = 0.0, two = 0.0;  // springs/s
};

Speeds measure(const Row& row, bool quick) {
  const Network net = row.make(quick);
  check_results(net, row.is_plain);
  Speeds speeds{net.nodes().size(), net.springs().size()};
  const double stretch = quick ? 0.0 : 0.02, most = quick ? 0.0 : 4.0;  // s
  std::optional<PlainNet> naive;
  std::optional<Stretches> naive_steps;
  if (row.is_plain) {
    const Model model(net, *testing::plugins(), single_sweeps(1));
    naive.emplace(net, model.layout, row.is_of_file ? PlainNet::Order::file : PlainNet::Order::engine);
    naive_steps.emplace([&] { naive->step(time_step); }, Clock::thread);
  }
  Simulation one(net, testing::plugins(), single_sweeps(1)), two(net, testing::plugins(), single_sweeps(2));
  Stretches one_steps([&] { one.step(); }, Clock::thread), two_steps([&] { two.step(); }, Clock::wall);
  const layers::FlushDenormals flush;
  const double start = now(Clock::wall);
  do {
    if (naive_steps) naive_steps->take(stretch);
    one_steps.take(stretch);
    two_steps.take(stretch);
  } while (now(Clock::wall) - start < most);
  const auto springs = static_cast<double>(speeds.springs);
  if (naive_steps) speeds.naive = springs / naive_steps->fastest();
  speeds.one = springs / one_steps.fastest();
  speeds.two = springs / two_steps.fastest();
  return speeds;
}

std::string number(double value, const char* form) {
  return std::isnan(value) ? std::string() : fmt::format(fmt::runtime(form), value);
}
std::string with_floor(double ratio, double floor) {
  if (std::isnan(ratio)) return {};
  return floor > 0.0 ? fmt::format("{:.2f} ({:g})", ratio, floor) : fmt::format("{:.2f}", ratio);
}

int run(const std::optional<std::string>& only, bool quick) {
  const Surroundings where = surroundings();
  fmt::print("{}, {}, {}, instruction set {}\n\n", where.date, where.processor, where.compiler, where.instruction_set);
  fmt::print("| net | springs | naive | one thread | two | one / naive (floor) | two / naive | beside |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  std::vector<std::pair<std::string, double>> done;
  bool found = false;
  for (const Row& row : rows()) {
    if (only && *only != row.name) continue;
    found = true;
    Speeds speeds;
    try {
      speeds = measure(row, quick);
    } catch (const std::exception& error) {
      throw std::runtime_error(fmt::format("{}: {}", row.name, error.what()));
    }
    std::string beside;
    for (const auto& [name, speed] : done)
      if (row.beside != nullptr && name == row.beside)
        beside =
            fmt::format("{} of {}", with_floor(speeds.one / speed, std::round(100 * row.floor_beside) / 100), name);
    fmt::print("| {} | {} | {} | {:.0f} | {:.0f} | {} | {} | {} |\n", row.name, speeds.springs,
               number(speeds.naive * 1e-6, "{:.0f}"), speeds.one * 1e-6, speeds.two * 1e-6,
               with_floor(speeds.one / speeds.naive, row.floor), with_floor(speeds.two / speeds.naive, row.floor_2),
               beside);
    std::fflush(stdout);
    done.emplace_back(row.name, speeds.one);
  }
  if (!found) throw std::invalid_argument(fmt::format("--only '{}' names no row; --list prints them", *only));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    std::optional<std::string> only;
    bool quick = false;
    for (int k = 1; k < argc; ++k) {
      const std::string_view name = argv[k];
      if (name == "--only" && k + 1 < argc) {
        only = argv[++k];
      } else if (name == "--quick") {
        quick = true;
      } else if (name == "--list") {
        for (const Row& row : rows()) fmt::print("{}\n", row.name);
        return 0;
      } else if (name == "--help" || name == "-h") {
        fmt::print("{}", usage);
        return 0;
      } else {
        throw std::invalid_argument(fmt::format("unknown or incomplete argument '{}'\n{}", name, usage));
      }
    }
    return run(only, quick);
  } catch (const std::invalid_argument& error) {
    fmt::print(stderr, "springnet_speed_table: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "springnet_speed_table: {}\n", error.what());
    return 1;
  }
}
