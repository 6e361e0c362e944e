// The motion of random mixed networks, integrated again by code of its own from the forces of plain.hpp: a step of
// `verlet` to rounding, and where the other integrators go, to their tolerance or their order.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "generator.hpp"
#include "judge.hpp"
#include "mixture.hpp"
#include "nets.hpp"
#include "repetitions.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Masses, stiffnesses and viscosities over two decades: all of them show within some hundredths of a second. Nothing
// that needs a decision: no contact, no rigid connection, no moved node.
std::optional<Network> smooth_net(std::uint64_t seed) {
  Network network = RandomNet(seed, 1e-2).network;
  if (!network.planes().empty() || !network.rigids().empty() || !network.moves().empty()) return std::nullopt;
  if (network.nodes().size() > 40) return std::nullopt;
  const Mixture mixture(network, seed, 1e-2);
  return network;
}

PlainState start_of(const Network& network) {
  PlainState state;
  for (const Node& node : network.nodes()) {
    state.position.push_back(node.position);
    state.velocity.push_back(node.fixed ? Vector3(Vector3::Zero()) : node.velocity);
  }
  for (const Spring& spring : network.springs()) {
    const std::optional<LawUse>& law = network.materials()[spring.material].spring;
    const double length = (state.position[spring.first] - state.position[spring.second]).norm();
    state.spring_memory.push_back(law ? plain_start(*law, length - spring.rest_length) : 0.0);
  }
  for (const Element& element : network.elements()) {
    const std::optional<LawUse>& law = network.materials()[element.material].spring;
    const bool remembers = law && has_memory(*law);
    const double x = remembers ? plain_invariant_of(element, state).value - element.reference : 0.0;
    state.element_memory.push_back(remembers ? plain_start(*law, x) : 0.0);
  }
  return state;
}

std::vector<Vector3> accelerations(const Network& network, const PlainState& at) {
  const std::vector<bool> springs(network.springs().size(), true), elements(network.elements().size(), true);
  std::vector<Vector3> result = plain_forces(network, at, springs, elements);
  for (std::size_t k = 0; k < result.size(); ++k) {
    const Node& node = network.nodes()[k];
    result[k] = node.fixed ? Vector3(Vector3::Zero()) : Vector3(result[k] / node.mass);
  }
  return result;
}

// to + factor rate; of a rate, `position` is a velocity.
PlainState moved(const PlainState& from, double factor, const PlainState& rate) {
  PlainState to = from;
  for (std::size_t k = 0; k < to.position.size(); ++k) {
    to.position[k] += factor * rate.position[k];
    to.velocity[k] += factor * rate.velocity[k];
  }
  for (std::size_t s = 0; s < to.spring_memory.size(); ++s) to.spring_memory[s] += factor * rate.spring_memory[s];
  for (std::size_t e = 0; e < to.element_memory.size(); ++e) to.element_memory[e] += factor * rate.element_memory[e];
  return to;
}

PlainState rate_of(const Network& network, const PlainState& at) {
  PlainState rate{at.velocity, accelerations(network, at)};
  for (std::size_t s = 0; s < network.springs().size(); ++s) {
    const Spring& spring = network.springs()[s];
    const std::optional<LawUse>& law = network.materials()[spring.material].spring;
    const double x = (at.position[spring.first] - at.position[spring.second]).norm() - spring.rest_length;
    const bool remembers = law && has_memory(*law);
    rate.spring_memory.push_back(remembers ? plain_rate(*law, x, spring.rest_length, at.spring_memory[s]) : 0.0);
  }
  for (std::size_t e = 0; e < network.elements().size(); ++e) {
    const Element& element = network.elements()[e];
    const std::optional<LawUse>& law = network.materials()[element.material].spring;
    const bool remembers = law && has_memory(*law);
    const double x = remembers ? plain_invariant_of(element, at).value - element.reference : 0.0;
    rate.element_memory.push_back(remembers ? plain_rate(*law, x, element.reference, at.element_memory[e]) : 0.0);
  }
  return rate;
}

// Classical Runge-Kutta method.
PlainState integrated(const Network& network, double until, int steps) {
  const double h = until / steps;
  PlainState y = start_of(network);
  for (int i = 0; i < steps; ++i) {
    const PlainState a = rate_of(network, y), b = rate_of(network, moved(y, 0.5 * h, a)),
                     c = rate_of(network, moved(y, 0.5 * h, b)), d = rate_of(network, moved(y, h, c));
    y = moved(moved(moved(moved(y, h / 6.0, a), h / 3.0, b), h / 3.0, c), h / 6.0, d);
  }
  return y;
}

// Not a number if a place is not.
double distance(const PlainState& a, const PlainState& b) {
  double greatest = 0.0;
  for (std::size_t k = 0; k < a.position.size(); ++k) {
    const double own = (a.position[k] - b.position[k]).norm();
    if (!(own <= greatest)) greatest = own;
    if (std::isnan(own)) return own;
  }
  return greatest;
}

}  // namespace

TEST_CASE("mixed random networks: steps of verlet are those of its formula, to rounding") {
  const std::uint64_t count = repetitions("SPRINGNET_RANDOM_NETS", 200);
  std::size_t judged = 0;
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    CAPTURE(seed);
    const std::optional<Network> network = smooth_net(seed);
    if (!network) continue;
    constexpr double h = 1e-4;  // s, far below the limit of most
    Simulation simulation = simulate(*network, {"verlet", {}}, h);
    PlainState own = start_of(*network);
    std::vector<Vector3> acceleration = accelerations(*network, own);
    try {
      for (int step = 0; step < 4; ++step) {
        const PlainState start = own;
        std::vector<Vector3> half = own.velocity;
        for (std::size_t k = 0; k < half.size(); ++k) {
          half[k] += 0.5 * h * acceleration[k];
          own.position[k] += h * half[k];
          own.velocity[k] = half[k] + 0.5 * h * acceleration[k];
        }
        advance_memory(*network, start, own, h, 2);
        acceleration = accelerations(*network, own);
        for (std::size_t k = 0; k < half.size(); ++k) own.velocity[k] = half[k] + 0.5 * h * acceleration[k];
        simulation.step();
        if (!simulation.events().empty()) break;  // a rupture: what goes on is another network
        const PlainState found = state_of(simulation);
        double worst = 0.0;
        for (std::size_t k = 0; k < half.size(); ++k) {
          // Some hundred roundings of the terms that add up to an acceleration.
          const double speed = 1e-12 * (1.0 + own.velocity[k].norm() + h * acceleration[k].norm()) +
                               1e-13 * h * force_scale(*network) / network->nodes()[k].mass;
          worst = std::max(worst, (found.velocity[k] - own.velocity[k]).norm() / speed);
          worst = std::max(worst, (found.position[k] - own.position[k]).norm() / (1e-14 * 100.0 + h * speed));
        }
        CAPTURE(step);
        CHECK(worst <= 1.0);
      }
      ++judged;
    } catch (const Error& error) {  // above the limit of stability
      CHECK(error.kind() == ErrorKind::simulation);
    }
  }
  MESSAGE(judged << " networks");
  CHECK(judged >= count / 6);
}

TEST_CASE("mixed random networks: every integrator goes where the plain formulas lead, in its order") {
  const std::uint64_t count = repetitions("SPRINGNET_RANDOM_NETS", 200) / 2;
  std::size_t compared = 0;
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    CAPTURE(seed);
    const std::optional<Network> network = smooth_net(seed);
    if (!network) continue;
    constexpr double until = 0.02;  // s
    const PlainState truth = integrated(*network, until, 400), check = integrated(*network, until, 200);
    const double uncertain = distance(truth, check), travel = distance(truth, start_of(*network));
    // Too stiff for these steps, as relaxation in some microseconds is.
    if (!(uncertain < 1e-7)) continue;
    const auto error = [&](const LawUse& integrator, int steps) {
      Simulation simulation = simulate(*network, integrator, until / steps);
      simulation.advance_to(until);
      if (!simulation.events().empty()) return std::optional<double>();
      return std::optional(distance(state_of(simulation), truth));
    };
    struct Method {
      std::string name;
      LawUse integrator;
      int order;
    };
    const double force = 1e-10 * force_scale(*network);
    const Method methods[] = {{"theta 1", recurrent(newton, force), 1},
                              {"theta 1/2", recurrent(newton, force, {{"theta", 0.5}}), 2},
                              {"verlet", {"verlet", {}}, 2},
                              {"generalized_alpha", generalized_alpha(), 2},
                              {"generalized_alpha, 0", generalized_alpha(0.0), 2}};
    try {
      const std::optional<double> reference = error(cvode(1e-10), 1);
      if (!reference) continue;
      CHECK(*reference <= 1e-7 + 10.0 * uncertain);  // m, some hundred steps to 1e-10 of about 1 m
      for (const Method& method : methods) {
        CAPTURE(method.name);
        std::optional<double> coarse = error(method.integrator, 20), fine = error(method.integrator, 80);
        if (!coarse || !fine) continue;
        CAPTURE(travel);
        // A quarter of the step: 1/4 or 1/16 of the error, but for yield and damage, whose rates have a kink, and for
        // modes that the long steps do not resolve.
        const double share = method.order == 1 ? 0.35 : 0.15;
        const auto falls = [&] { return *fine <= share * *coarse + 2e-7 + 1e-5 * travel; };
        if (!falls()) {  // errors may cancel by chance, where they change their sign between lengths of the step
          coarse = fine;
          fine = error(method.integrator, 320);
          if (!fine) continue;
        }
        CAPTURE(*coarse);
        CAPTURE(*fine);
        CHECK(falls());
        CHECK(*fine <= (method.order == 1 ? 0.1 : 5e-3) * travel + 2e-7);
      }
      ++compared;
    } catch (const Error& failure) {
      CHECK(failure.kind() == ErrorKind::simulation);
    }
  }
  MESSAGE(compared << " networks compared");
  CHECK(compared >= count / 10);
}
