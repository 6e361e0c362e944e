// Which integrator for what: errors, orders and costs of all of them on a few nets, one thread. Prints the table of
// core/docs/propagation.md. --quick: the coarsest steps alone, which shows that it runs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "clock.hpp"
#include "nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

struct Net {
  std::string name;
  Network network;
  double until;  // s
  double step;   // s, the coarsest
};

// Damped springs between masses of 1 kg, 1 m apart, fixed at the top, at rest, under gravity.
Network hanging(double stiffness, double damping) {
  Lattice lattice;
  lattice.nodes = {6, 6, 6};
  lattice.diagonals = Diagonals::all;
  Network net;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(stiffness, damping)));
  for (NodeIndex k = 0; k < net.nodes().size(); ++k)
    if (net.nodes()[k].position.z() > 4.5) net.fix(k);
  net.set_gravity({0.5, 0, -1.0});
  return net;
}

// The same with a stiff chain in it, as a skin or a suture has: a hundred times the frequency of the rest.
Network with_stiff_part() {
  Network net = hanging(200.0, 2.0);
  const MaterialIndex stiff = net.add_material(damped(2e6, 0.0));
  for (SpringIndex s = 0; s < net.springs().size(); ++s) {
    const Spring& spring = net.springs()[s];
    const Vector3 a = net.nodes()[spring.first].position, b = net.nodes()[spring.second].position;
    if (a.x() < 0.5 && b.x() < 0.5 && a.y() < 0.5 && b.y() < 0.5) net.set_spring_material(s, stiff);
  }
  return net;
}

std::vector<Net> nets() {
  return {{"soft, hanging", hanging(200.0, 2.0), 1.0, 0.02},
          {"stiff part", with_stiff_part(), 1.0, 0.02},
          {"cube that falls on a floor", cube(30.0, 1.0, 2.0, 0.05), 0.8, 0.02}};
}

struct Method {
  std::string name;
  LawUse integrator;
  bool chooses_steps = false;
};
std::vector<Method> methods() {
  constexpr double force = 1e-9;  // N
  return {{"`recurrent`, theta 1", recurrent(newton, force)},
          {"`recurrent`, theta 1/2", recurrent(newton, force, {{"theta", 0.5}})},
          {"`recurrent`, theta 1/2, located events", recurrent(newton, force, {{"theta", 0.5}, {"events", 1}})},
          {"`generalized_alpha`, 0", {"generalized_alpha", {{"spectral_radius", 0.0}}}},
          {"`generalized_alpha`, 0.8", {"generalized_alpha", {}}},
          {"`generalized_alpha`, 1", {"generalized_alpha", {{"spectral_radius", 1.0}}}},
          {"`verlet`", {"verlet", {}}},
          {"`cvode`, 1e-4", cvode(1e-4), true},
          {"`cvode`, 1e-6", cvode(1e-6), true}};
}

struct Run {
  double error = std::numeric_limits<double>::quiet_NaN();  // m, greatest of a node
  double seconds = 0.0;                                     // of the processor
};
Run run(const Net& net, const LawUse& integrator, double step, const Simulation& reference) {
  Run result;
  try {
    Simulation s = simulate(net.network, integrator, step);
    const double begun = benchmark::now(benchmark::Clock::thread);
    s.advance_to(net.until);
    result.seconds = benchmark::now(benchmark::Clock::thread) - begun;
    result.error = (s.positions() - reference.positions()).colwise().norm().maxCoeff();
  } catch (const std::exception&) {  // not stable, or not settled
  }
  return result;
}

void print(const Net& net, bool quick) {
  Simulation reference = simulate(net.network, cvode(1e-10), net.step);
  reference.advance_to(net.until);
  const int halvings = quick ? 1 : 3;
  for (const Method& method : methods()) {
    std::vector<Run> runs;
    double step = net.step;
    for (int i = 0; i < (method.chooses_steps ? 1 : halvings); ++i, step *= 0.5)
      runs.push_back(run(net, method.integrator, step, reference));
    const Run& last = runs.back();
    const std::string order = runs.size() < 2 || !(runs[runs.size() - 2].error > 0.0)
                                  ? ""
                                  : fmt::format("{:.1f}", std::log2(runs[runs.size() - 2].error / last.error));
    const auto told = [](double error) { return std::isnan(error) ? std::string("-") : fmt::format("{:.1e}", error); };
    fmt::print("| {} | {} | {} | {} | {} | {:.0f} |\n", net.name, method.name, told(runs.front().error),
               method.chooses_steps ? "" : told(last.error), order, 1e3 * last.seconds);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const bool quick = argc == 2 && std::string_view(argv[1]) == "--quick";
    if (argc > 1 && !quick) {
      fmt::print(stderr, "usage: springnet_integrators_table [--quick]\n");
      return 2;
    }
    fmt::print(
        "| net | integrator | error at 20 ms, m | at 5 ms, m | order | time at 5 ms, ms "
        "|\n|---|---|---|---|---|---|\n");
    for (const Net& net : nets()) print(net, quick);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "springnet_integrators_table: {}\n", error.what());
    return 1;
  }
}
