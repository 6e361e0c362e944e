// Motions that are not smooth as a part of the cost.

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/learn.hpp>

#include "learning_nets.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;

namespace {

constexpr double time_step = 0.02, seen_to = 0.01;  // s, m

// A mass on a stiff spring that rings, beside a soft one that is seen; both hang.
Network ringing(double stiffness, double damping) {
  Network net = chain(4, {0, 0, 0}, {0.5, 0, -0.2}, damped(stiffness, damping));
  net.fix(0);
  net.set_gravity({0, 0, -9.81});
  return net;
}

Observations seen(const Network& net, const SimulationOptions& options, std::uint64_t seed, int steps = 40) {
  Simulation simulation(net, plugins(), options);
  Observations result = observe(simulation, steps, {2, 3}, seen_to, seed);
  for (Observations::VectorRow& each : result.positions) each.weight.setConstant(1.0 / (seen_to * seen_to));
  return result;
}

// 1/2 the sum of the squares as the docs tell them, from simulations alone.
double cost_of(const Network& net, const SimulationOptions& options, const Observations& observed, double smoothness,
               int steps = 40) {
  Simulation simulation(net, plugins(), options);
  std::vector<Eigen::Matrix3Xd> velocities{simulation.velocities()};
  double cost = 0.0;
  std::size_t next = 0;
  for (int k = 1; k <= steps; ++k) {
    simulation.step();
    velocities.push_back(simulation.velocities());
    for (; next < observed.positions.size() && observed.positions[next].time <= simulation.time() + 1e-9; ++next) {
      const Observations::VectorRow& row = observed.positions[next];
      cost += 0.5 * row.weight[0] * (simulation.position(row.node) - row.value).squaredNorm();
    }
  }
  for (std::size_t k = 1; k + 1 < velocities.size(); ++k)
    cost +=
        0.5 * ((velocities[k + 1] - 2.0 * velocities[k] + velocities[k - 1]) / (time_step * smoothness)).squaredNorm();
  return cost;
}

std::vector<Learnable> both(const Network& net) {
  return {select_learnable(net, *plugins(), "spring.stiffness:together"),
          select_learnable(net, *plugins(), "viscosity.damping:together")};
}

}  // namespace

TEST_CASE("a search with smoothness ends at the minimum of the cost that simulations alone tell") {
  const SimulationOptions options = to_learn_with(0.5, time_step);
  const Observations observed = seen(ringing(80.0, 0.4), options, 3);
  const Network guess = ringing(60.0, 0.8);
  for (const Optimiser optimiser : {Optimiser::levenberg_marquardt, Optimiser::lbfgs}) {
    CAPTURE(static_cast<int>(optimiser));
    for (const double smoothness : {30.0, 3.0}) {
      CAPTURE(smoothness);
      LearnOptions how;
      how.optimiser = optimiser;
      how.smoothness = smoothness;
      const LearnedNet learned = learn({experiment(guess, options, observed)}, plugins(), both(guess), how);
      REQUIRE(learned.parameters.size() == 6);
      const double k = learned.parameters[0].value, d = learned.parameters[3].value;
      const double least = cost_of(ringing(k, d), options, observed, smoothness);
      CHECK(learned.cost == doctest::Approx(least).epsilon(1e-6));
      // A minimum: along both axes the cost grows by nearly the same on either side.
      for (const bool of_damping : {false, true}) {
        CAPTURE(of_damping);
        const auto at = [&](double share) {
          return cost_of(ringing(of_damping ? k : k * (1.0 + share), of_damping ? d * (1.0 + share) : d), options,
                         observed, smoothness);
        };
        const double more = at(1e-2) - least, less = at(-1e-2) - least;
        CHECK(more > 0.0);
        CHECK(less > 0.0);
        // Where the slope is 0 they differ by the third derivative alone, a few hundredths of them.
        CHECK(std::abs(more - less) < 0.1 * (more + less));
      }
    }
  }
}

TEST_CASE("smoothness is no observation") {
  const SimulationOptions options = to_learn_with(0.5, time_step);
  const Network guess = ringing(60.0, 0.8);
  const Observations observed = seen(ringing(80.0, 0.4), options, 3);
  const auto learned_with = [&](double smoothness) {
    LearnOptions how;
    how.smoothness = smoothness;
    return learn({experiment(guess, options, observed)}, plugins(), both(guess), how);
  };
  const double none = std::numeric_limits<double>::infinity();
  const LearnedNet plain = learned_with(none), weak = learned_with(1e4), strong = learned_with(0.2);
  CHECK(weak.observed == plain.observed);
  CHECK(strong.observed == plain.observed);
  // One that hardly counts changes nothing, and one that does fits worse, with more damping.
  CHECK(weak.parameters[0].value == doctest::Approx(plain.parameters[0].value).epsilon(1e-5));
  CHECK(weak.rms == doctest::Approx(plain.rms).epsilon(1e-6));
  CHECK(weak.parameters[3].upper - weak.parameters[3].lower ==
        doctest::Approx(plain.parameters[3].upper - plain.parameters[3].lower).epsilon(1e-4));
  CHECK(strong.rms > 1.05 * plain.rms);
  CHECK(strong.parameters[3].value > 1.1 * plain.parameters[3].value);
  // rms is of what was observed: that of the values without the smoothness.
  const double own = cost_of(ringing(strong.parameters[0].value, strong.parameters[3].value), options, observed, none);
  CHECK(strong.rms == doctest::Approx(std::sqrt(2.0 * own / static_cast<double>(strong.observed))).epsilon(1e-6));
}

TEST_CASE("smoothness is of each experiment, beside a guess, whatever the memory") {
  const SimulationOptions options = to_learn_with(0.5, time_step);
  const Network real = ringing(80.0, 0.4), guess = ringing(60.0, 0.8);
  Network pushed = guess;
  pushed.set_gravity({3.0, 0, -9.81});
  Network really_pushed = real;
  really_pushed.set_gravity({3.0, 0, -9.81});
  const Observations first = seen(real, options, 3), second = seen(really_pushed, options, 4, 30);
  constexpr double smoothness = 5.0, weight = 20.0;
  const auto learned_in = [&](std::size_t memory) {
    LearnOptions how;
    how.smoothness = smoothness;
    how.guess_weight = weight;
    how.memory = memory;
    return learn({experiment(guess, options, first), experiment(pushed, options, second)}, plugins(), both(guess), how);
  };
  const LearnedNet learned = learned_in(std::size_t{1} << 30);
  const auto all = [&](double k, double d) {
    Network other = ringing(k, d);
    const double of_first = cost_of(other, options, first, smoothness);
    other.set_gravity({3.0, 0, -9.81});
    // The damping is not searched by its logarithm.
    const double stiff = (k - 60.0) / 60.0, damping = (d - 0.8) / 0.8;
    return of_first + cost_of(other, options, second, smoothness, 30) +
           0.5 * weight * (stiff * stiff + damping * damping);
  };
  const double k = learned.parameters[0].value, d = learned.parameters[3].value, least = all(k, d);
  CHECK(learned.cost == doctest::Approx(least).epsilon(1e-6));
  CHECK(learned.smooth_cost > 0.0);
  CHECK(learned.smooth_cost < learned.cost);
  for (const bool of_damping : {false, true}) {
    CAPTURE(of_damping);
    const auto at = [&](double share) {
      return all(of_damping ? k : k * (1.0 + share), of_damping ? d * (1.0 + share) : d) - least;
    };
    CHECK(at(1e-2) > 0.0);
    CHECK(at(-1e-2) > 0.0);
    CHECK(std::abs(at(1e-2) - at(-1e-2)) < 0.1 * (at(1e-2) + at(-1e-2)));
  }
}

TEST_CASE("what smoothness alone determines stays as it found it, and intervals are what the data say") {
  // Of two chains one is seen; the dampings of the other, which rings, are in no observation.
  const SimulationOptions options = to_learn_with(0.5, time_step);
  const auto two = [](double damping) {
    Network net = ringing(80.0, 0.4);
    const MaterialIndex material = net.add_material(damped(80.0, damping));
    NodeIndex before = 0;
    for (const double x : {0.5, 1.0, 1.5}) {
      const NodeIndex next = net.add_node(point({x, 3.0, -0.4 * x}));
      net.add_spring(before, next, material);
      before = next;
    }
    return net;
  };
  const Network net = two(0.1);
  const std::vector<std::uint32_t> unseen{3, 4, 5};
  Learnable damping;
  damping.values = {LearnedValues::Kind::viscosity_parameter, false, "damping", unseen};
  damping.together = true;
  LearnOptions how;
  how.smoothness = 2.0;
  const Observations of_both = seen(net, options, 5);
  const LearnedNet learned = learn({experiment(net, options, of_both)}, plugins(), {damping}, how);
  CHECK(learned.undetermined == 1);
  const double found = learned.parameters[0].value;
  CHECK(std::abs(found - 0.1) > 0.05);
  CHECK(learned.cost == doctest::Approx(cost_of(two(found), options, of_both, how.smoothness)).epsilon(1e-6));
  CHECK(learned.cost < cost_of(net, options, of_both, how.smoothness));

  const Network guess = ringing(60.0, 0.8);
  const Observations observed = seen(ringing(80.0, 0.4), options, 3);
  const LearnedNet plain = learn({experiment(guess, options, observed)}, plugins(), both(guess), {});
  how.smoothness = 0.2;
  const LearnedNet strong = learn({experiment(guess, options, observed)}, plugins(), both(guess), how);
  const auto middle = [](const LearnedParameter& each) { return 0.5 * (each.lower + each.upper); };
  const LearnedParameter &own = strong.parameters[3], &without = plain.parameters[3];
  // As far as the model is linear over the way between both.
  CHECK(std::abs(middle(own) - without.value) < 0.5 * std::abs(own.value - without.value));
}

TEST_CASE("a smoothness that is none is refused") {
  const SimulationOptions options = to_learn_with(0.5, time_step);
  const Network guess = ringing(60.0, 0.8);
  for (const double wrong : {0.0, -1.0, std::nan("")}) {
    CAPTURE(wrong);
    LearnOptions how;
    how.smoothness = wrong;
    CHECK(refusal_of([&] {
            static_cast<void>(
                learn({experiment(guess, options, seen(guess, options, 1))}, plugins(), both(guess), how));
          }).find("changes of accelerations is") != std::string::npos);
  }
}
