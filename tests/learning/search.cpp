// How learn() searches: its optimisers, several starts, experiments in threads, states from which it goes on.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/host_laws.hpp>

#include "facts.hpp"
#include "learning_nets.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;
namespace sdk = springnet::sdk;
using Kind = LearnedValues::Kind;

namespace {

const SimulationOptions options_of_chain = to_learn_with(0.5, 0.05);

// A chain that hangs from one end, on whose other end a force pulls.
Network pulled_chain(double stiffness, double damping, const Vector3& force) {
  Network net = chain(4, {0, 0, 0}, {0, 0, -1}, damped(stiffness, damping));
  net.fix(0);
  net.set_gravity({0, 0, -2});
  Load load;
  load.nodes = {3};
  load.force = force;
  net.add_load(load);
  return net;
}

// The same chain under three loads, seen with noise; the search begins away from its values, 30 and 1.
std::vector<Experiment> three_loads(double noise, double stiffness = 20.0, double damping = 2.0) {
  std::vector<Experiment> result;
  std::uint64_t seed = 1;
  for (const Vector3& force : {Vector3(3, 0, 0), Vector3(0, 2, 1), Vector3(-1, 1, -2)}) {
    Simulation real(pulled_chain(30.0, 1.0, force), plugins(), options_of_chain);
    // Of different lengths, so that threads end at different times.
    Observations seen = observe(real, 14 + 4 * static_cast<int>(seed), from_to(1, 4), noise, seed);
    result.push_back(experiment(pulled_chain(stiffness, damping, force), options_of_chain, std::move(seen)));
    ++seed;
  }
  return result;
}

std::vector<Learnable> each_stiffness_and_a_damping() {
  return {{{Kind::spring_parameter, false, "stiffness", from_to(0, 3)}},
          {{Kind::viscosity_parameter, false, "damping", from_to(0, 3)}, true}};
}

void check_same(const LearnedNet& a, const LearnedNet& b) {
  CHECK(a.values == b.values);
  CHECK(a.cost == b.cost);
  CHECK(a.reason == b.reason);
  CHECK(a.singular_values == b.singular_values);
  CHECK(to_json(a) == to_json(b));
}

}  // namespace

TEST_CASE("all optimisers find the same minimum of a net with noise, within bounds too") {
  const std::vector<Experiment> seen = three_loads(0.01);
  for (const double most : {1e9, 27.0}) {
    CAPTURE(most);
    std::vector<Learnable> learnables = each_stiffness_and_a_damping();
    learnables[0].upper = most;
    LearnOptions options;
    options.tolerance = 1e-13;
    options.max_iterations = 5000;
    const LearnedNet right = learn(seen, plugins(), learnables, options);
    CAPTURE(right.reason);
    for (const Optimiser optimiser : {Optimiser::lbfgs, Optimiser::descent}) {
      CAPTURE(std::string(name_of(optimiser)));
      options.optimiser = optimiser;
      const LearnedNet found = learn(seen, plugins(), learnables, options);
      CAPTURE(found.reason);
      CAPTURE(found.history.size());
      // A cost that is known to 1e-13 or so of itself fixes values to its root.
      CHECK(found.cost == doctest::Approx(right.cost).epsilon(1e-10));
      REQUIRE(found.parameters.size() == right.parameters.size());
      for (std::size_t k = 0; k < found.parameters.size(); ++k) {
        CAPTURE(k);
        CHECK(found.parameters[k].value == doctest::Approx(right.parameters[k].value).epsilon(1e-5));
        CHECK(found.parameters[k].at_bound == right.parameters[k].at_bound);
      }
      CHECK(found.history.back().cost == found.cost);
    }
  }
}

TEST_CASE("experiments in one, two, three and more threads give the same bits") {
  const std::vector<Experiment> seen = three_loads(0.01);
  for (const Optimiser optimiser : {Optimiser::levenberg_marquardt, Optimiser::lbfgs}) {
    LearnOptions options;
    options.optimiser = optimiser;
    options.max_iterations = 8;
    options.threads = 1;
    const LearnedNet one = learn(seen, plugins(), each_stiffness_and_a_damping(), options);
    for (const unsigned threads : {2u, 3u, 7u, 0u}) {
      CAPTURE(threads);
      options.threads = threads;
      check_same(learn(seen, plugins(), each_stiffness_and_a_damping(), options), one);
    }
  }
}

TEST_CASE("what experiments in threads throw is told, of the first of them") {
  std::vector<Experiment> seen = three_loads(0.0);
  // Far below the chain a rod falls. In the last two experiments it falls flat on a floor, at a time that is located,
  // which is not differentiated; in the second one later.
  for (std::size_t k = 0; k < 3; ++k) {
    Network net = *seen[k].network;
    Plane floor;
    floor.name = "floor";
    floor.point = {0, 0, k == 1 ? -100.2 : -100.05};
    if (k > 0) net.add_plane(floor);
    Node end = net.nodes()[1];
    end.fixed = false;
    end.velocity = {0, 0, -1};
    end.position = {0, 0, -100};
    const NodeIndex first = net.add_node(end);
    end.position.x() = 1.0;
    net.add_rigid(first, net.add_node(end));
    seen[k].network = std::make_shared<const Network>(net);
    seen[k].options.integrator.parameters["events"] = 1.0;
  }
  const auto message_of = [](const std::vector<Experiment>& experiments, unsigned threads) {
    LearnOptions options;
    options.threads = threads;
    options.stages = 1;
    try {
      static_cast<void>(learn(experiments, plugins(), each_stiffness_and_a_damping(), options));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string first = message_of({seen[0], seen[1]}, 1);
  CAPTURE(first);
  CHECK(has(first, "the coincidence of events of node"));
  CHECK(message_of({seen[0], seen[2]}, 1) != first);
  for (const unsigned threads : {1u, 2u, 3u}) CHECK(message_of(seen, threads) == first);
  LearnOptions options;
  options.threads = 1000000;
  CHECK(has(refusal_of([&] { static_cast<void>(learn(seen, plugins(), each_stiffness_and_a_damping(), options)); }),
            "threads must be 0 to"));
}

TEST_CASE("a search steps back from motions that have no derivative, and tells so") {
  // Below the motion of the start is a floor. Softer springs reach it, and its friction is not learned from a rigidly
  // connected node.
  const auto chain_with = [](double stiffness, bool has_floor) {
    Network net = pulled_chain(stiffness, 1.0, {0, 0, -1});
    net.add_rigid(2, 3);
    Plane floor;
    floor.name = "floor";
    floor.point = {0, 0, -3.5};
    floor.friction = {Friction::Kind::coulomb, 0.3};
    if (has_floor) net.add_plane(floor);
    return net;
  };
  SimulationOptions options = options_of_chain;
  options.integrator.parameters["events"] = 1.0;
  Simulation real(chain_with(20.0, false), plugins(), options);
  const Experiment seen = experiment(chain_with(60.0, true), options, observe(real, 40, from_to(1, 4)));
  const Learnable friction{{Kind::friction, false, "", {0}}};
  for (const int starts : {1, 2}) {
    CAPTURE(starts);
    LearnOptions search;
    search.starts = starts;
    const LearnedNet learned = learn(
        {seen}, plugins(), {{{Kind::spring_parameter, false, "stiffness", from_to(0, 2)}, true}, friction}, search);
    CAPTURE(learned.reason);
    CHECK(learned.failure.empty());
    CHECK(learned.cost < learned.start_cost);
    CHECK(learned.values[0] < 60.0);
    CHECK(learned.values[0] > 20.0);
    const bool is_told = std::any_of(learned.notes.begin(), learned.notes.end(), [](const std::string& note) {
      return has(note, "stepped back") && has(note, "the friction of a surface is not learned from");
    });
    CHECK(is_told == (starts == 1));  // of several, it need not be the best that stepped back
  }
  // If it is there at once, nothing was found.
  const Experiment soft = experiment(chain_with(20.0, true), options, seen.observations);
  CHECK_THROWS_AS(static_cast<void>(learn({soft}, plugins(), {friction})), Error);
}

TEST_CASE("laws that may be called in the program's own thread alone are, whatever the number of threads") {
  const std::thread::id own = std::this_thread::get_id();
  for (const bool is_for_one : {false, true}) {
    CAPTURE(is_for_one);
    const auto elsewhere = std::make_shared<std::atomic<int>>(0);
    auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
    const auto description =
        describe("seen", "Hooke's law", sdk::number("stiffness", "N/m", "").at_least(0).learnable(20.0));
    const auto force = [elsewhere, own](const auto& e, const auto& p) {
      if (std::this_thread::get_id() != own) ++*elsewhere;
      return p[0] * e.elongation();
    };
    host->add(spring_function(is_for_one ? description.calling_thread_only() : description, force));
    std::vector<Experiment> seen = three_loads(0.0);
    for (Experiment& each : seen) {
      Network net = chain(4, {0, 0, 0}, {0, 0, -1}, {LawUse{"seen", {{"stiffness", 20.0}}}, std::nullopt});
      net.fix(0);
      each.network = std::make_shared<const Network>(net);
    }
    LearnOptions options;
    options.threads = 3;
    options.max_iterations = 1;
    options.stages = 1;
    // On a busy machine the own thread may have done it all before another one begins.
    for (int attempt = 0; attempt < (is_for_one ? 1 : 100) && *elsewhere == 0; ++attempt)
      static_cast<void>(
          learn(seen, host, {{{Kind::spring_parameter, false, "stiffness", from_to(0, 3)}, true}}, options));
    CHECK((*elsewhere > 0) == !is_for_one);
  }
}

TEST_CASE("several starts find the minimum that the first one misses, and tell how far they differ") {
  // A mass on a spring that swings for some periods: a stiffness with one period more in this time fits better than
  // those between.
  const Network guess = oscillator(damped(100.0, 0.05), 2.0, 0.1);
  const SimulationOptions options_of_swing = to_learn_with(0.5, 0.05);
  Simulation real(oscillator(damped(20.0, 0.05), 2.0, 0.1), plugins(), options_of_swing);
  const Experiment seen = experiment(guess, options_of_swing, observe(real, 120, {1}));
  std::vector<Learnable> learnables{{{Kind::spring_parameter, false, "stiffness", {0}}}};
  LearnOptions options;
  options.stages = 1;
  const LearnedNet one = learn({seen}, plugins(), learnables, options);
  CAPTURE(one.reason);
  CHECK(std::abs(one.parameters[0].value - 20.0) > 1.0);
  // The wrong minimum is told as such, and the right one is not.
  CAPTURE(one.fit.share_of_motion);
  CHECK(has(one.fit.warning, "of the motion that was observed"));
  CHECK(has(one.fit.warning, "--starts"));
  CHECK(one.starts.empty());
  CHECK(std::isnan(one.parameters[0].starts_lower));
  options.starts = 8;
  options.start_factor = 10.0;
  std::vector<int> starts_told;
  double done = 0.0;
  options.on_iteration = [&](const LearnProgress& now) {
    if (starts_told.empty() || starts_told.back() != now.start) starts_told.push_back(now.start);
    CHECK(now.done >= done);
    CHECK(now.done <= 1.0);
    done = now.done;
    return true;
  };
  const LearnedNet best = learn({seen}, plugins(), learnables, options);
  CHECK(best.parameters[0].value == doctest::Approx(20.0).epsilon(1e-6));
  CHECK(best.cost < 1e-6 * one.cost);
  CHECK(best.fit.warning.empty());
  CHECK(best.fit.share_of_motion < 1e-3);
  REQUIRE(best.starts.size() == 8);
  CHECK(starts_told.size() == 8);
  CHECK(best.starts[0].cost == one.cost);
  CHECK_FALSE(best.starts[0].is_as_good);
  std::size_t as_good = 0;
  double lower = HUGE_VAL, upper = 0.0;
  for (const LearnedStart& each : best.starts) {
    CHECK(each.cost >= best.cost);
    CHECK(each.cost <= each.start_cost);
    if (!each.is_as_good) continue;
    ++as_good;
    lower = std::min(lower, each.values[0]);
    upper = std::max(upper, each.values[0]);
  }
  CHECK(as_good >= 1);
  CHECK(as_good < 8);
  CHECK(best.parameters[0].starts_lower == lower);
  CHECK(best.parameters[0].starts_upper == upper);
  CHECK(upper - lower < 1e-3);
  CHECK(best.history.back().cost == best.cost);
  REQUIRE(!best.notes.empty());
  CHECK(has(best.notes.back(), std::to_string(as_good) + " of 8 starts"));
  CHECK(has(to_json(best), "\"as_good\": true"));
  // The same numbers give the same starts, others other ones; bounds hold for all.
  options.on_iteration = nullptr;
  check_same(learn({seen}, plugins(), learnables, options), best);
  options.seed = 2;
  options.max_iterations = 0;
  learnables[0].lower = 50.0;
  const LearnedNet others = learn({seen}, plugins(), learnables, options);
  CHECK(others.starts[1].start_cost != best.starts[1].start_cost);
  int at_bound = 0;
  for (const LearnedStart& each : others.starts) {
    CHECK(each.values[0] >= 50.0);
    CHECK(each.values[0] <= 1000.0);
    if (each.values[0] == 50.0) ++at_bound;
  }
  CHECK(at_bound > 0);
  for (const auto& [starts, factor] : {std::pair(0, 3.0), std::pair(2, 1.0), std::pair(2, HUGE_VAL)}) {
    options.starts = starts;
    options.start_factor = factor;
    CHECK(has(refusal_of([&] { static_cast<void>(learn({seen}, plugins(), learnables, options)); }), "start"));
  }
}

TEST_CASE("a search goes on from its state to the same bits, whichever leg it was stopped in") {
  const std::vector<Experiment> seen = three_loads(0.01);
  for (const Optimiser optimiser : {Optimiser::levenberg_marquardt, Optimiser::lbfgs, Optimiser::descent}) {
    CAPTURE(std::string(name_of(optimiser)));
    LearnOptions options;
    options.optimiser = optimiser;
    options.max_iterations = 4;
    options.stages = 2;
    options.starts = 2;
    const LearnedNet whole = learn(seen, plugins(), each_stiffness_and_a_damping(), options);
    int told = 0;
    options.on_iteration = [&](const LearnProgress&) {
      ++told;
      return true;
    };
    static_cast<void>(learn(seen, plugins(), each_stiffness_and_a_damping(), options));
    const int iterations = told;
    std::string state;
    for (const int stop_at : {1, iterations / 3, iterations}) {
      CAPTURE(stop_at);
      told = 0;
      options.state.clear();
      options.on_state = [&](const std::string& now) { state = now; };
      options.on_iteration = [&](const LearnProgress&) { return ++told < stop_at; };
      const LearnedNet stopped = learn(seen, plugins(), each_stiffness_and_a_damping(), options);
      CHECK(stopped.stopped);
      CHECK(told == stop_at);
      // It is stopped once more on the way.
      options.state = state;
      options.on_iteration = [&](const LearnProgress&) { return told++ < stop_at + 2; };
      static_cast<void>(learn(seen, plugins(), each_stiffness_and_a_damping(), options));
      options.state = state;
      options.on_state = nullptr;
      options.on_iteration = nullptr;
      const LearnedNet resumed = learn(seen, plugins(), each_stiffness_and_a_damping(), options);
      CHECK_FALSE(resumed.stopped);
      check_same(resumed, whole);
    }
  }
}

TEST_CASE("a state of another search, or a damaged one, is refused with what differs") {
  const std::vector<Experiment> seen = three_loads(0.01);
  LearnOptions options;
  options.max_iterations = 2;
  options.stages = 1;
  std::string state;
  options.on_state = [&](const std::string& now) { state = now; };
  static_cast<void>(learn(seen, plugins(), each_stiffness_and_a_damping(), options));
  options.on_state = nullptr;
  options.state = state;
  const auto refused = [&](const std::vector<Experiment>& experiments, const std::vector<Learnable>& learnables,
                           const LearnOptions& with) {
    return refusal_of([&] { static_cast<void>(learn(experiments, plugins(), learnables, with)); });
  };
  const std::vector<Learnable> same = each_stiffness_and_a_damping();
  LearnOptions other = options;
  other.optimiser = Optimiser::lbfgs;
  CHECK(has(refused(seen, same, other), "optimiser: levenberg there, lbfgs now"));
  other = options;
  other.stages = 2;
  CHECK(has(refused(seen, same, other), "stages: 1 there, 2 now"));
  std::vector<Learnable> apart = same;
  apart[1].together = false;
  CHECK(has(refused(seen, apart, options), "what is learned"));
  std::vector<Experiment> changed = seen;
  changed[1].observations.positions[3].value[0] += 1e-15;
  CHECK(has(refused(changed, same, options), "experiment 2: observations"));
  changed = three_loads(0.01, 20.0, 2.5);
  CHECK(has(refused(changed, same, options), "experiment 1: "));
  changed = seen;
  changed.pop_back();
  CHECK(has(refused(changed, same, options), "experiments: 3 there, 2 now"));
  changed = seen;
  changed[2].options.integrator.parameters["theta"] = 1.0;
  CHECK(has(refused(changed, same, options), "experiment 3: integrator"));
  for (std::size_t k = 0; k < state.size(); k += 61) {
    other = options;
    other.state[k] = static_cast<char>(other.state[k] ^ 1);
    CHECK(has(refused(seen, same, other), "the state of a search"));
  }
  other.state = state.substr(0, state.size() - 1);
  CHECK(has(refused(seen, same, other), "damaged"));
}

TEST_CASE("experiments on other objects are refused") {
  const std::vector<Experiment> seen = three_loads(0.0);
  const auto refused = [&](const Network& second) {
    std::vector<Experiment> both{seen[0], seen[1]};
    both[1].network = std::make_shared<const Network>(second);
    return refusal_of([&] { static_cast<void>(learn(both, plugins(), each_stiffness_and_a_damping())); });
  };
  Network more = *seen[0].network;
  more.add_node(point({5, 5, 5}));
  CHECK(has(refused(more), "experiment 2 is of another object than experiment 1: it has 5 nodes, 3 springs"));
  Network other = chain(4, {0, 0, 0}, {0, 0, -1}, damped(20.0, 2.0));
  other.add_spring(0, 2, 0);
  Network first = chain(4, {0, 0, 0}, {0, 0, -1}, damped(20.0, 2.0));
  first.add_spring(0, 3, 0);
  std::vector<Experiment> both{seen[0], seen[1]};
  both[0].network = std::make_shared<const Network>(first);
  both[1].network = std::make_shared<const Network>(other);
  CHECK(has(refusal_of([&] { static_cast<void>(learn(both, plugins(), each_stiffness_and_a_damping())); }),
            "spring 3 between the nodes 0 and 2 in place of 0 and 3"));
  both[1].network = nullptr;
  CHECK(has(refusal_of([&] { static_cast<void>(learn(both, plugins(), each_stiffness_and_a_damping())); }),
            "experiment 2 has no network"));
}
