// Laws with any number of internal states that a law may have.
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/host_laws.hpp>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;
namespace sdk = springnet::sdk;

constexpr std::size_t most = 8;
constexpr const char* ids[most] = {"one", "two", "three", "four", "five", "six", "seven", "eight"};

double relaxation_time(std::size_t state) { return 0.03 * static_cast<double>((state + 1) * (state + 1)); }

template <std::size_t N>
constexpr std::array<sdk::Parameter, N> states_of() {
  std::array<sdk::Parameter, N> states{};
  for (std::size_t j = 0; j < N; ++j)
    states[j] = sdk::number(ids[j], "N", "relaxes").preset(static_cast<double>(j + 1)).learnable(1);
  return states;
}

// A tension of parts that relax independently of each other.
template <std::size_t N>
struct Relaxing : sdk::SpringFunction {
  static constexpr const char *id = ids[N - 1], *summary = "T = sum of z_j, z_j' = -z_j / tau_j";
  static constexpr std::array<sdk::Parameter, N> states = states_of<N>();
  static auto force(const auto& e, const auto&) {
    return [&]<std::size_t... J>(std::index_sequence<J...>) { return (e.state(J) + ...) + 0.0 * e.q; }
    (std::make_index_sequence<N>());
  }
  static auto state_rates(const auto& e, const auto&) {
    return [&]<std::size_t... J>(std::index_sequence<J...>) {
      return std::array{-e.state(J) * (1.0 / relaxation_time(J))...};
    }
    (std::make_index_sequence<N>());
  }
};

// What one step makes of z' = -z / tau: backward Euler, or its extrapolation from two half steps.
double factor_of_step(int order, double share) {
  if (order == 1) return 1.0 / (1.0 + share);
  return 2.0 / ((1.0 + 0.5 * share) * (1.0 + 0.5 * share)) - 1.0 / (1.0 + share);
}

// A spring between two nodes that do not move.
Network held(const LawUse& law) {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}));
  for (NodeIndex node : {0u, 1u}) {
    springnet::Node fixed = net.nodes()[node];
    fixed.fixed = true;
    net.set_node(node, fixed);
  }
  net.add_spring(0, 1, net.add_material({law, std::nullopt}), 1.0);
  return net;
}

template <std::size_t N>
void check_relaxing() {
  CAPTURE(N);
  const auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  host->add(spring_function(Relaxing<N>{}));
  constexpr double step = 0.02, end = 0.3;
  constexpr int steps = 15;
  for (const StateMethod& method : state_methods(1e-9)) {
    CAPTURE(method.name);
    SimulationOptions options;
    options.time_step = step;
    options.integrator = method.integrator;
    Simulation simulation(held({ids[N - 1], {}}), host, options);
    simulation.advance_to(end);
    double tension = 0.0;
    const std::vector<double> states = simulation.internal_states(0);
    REQUIRE(states.size() == N);
    for (std::size_t j = 0; j < N; ++j) {
      const double tau = relaxation_time(j);
      const double share =
          method.order == 0 ? std::exp(-end / tau) : std::pow(factor_of_step(method.order, step / tau), steps);
      // CVODE: to its tolerance over some hundred steps; the others: to the rounding of the equations that they solve.
      CHECK(states[j] == doctest::Approx(static_cast<double>(j + 1) * share).epsilon(method.order == 0 ? 1e-7 : 1e-11));
      tension += states[j];
    }
    CHECK(simulation.tension(0) == doctest::Approx(tension).epsilon(1e-14));
  }
}

}  // namespace

TEST_CASE("laws with one to eight states relax as their closed forms, in every integrator") {
  // Those between take minutes to compile.
  check_relaxing<1>();
  check_relaxing<2>();
  check_relaxing<5>();
  check_relaxing<most>();
}
