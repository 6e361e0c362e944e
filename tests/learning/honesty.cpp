// What of a result comes from the data, what from the guess, what from nowhere; and observations that judge.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/scene.hpp>

#include "facts.hpp"
#include "learning_nets.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

bool has_note(const LearnedNet& learned, const std::string& part) {
  return std::any_of(learned.notes.begin(), learned.notes.end(), [&](const auto& note) { return has(note, part); });
}

// A chain that hangs and swings; the masses of all nodes but the first, which is fixed, are its own.
Network hanging_chain(const std::vector<double>& masses) {
  const auto count = static_cast<std::uint32_t>(masses.size()) + 1;
  Network net = chain(count, {0, 0, 0}, {1, 0, 0}, damped(40.0, 1.0));
  net.fix(0);
  net.set_gravity({0, 0, -2});
  for (NodeIndex k = 1; k < count; ++k) {
    Node node = net.nodes()[k];
    node.mass = masses[k - 1];
    net.set_node(k, node);
  }
  return net;
}
const std::vector<double> real_masses{1.3, 0.8, 1.1, 0.7, 1.2, 0.9};
const SimulationOptions half_steps = to_learn_with(0.5, 0.05);
const Learnable all_masses{{Kind::mass, false, "", from_to(1, 7)}};

// Of the end of the chain alone, or of other nodes.
Observations seen_with(double noise, std::uint64_t seed = 1, const std::vector<std::uint32_t>& nodes = {6}) {
  Simulation real(hanging_chain(real_masses), plugins(), half_steps);
  Observations seen = observe(real, 40, nodes, noise, seed);
  if (noise > 0.0)
    for (auto& each : seen.positions) each.weight = Vector3::Constant(1.0 / (noise * noise));
  return seen;
}
LearnedNet learn_masses(const std::vector<double>& guess, Observations seen, const LearnOptions& options = {}) {
  return learn({experiment(hanging_chain(guess), half_steps, std::move(seen))}, plugins(), {all_masses}, options);
}

}  // namespace

TEST_CASE("the share of the guess is how far a value follows when the guess is moved") {
  const std::vector<double> guess(6, 1.0);
  LearnOptions options;
  options.stages = 1;
  // Of the observations' weight: some values are mostly of the data, some mostly of the guess.
  options.guess_weight = 1e2;
  const Observations seen = seen_with(0.002);
  const LearnedNet learned = learn_masses(guess, seen, options);
  CHECK(learned.guess_weight == doctest::Approx(1e2));
  constexpr double change = 1e-3;  // of the logarithm
  double least = 1.0, most = 0.0;
  for (std::size_t k = 0; k < 6; ++k) {
    CAPTURE(k);
    std::vector<double> moved = guess;
    moved[k] *= std::exp(change);
    const LearnedNet other = learn_masses(moved, seen, options);
    const double follows = std::log(other.parameters[k].value / learned.parameters[k].value) / change;
    // The curvature of the motion adds some percent.
    CHECK(learned.parameters[k].from_guess == doctest::Approx(follows).epsilon(0.05).scale(1.0));
    least = std::min(least, learned.parameters[k].from_guess);
    most = std::max(most, learned.parameters[k].from_guess);
  }
  CHECK(least < 0.3);
  CHECK(most > 0.6);
}

TEST_CASE("the weight of the guess is chosen by rule, and tames what is badly determined") {
  const std::vector<double> guess(6, 1.0);
  double plain_error = 0.0, ruled_error[2] = {0.0, 0.0};
  const auto error_of = [](const LearnedNet& learned) {
    double square = 0.0;
    for (std::size_t k = 0; k < 6; ++k) square += std::pow(std::log(learned.parameters[k].value / real_masses[k]), 2);
    return square;
  };
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    CAPTURE(seed);
    const Observations seen = seen_with(0.005, seed);
    plain_error += error_of(learn_masses(guess, seen));
    for (const GuessRule rule : {GuessRule::discrepancy, GuessRule::l_curve}) {
      LearnOptions options;
      options.guess_rule = rule;
      const LearnedNet learned = learn_masses(guess, seen, options);
      CAPTURE(learned.guess_weight);
      REQUIRE(learned.guess_curve.size() > 3);
      for (std::size_t k = 1; k < learned.guess_curve.size(); ++k) {
        CHECK(learned.guess_curve[k].weight <= learned.guess_curve[k - 1].weight);
        CHECK(learned.guess_curve[k].rms < learned.guess_curve[k - 1].rms + 1e-3);
      }
      // 120 values: by chance the least rms is above 1 at some seeds, which is told.
      if (rule == GuessRule::discrepancy && !has_note(learned, "No weight")) CHECK(learned.rms <= 1.001);
      ruled_error[rule == GuessRule::discrepancy ? 0 : 1] += error_of(learned);
    }
  }
  CAPTURE(plain_error);
  MESSAGE("sum of squares of errors: plain ", plain_error, ", discrepancy ", ruled_error[0], ", L-curve ",
          ruled_error[1]);
  for (const double each : ruled_error) CHECK(each < 0.5 * plain_error);
  LearnOptions options;
  options.guess_rule = GuessRule::discrepancy;
  CHECK(has(refusal_of([&] { static_cast<void>(learn_masses(guess, seen_with(0.0), options)); }),
            "give the observations standard deviations"));
}

TEST_CASE("differences that are no noise are told, and noise is not") {
  const std::vector<double> guess(6, 1.0);
  const std::vector<NodeIndex> nodes{2, 4, 6};
  const LearnedNet good = learn_masses(guess, seen_with(0.002, 1, nodes));
  CHECK(good.fit.warning.empty());
  CHECK(std::abs(good.fit.correlation_in_time) < 0.2);  // 351 pairs: deviation 0.05
  CHECK(learn_masses(guess, seen_with(0.0, 1, nodes)).fit.warning.empty());
  // The same noise, with standard deviations that are too small; without any, where it is large beside the motion.
  Observations bold = seen_with(0.002, 1, nodes), plain = seen_with(0.1, 1, nodes);
  for (auto& each : bold.positions) each.weight *= 25.0;
  for (auto& each : plain.positions) each.weight = Vector3::Ones();
  const LearnedNet bolder = learn_masses(guess, bold);
  CHECK(bolder.fit.warning.empty());
  CHECK(has_note(bolder, "where the standard deviations say 1, but the differences are not correlated in time"));
  CHECK(bolder.fit.share_of_motion == doctest::Approx(good.fit.share_of_motion).epsilon(1e-3));
  CHECK(learn_masses(guess, plain).fit.warning.empty());
  // Masses alone cannot make up for springs that are three times as stiff, with or without standard deviations.
  Network wrong = hanging_chain(guess);
  wrong.set_gravity({0, 0, -6});
  for (const double noise : {0.0, 0.002}) {
    CAPTURE(noise);
    const LearnedNet bad = learn({experiment(wrong, half_steps, seen_with(noise, 1, nodes))}, plugins(), {all_masses});
    CAPTURE(bad.fit.share_of_motion);
    CHECK(bad.fit.correlation_in_time > 0.5);
    CHECK(has(bad.fit.warning, "correlated in time"));
    CHECK(has(to_json(bad), "\"warning\": \""));
  }
  CHECK(has(to_json(good), "\"warning\": null"));
}

TEST_CASE("observations of the start alone are told as such, and no minimum is blamed") {
  Observations start;
  start.positions = {row(0.0, 2, hanging_chain({1, 1, 1, 1, 1, 1}).nodes()[2].position + Vector3(0, 0, 0.1))};
  const LearnedNet learned = learn_masses(std::vector<double>(6, 1.0), start);
  CHECK(learned.fit.warning.empty());
  CHECK(has_note(learned, "Only the start was observed"));
}

TEST_CASE("experiments whose masses or rest lengths are not those of the first are told") {
  const std::vector<double> guess(6, 1.0);
  Network heavier = hanging_chain(guess);
  Node node = heavier.nodes()[3];
  node.mass = 2.0;
  heavier.set_node(3, node);
  heavier.set_rest_length(1, 1.1);
  const Learnable stiffness{{Kind::spring_parameter, false, "stiffness", {0}}};
  LearnOptions options;
  options.max_iterations = 1;
  options.stages = 1;
  const Experiment first = experiment(hanging_chain(guess), half_steps, seen_with(0.002)),
                   same = experiment(hanging_chain(guess), half_steps, seen_with(0.002)),
                   other = experiment(heavier, half_steps, seen_with(0.002));
  CHECK(has_note(learn({first, other}, plugins(), {stiffness}, options),
                 "Experiment 2 has other masses and rest lengths than the first"));
  CHECK_FALSE(has_note(learn({first, same}, plugins(), {stiffness}, options), "than the first"));
  CHECK(has_note(learn({first, other}, plugins(), {all_masses}, options), "Experiment 2 has other rest lengths"));
}

TEST_CASE("the history tells differences from the observations without the part of the guess, and its weights") {
  LearnOptions options;
  options.guess_weight = 1e2;
  const std::vector<double> guess(6, 1.0);
  const LearnedNet learned = learn_masses(guess, seen_with(0.002), options);
  CHECK(learned.history.back().rms == doctest::Approx(learned.rms).epsilon(1e-9));
  // Of the cost, the guess is a part.
  CHECK(std::sqrt(2.0 * learned.cost / static_cast<double>(learned.observed)) > 1.01 * learned.rms);
  for (const LearnProgress& each : learned.history) CHECK(each.guess_weight == doctest::Approx(1e2));
  options.guess_rule = GuessRule::l_curve;
  const LearnedNet ruled = learn_masses(guess, seen_with(0.002), options);
  CHECK(ruled.history.back().guess_weight == doctest::Approx(ruled.guess_weight));
  CHECK(ruled.history.back().rms == doctest::Approx(ruled.rms).epsilon(1e-9));
  std::vector<double> weights;
  for (const LearnProgress& each : ruled.history)
    if (weights.empty() || weights.back() != each.guess_weight) weights.push_back(each.guess_weight);
  CHECK(weights.size() > 3);
}

TEST_CASE("a value that the guess holds outside of its interval is told") {
  LearnOptions options;
  options.guess_weight = 1e6;
  const Observations seen = seen_with(0.002, 1, {2, 4, 6});  // which determine all masses closely
  const LearnedNet held = learn_masses(std::vector<double>(6, 1.0), seen, options);
  int outside = 0;
  for (const LearnedParameter& each : held.parameters) {
    CHECK(each.is_outside == (each.value < each.lower || each.value > each.upper));
    outside += each.is_outside ? 1 : 0;
  }
  CHECK(outside > 0);
  CHECK(has_note(held, outside == 1 ? "is outside of its interval" : "are outside of their intervals"));
  CHECK(has(to_json(held), "\"outside_interval\": true"));
  const LearnedNet free = learn_masses(std::vector<double>(6, 1.0), seen);
  for (const LearnedParameter& each : free.parameters) CHECK_FALSE(each.is_outside);
}

TEST_CASE("observations that are held out judge what was learned") {
  const std::vector<double> guess(6, 1.0);
  const auto judged = [&](Observations seen, Observations held_out) {
    Experiment own = experiment(hanging_chain(guess), half_steps, std::move(seen));
    own.held_out = std::move(held_out);
    return learn({own}, plugins(), {all_masses});
  };
  const LearnedNet good = judged(seen_with(0.002, 1, {2, 4, 6}), seen_with(0.002, 2, {3, 5}));
  CHECK(good.held_out.observed == 2 * 40 * 3);
  CHECK(good.held_out.start_rms > 5.0);
  CHECK(good.held_out.rms == doctest::Approx(1.0).epsilon(0.15));  // of 240 values
  CHECK_FALSE(has_note(good, "held out"));
  CHECK(has(to_json(good), "\"held_out\": {"));
  // What was held out does not change what is learned.
  const LearnedNet alone = learn_masses(guess, seen_with(0.002, 1, {2, 4, 6}));
  CHECK(alone.values == good.values);
  CHECK(alone.held_out.observed == 0);
  CHECK_FALSE(has(to_json(alone), "held_out"));
  // Six masses from eight values follow their noise.
  Observations little = seen_with(0.05, 3);
  little.positions.erase(little.positions.begin() + 8, little.positions.end());
  for (auto& each : little.positions) each.weight[1] = each.weight[2] = 0.0;
  const LearnedNet bad = judged(little, seen_with(0.05, 4, {3, 5}));
  CHECK(has_note(bad, "held out"));
  // An experiment of its own: the same net, thrown.
  Network thrown = hanging_chain(real_masses);
  Node end = thrown.nodes()[6];
  end.velocity = {0, 2, 0};
  thrown.set_node(6, end);
  Simulation real(thrown, plugins(), half_steps);
  Experiment judging;
  Network thrown_guess = hanging_chain(guess);
  end.mass = 1.0;
  thrown_guess.set_node(6, end);
  judging.network = std::make_shared<const Network>(thrown_guess);
  judging.options = half_steps;
  judging.held_out = observe(real, 40, from_to(1, 7));
  const std::vector<Experiment> both{experiment(hanging_chain(guess), half_steps, seen_with(0.0, 1, {2, 4, 6})),
                                     judging};
  const LearnedNet other = learn(both, plugins(), {all_masses});
  CHECK(other.held_out.observed == 40 * 6 * 3);
  CHECK(other.held_out.start_rms > 0.01);
  CHECK(other.held_out.rms < 1e-7);
  // Once through the motion, too.
  Experiment own = both.front();
  own.held_out = seen_with(0.0, 1, {5});
  CHECK(learn_online(own, plugins(), {all_masses}).held_out.observed == 120);
  CHECK(has(refusal_of([&] { static_cast<void>(judged(seen_with(0.01), seen_with(0.01))); }),
            "are held out and learned from as well"));
  CHECK(has(refusal_of([&] { static_cast<void>(judged({}, seen_with(0.01))); }), "all observations are held out"));
}

TEST_CASE("what the time step takes from the prediction of held-out observations is estimated") {
  // Without noise, from a motion with far smaller steps: what is left is of the step alone.
  Simulation real(hanging_chain(real_masses), plugins(), to_learn_with(1.0, 0.05 / 40));
  Observations seen, held_out;
  for (int i = 1; i <= 40 * 40; ++i) {
    real.step();
    if (i % 40 != 0) continue;
    for (const NodeIndex k : {2u, 4u, 6u}) seen.positions.push_back(row(real.time(), k, real.position(k)));
    for (const NodeIndex k : {3u, 5u}) held_out.positions.push_back(row(real.time(), k, real.position(k)));
  }
  const auto judged = [&](double step) {
    Experiment own = experiment(hanging_chain(real_masses), to_learn_with(1.0, step), seen);
    own.held_out = held_out;
    return learn({own}, plugins(),
                 {{{Kind::spring_parameter, false, "stiffness", from_to(0, 6)}, true},
                  {{Kind::viscosity_parameter, false, "damping", from_to(0, 6)}, true}});
  };
  const LearnedNet whole = judged(0.05), half = judged(0.025);
  CAPTURE(whole.held_out.rms);
  CHECK(whole.held_out.half_step_rms < 0.7 * whole.held_out.rms);
  CHECK(whole.held_out.half_step_rms == doctest::Approx(half.held_out.rms).epsilon(0.15));
  CHECK(has(to_json(whole), "\"half_time_step_rms\": "));
}

// The example as it is shipped, with its ground: what the 16 nodes that touch it move by, and the 24 springs between
// them feel, is the same whatever their values are.
TEST_CASE(
    "from the drop of the paper's cube, exactly the values of the nodes that the ground holds have no influence") {
  const Scene scene = load_scene(SPRINGNET_EXAMPLES "/cube/cube.toml", *plugins());
  SimulationOptions options = scene.options;
  options.threads = 1;
  Simulation drop(scene.network, plugins(), options);
  const Observations seen = observe(drop, 45, from_to(0, 64));
  for (NodeIndex k = 0; k < 64; ++k) REQUIRE(drop.touching(k) == (k < 16));
  const std::vector<Learnable> all{{{Kind::spring_parameter, false, "stiffness", from_to(0, 252)}},
                                   {{Kind::viscosity_parameter, false, "damping", from_to(0, 252)}},
                                   {{Kind::mass, false, "", from_to(0, 64)}}};
  LearnOptions short_search;
  short_search.stages = 1;
  short_search.max_iterations = 1;
  const LearnedNet learned = learn({experiment(scene.network, options, seen)}, plugins(), all, short_search);
  for (const LearnedParameter& each : learned.parameters) {
    CAPTURE(name_of(each));
    CAPTURE(each.member);
    const bool is_held = each.kind == Kind::mass ? each.member < 16
                                                 : scene.network.springs()[each.member].first < 16 &&
                                                       scene.network.springs()[each.member].second < 16;
    CHECK(each.has_influence == !is_held);
    if (is_held) CHECK(each.value == each.start);
    if (is_held) CHECK(each.from_guess > 1.0 - 1e-6);
  }
  CHECK(has_note(learned,
                 "64 values have no influence at all on what was observed, and stay as they were: "
                 "spring.stiffness of springs "));
  CHECK(has_note(learned, "mass of nodes 0-15."));
  // And one direction: all masses, stiffnesses and dampings together. Some others have less effect than what steps that
  // settle to the scene's tolerance leave unbalanced.
  CHECK(learned.undetermined >= 64 + 1);
  CHECK(learned.undetermined <= 64 + 5);
  const auto without = [&](Kind kind) {
    return std::count_if(learned.parameters.begin(), learned.parameters.end(),
                         [&](const auto& each) { return each.kind == kind && !each.has_influence; });
  };
  CHECK(without(Kind::spring_parameter) == 24);
  CHECK(without(Kind::viscosity_parameter) == 24);
  CHECK(without(Kind::mass) == 16);
}

TEST_CASE("values at bounds are told") {
  Learnable bounded = all_masses;
  bounded.upper = 1.15;  // two of them are greater
  const LearnedNet learned =
      learn({experiment(hanging_chain(std::vector<double>(6, 1.0)), half_steps, seen_with(0.0, 1, from_to(1, 7)))},
            plugins(), {bounded});
  CHECK(has_note(learned,
                 "are at a bound; the observations would have them beyond, or the model is not theirs: mass of "
                 "nodes "));
}

TEST_CASE("of more variables than have intervals it is told what products show") {
  // Two chains, of which one is seen.
  constexpr std::uint32_t half = 1010;
  Network net = chain(half, {0, 0, 0}, {1, 0, 0}, damped(40.0, 1.0));
  for (NodeIndex k = 0; k < half; ++k) net.add_node(point({static_cast<double>(k), 5, 0}));
  for (NodeIndex k = half; k + 1 < 2 * half; ++k) net.add_spring(k, k + 1, 0);
  for (NodeIndex k = 0; k < 2 * half; ++k) {
    Node node = net.nodes()[k];
    node.velocity = {0.3 * std::sin(1.0 * k), 0.3 * std::cos(2.0 * k), 0};
    net.set_node(k, node);
  }
  Simulation real(net, plugins(), half_steps);
  LearnOptions options;
  options.stages = 1;
  options.max_iterations = 1;
  options.guess_weight = 1e-6;
  const LearnedNet learned = learn({experiment(net, half_steps, observe(real, 6, from_to(0, half), 1e-3))}, plugins(),
                                   {{{Kind::mass, false, "", from_to(0, 2 * half)}}}, options);
  CHECK(learned.variables == 2 * half);
  REQUIRE_FALSE(learned.singular_values.empty());
  CHECK(std::is_sorted(learned.singular_values.rbegin(), learned.singular_values.rend()));
  CHECK(has_note(learned, "greatest, by Lanczos' method"));
  for (const LearnedParameter& each : learned.parameters) {
    CHECK(each.has_influence == (each.member < half));
    CHECK(each.from_guess <= 1.0);
    CHECK(each.from_guess >= 0.0);
    if (each.member >= half) CHECK(each.from_guess == doctest::Approx(1.0).epsilon(1e-12));
    CHECK(std::isinf(each.upper));
    CHECK(std::isnan(each.determined));
  }
  // One product settles nothing, and without a guess that has weight there is no share of it.
  options.guess_weight = 0.0;
  options.certainty_products = 1;
  options.max_iterations = 0;
  const LearnedNet little = learn({experiment(net, half_steps, observe(real, 6, from_to(0, half), 1e-3))}, plugins(),
                                  {{{Kind::mass, false, "", from_to(0, 2 * half)}}}, options);
  CHECK(little.singular_values.empty());
  CHECK(has_note(little, "No singular value has settled after 1 product: allow more (--certainty-products)"));
  CHECK_FALSE(has_note(little, "Shares of the guess"));
  for (const LearnedParameter& each : little.parameters) CHECK(std::isnan(each.from_guess));
}
