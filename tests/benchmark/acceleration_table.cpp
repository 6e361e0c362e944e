// The table of accelerated sweeps in core/docs/propagation.md: sweeps per step from the start of each net, and
// milliseconds of processor time. Prints Markdown.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"
#include "table_nets.hpp"

namespace {

using namespace springnet;
using benchmark::Case;

constexpr int step_count = 20;
constexpr int repetitions = 3;

struct Row {
  std::string name;
  Case one;
  std::vector<double> time_steps;  // s
};

std::vector<Row> rows() {
  std::vector<Row> all;
  all.push_back({"cube", benchmark::example("cube"), {0.05, 0.1, 0.2}});
  all.push_back({"tube", benchmark::example("tube"), {0.00025, 0.0005, 0.0025}});
  all.push_back({"bladder", benchmark::example("bladder"), {0.001, 0.005, 0.02}});
  all.push_back({"sheet", benchmark::example("sheet"), {0.0004, 0.0008, 0.002, 0.01}});
  for (const std::uint32_t n : {8u, 16u})
    all.push_back({fmt::format("lattice {}", n), benchmark::hanging_lattice(n, 2e4), {0.002, 0.005, 0.02}});
  return all;
}

struct TableColumn {
  double update;
  double depth;  // of the acceleration
};
constexpr TableColumn columns[] = {{testing::newton, 0},      {testing::synchronous, 0},  {testing::synchronous, 2},
                                   {testing::synchronous, 5}, {testing::synchronous, 10}, {testing::wavefront, 0},
                                   {testing::wavefront, 5}};

double processor_time() {  // s, of this thread
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::string cell(const Case& one, double time_step, const TableColumn& column) {
  SimulationOptions options = one.options;
  options.threads = 1;
  options.time_step = time_step;
  options.integrator.parameters["update"] = column.update;
  if (column.depth > 0) options.integrator.parameters["acceleration"] = column.depth;
  double fastest = std::numeric_limits<double>::infinity();
  std::uint64_t sweeps = 0;
  for (int i = 0; i < repetitions; ++i) {
    Simulation simulation(one.network, testing::plugins(), options);
    sweeps = 0;
    const double begin = processor_time();
    for (int step = 0; step < step_count; ++step) {
      try {
        sweeps += simulation.step().sweeps;
      } catch (const Error&) {
        return std::string(name_of(simulation.last_report().outcome));
      }
    }
    fastest = std::min(fastest, processor_time() - begin);
  }
  const double mean = static_cast<double>(sweeps) / step_count, milliseconds = 1e3 * fastest / step_count;
  return fmt::format("{:.{}f} ({:.{}f})", mean, mean < 10.0 ? 1 : 0, milliseconds,
                     milliseconds < 0.1    ? 3
                     : milliseconds < 1.0  ? 2
                     : milliseconds < 10.0 ? 1
                                           : 0);
}

}  // namespace

int main() {
  try {
    fmt::print("| scene, time step, s | `newton` | `synchronous` 0 | 2 | 5 | 10 | `wavefront` 0 | 5 |\n");
    fmt::print("|---|---|---|---|---|---|---|---|\n");
    for (const Row& row : rows()) {
      for (const double time_step : row.time_steps) {
        fmt::print("| {}, {:g} |", row.name, time_step);
        for (const TableColumn& column : columns) fmt::print(" {} |", cell(row.one, time_step, column));
        fmt::print("\n");
        std::fflush(stdout);
      }
    }
  } catch (const Error& error) {
    fmt::print(stderr, "springnet_acceleration_table: {}\n", error.what());
    return 1;
  }
}
