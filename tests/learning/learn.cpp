// What learn() tells: intervals, what the data do not determine, bounds, the share of the time step.

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/scene_writer.hpp>

#include "facts.hpp"
#include "learning_nets.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

const Learnable stiffness{{Kind::spring_parameter, false, "stiffness", {0}}};
const Learnable damping{{Kind::viscosity_parameter, false, "damping", {0}}};

// The oscillator's closed form: m x'' + d x' + k x = 0.
double swing(double k, double d, double m, double x0, double t) {
  const double decay = d / (2.0 * m), omega = std::sqrt(k / m - decay * decay);
  return x0 * std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t));
}

// Of an oscillator with k 12 N/m, d 0.5 N s/m, m 2 kg that starts 0.1 m beyond its rest length.
Observations of_oscillator(double until, double noise = 0.0, std::uint64_t seed = 1) {
  Observations result;
  Dice dice(seed);
  for (int i = 1; i <= 40; ++i) {
    const double time = until * i / 40.0;
    const double x = 1.0 + swing(12.0, 0.5, 2.0, 0.1, time) + noise * normal(dice)[0];
    Observations::VectorRow seen = row(time, 1, {x, 0, 0});
    seen.weight = {1, 0, 0};  // the other components are not seen
    result.positions.push_back(seen);
  }
  return result;
}

}  // namespace

TEST_CASE("an oscillator is identified from its closed form, to the error of the time step, which is told") {
  const Network guess = oscillator(damped(8.0, 0.2), 2.0, 0.1);
  struct Case {
    double theta, step;
  };
  for (const Case& with : {Case{1.0, 0.002}, Case{0.5, 0.04}}) {
    CAPTURE(with.theta);
    const auto learned_with = [&](double step) {
      return learn({experiment(guess, to_learn_with(with.theta, step), of_oscillator(4.0))}, plugins(),
                   {stiffness, damping});
    };
    const LearnedNet learned = learned_with(with.step), half = learned_with(0.5 * with.step);
    CAPTURE(learned.reason);
    REQUIRE(learned.parameters.size() == 2);
    CHECK(learned.observed == 40);
    CHECK(learned.undetermined == 0);
    const double right[] = {12.0, 0.5};
    for (std::size_t k = 0; k < 2; ++k) {
      CAPTURE(k);
      const LearnedParameter &own = learned.parameters[k], &finer = half.parameters[k];
      CHECK(own.value == doctest::Approx(right[k]).epsilon(0.06));
      CHECK(std::abs(finer.value - right[k]) < 0.6 * std::abs(own.value - right[k]));
      // The estimate is of first order in a shift of some percent.
      CHECK(own.by_time_step == doctest::Approx(finer.value - own.value).epsilon(0.1));
    }
  }
}

TEST_CASE("intervals contain the true values as often as they say") {
  const Network guess = oscillator(damped(8.0, 0.2), 2.0, 0.1);
  const SimulationOptions options = to_learn_with(0.5, 0.01);  // whose bias is a twentieth of the intervals
  constexpr int repetitions = 60;
  int inside[2] = {0, 0};
  for (int i = 0; i < repetitions; ++i) {
    const LearnedNet learned =
        learn({experiment(guess, options, of_oscillator(4.0, 0.01, 100 + static_cast<std::uint64_t>(i)))}, plugins(),
              {stiffness, damping});
    CHECK(learned.rms == doctest::Approx(0.01).epsilon(0.5));
    const double right[] = {12.0, 0.5};
    for (std::size_t k = 0; k < 2; ++k)
      if (learned.parameters[k].lower <= right[k] && right[k] <= learned.parameters[k].upper) ++inside[k];
  }
  // 57 expected, deviation 1.7: with 52 or more but for one in a thousand times; all inside is one in twenty times.
  for (const int count : inside) {
    CHECK(count >= 52);
    CHECK(count <= repetitions);
  }
}

TEST_CASE("masses, stiffnesses and dampings together keep a scale that no motion tells") {
  const Network net = chain(5, {0, 0, 0}, {1, 0.1, 0}, damped(20.0, 0.5));
  Simulation simulation(net, plugins(), to_learn_with(0.5, 0.05));
  for (NodeIndex k = 0; k < 5; ++k) simulation.set_velocity(k, {0.1 * k, 0.2 - 0.1 * k, 0.05 * k * k});
  Network moving = net;
  for (NodeIndex k = 0; k < 5; ++k) {
    Node node = net.nodes()[k];
    node.velocity = {0.1 * k, 0.2 - 0.1 * k, 0.05 * k * k};
    moving.set_node(k, node);
  }
  Simulation real(moving, plugins(), to_learn_with(0.5, 0.05));
  const Experiment seen = experiment(moving, to_learn_with(0.5, 0.05), observe(real, 30, from_to(0, 5)));
  const std::vector<Learnable> all{{{Kind::spring_parameter, false, "stiffness", from_to(0, 4)}},
                                   {{Kind::viscosity_parameter, false, "damping", from_to(0, 4)}},
                                   {{Kind::mass, false, "", from_to(0, 5)}}};
  const LearnedNet free = learn({seen}, plugins(), all);
  CHECK(free.undetermined == 1);
  for (const LearnedParameter& each : free.parameters) {
    // The direction is (1, …, 1) of 13 logarithms.
    CHECK(each.determined == doctest::Approx(1.0 - 1.0 / 13.0).epsilon(1e-6));
    CHECK(std::isinf(each.upper));
    CHECK(std::isinf(each.lower));
  }
  std::vector<Learnable> fixed = all;
  fixed[2].values.members = from_to(1, 5);
  const LearnedNet known = learn({seen}, plugins(), fixed);
  CHECK(known.undetermined == 0);
  for (const LearnedParameter& each : known.parameters) CHECK(each.value == doctest::Approx(each.start).epsilon(1e-6));
}

TEST_CASE("what was not observed is named, and stays at the guess") {
  // Two oscillators, of which one is seen.
  Network net = oscillator(damped(8.0, 0.2), 2.0, 0.1);
  Node wall = point({0, 5, 0});
  wall.fixed = true;
  const NodeIndex a = net.add_node(wall), b = net.add_node(point({1.1, 5, 0}, 2.0));
  net.add_spring(a, b, 0, 1.0);
  std::vector<Learnable> both{stiffness, damping};
  for (Learnable& each : both) each.values.members = {0, 1};
  for (const double weight : {0.0, 1e-9}) {
    LearnOptions options;
    options.guess_weight = weight;
    const LearnedNet learned =
        learn({experiment(net, to_learn_with(0.5, 0.02), of_oscillator(4.0))}, plugins(), both, options);
    CHECK(learned.undetermined == 2);
    for (const LearnedParameter& each : learned.parameters) {
      const bool seen = each.member == 0;
      CHECK(each.determined == doctest::Approx(seen ? 1.0 : 0.0).epsilon(1e-9));
      CHECK(std::isfinite(each.upper) == seen);
      if (!seen) CHECK(each.value == doctest::Approx(each.start).epsilon(1e-9));
    }
    CHECK(learned.parameters[0].value == doctest::Approx(12.0).epsilon(1e-2));
  }
}

TEST_CASE("values are learned together, with bounds, in several experiments, from velocities and distances") {
  // A chain that hangs and one that swings, of the same springs.
  Network hanging = chain(4, {0, 0, 0}, {0, 0, -1}, damped(30.0, 1.0)), pulled = hanging;
  for (Network* const each : {&hanging, &pulled}) each->fix(0);
  hanging.set_gravity({0, 0, -2});
  Load load;
  load.nodes = {3};
  load.force = {3, 0, 0};
  pulled.add_load(load);
  const SimulationOptions options = to_learn_with(0.5, 0.05);
  Observations of_hanging, of_pulled;
  Simulation first(hanging, plugins(), options), second(pulled, plugins(), options);
  for (int i = 0; i < 20; ++i) {
    first.step();
    second.step();
    for (NodeIndex k = 1; k < 4; ++k) of_hanging.velocities.push_back(row(first.time(), k, first.velocity(k)));
    Observations::DistanceRow distance;
    distance.time = second.time();
    distance.node = 0;
    distance.other = 3;
    distance.weight = 1.0;
    distance.distance = (second.position(3) - second.position(0)).norm();
    of_pulled.distances.push_back(distance);
  }
  const std::vector<std::uint32_t> springs = from_to(0, 3);
  const auto guess = [&](Network net) {  // the truth is 30 and 1
    Simulation other(net, plugins(), options);
    other.set_parameter(springs, ComponentKind::spring_function, "stiffness", {20.0});
    other.set_parameter(springs, ComponentKind::viscosity_function, "damping", {2.0});
    return other.present_network();
  };
  std::vector<Learnable> together{stiffness, damping};
  for (Learnable& each : together) {
    each.values.members = springs;
    each.together = true;
  }
  const std::vector<Experiment> seen{experiment(guess(hanging), options, of_hanging),
                                     experiment(guess(pulled), options, of_pulled)};
  const LearnedNet learned = learn(seen, plugins(), together);
  CAPTURE(learned.reason);
  CHECK(learned.variables == 2);
  CHECK(learned.observed == 20 * 9 + 20);
  for (const LearnedParameter& each : learned.parameters) {
    CHECK(each.value == doctest::Approx(each.kind == Kind::spring_parameter ? 30.0 : 1.0).epsilon(1e-7));
    CHECK_FALSE(each.at_bound);
  }
  together[0].upper = 25.0;
  const LearnedNet bounded = learn(seen, plugins(), together);
  CHECK(bounded.parameters[0].value == doctest::Approx(25.0).epsilon(1e-12));
  CHECK(bounded.parameters[0].at_bound);
  CHECK(bounded.cost > learned.cost);
  // Asked to stop, it has the best until then.
  LearnOptions stopped;
  stopped.on_iteration = [](const LearnProgress& now) { return now.iteration < 1; };
  const LearnedNet early = learn(seen, plugins(), together, stopped);
  CHECK(early.cost < early.start_cost);
  CHECK(has(early.reason, "It was stopped"));
}

TEST_CASE(
    "a search from the true values does not end with worse ones, however little the first part of the motion tells") {
  // A chain whose first part of the motion hardly tells stiffness, rest length and start velocity apart.
  Network net = chain(4, {0, 0, 0}, {1, 0, 0}, damped(40.0, 1.0));
  net.fix(0);
  net.set_gravity({0, 0, -2});
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  const std::vector<Learnable> learnables{{{Kind::spring_parameter, false, "stiffness", from_to(0, 3)}},
                                          {{Kind::viscosity_parameter, false, "damping", from_to(0, 3)}, true},
                                          {{Kind::rest_length, false, "", from_to(0, 3)}},
                                          {{Kind::initial_velocity, false, "", from_to(1, 4)}}};
  int near = 0;
  constexpr int repetitions = 10;
  for (std::uint64_t seed = 1; seed <= repetitions; ++seed) {
    CAPTURE(seed);
    Simulation real(net, plugins(), options);
    const LearnedNet learned =
        learn({experiment(net, options, observe(real, 50, from_to(1, 4), 0.01, seed))}, plugins(), learnables);
    CAPTURE(learned.reason);
    CHECK(learned.cost <= learned.start_cost);
    CHECK(learned.rms == doctest::Approx(0.01).epsilon(0.2));
    if (learned.parameters[0].lower <= 40.0 && 40.0 <= learned.parameters[0].upper) ++near;
  }
  CHECK(near >= 7);  // 9.5 expected: fewer happens once in a thousand times
}

TEST_CASE("a learned network is written as a scene that moves as it was seen") {
  const Network guess = oscillator(damped(8.0, 0.2), 2.0, 0.1);
  const SimulationOptions options = to_learn_with(0.5, 0.04);
  const LearnedNet learned = learn({experiment(guess, options, of_oscillator(4.0))}, plugins(), {stiffness, damping});
  Scene scene;
  scene.network = with_values(std::make_shared<const Network>(guess), plugins(), {stiffness, damping}, learned.values);
  scene.duration = 4.0;
  scene.options = options;
  const Scene read = parse_scene(to_scene(scene, *plugins()), "learned", *plugins());
  Simulation simulation(read.network, plugins(), options);
  simulation.advance_to(4.0);
  CHECK(simulation.position(1)[0] == doctest::Approx(1.0 + swing(12.0, 0.5, 2.0, 0.1, 4.0)).epsilon(1e-4));
  const std::string json = to_json(learned);
  CHECK(has(json, "\"undetermined_directions\": 0"));
  CHECK(has(json, "\"parameter\": \"stiffness\""));
}

TEST_CASE("what is learned is selected by text") {
  Network net = cube(20.0, 4.0, 1.0, 0.1);
  net.fix(3);
  const auto members = [&](const char* text) { return select_learnable(net, *plugins(), text).values.members.size(); };
  CHECK(members("spring.stiffness") == 252);
  CHECK(members("viscosity.damping@cube") == 252);
  CHECK(members("rest_length") == 252);
  CHECK(members("mass") == 63);
  CHECK(members("mass:together") == 64);
  CHECK(members("velocity") == 63);
  CHECK(select_learnable(net, *plugins(), "spring.stiffness:together").together);
  const auto refused = [&](const char* text) {
    return refusal_of([&] { static_cast<void>(select_learnable(net, *plugins(), text)); });
  };
  CHECK(has(refused("spring.stifness"), "did you mean 'stiffness'"));
  CHECK(has(refused("mass@cub"), "did you mean 'cube'"));
  CHECK(has(refused("mass:all"), "only ':together' or ':field=DEGREE'"));
  CHECK(has(refused("colour"), "write spring.NAME"));
  CHECK(has(refused("element.spring.stiffness"), "these elements"));
  CHECK(has(refused("reference"), "nothing of this kind"));
  CHECK(has(refused("neuron.drag"), "no law of these neurons has a parameter 'drag'"));
}

TEST_CASE("selections that overlap are refused with both, and values know where they were selected") {
  const Network net = cube(20.0, 4.0, 1.0, 0.1);
  const auto refused = [&](const std::vector<std::string>& texts) {
    return refusal_of([&] { static_cast<void>(select_learnables(net, *plugins(), texts)); });
  };
  const std::string message =
      refused({"mass", "spring.stiffness@cube", "viscosity.damping", "spring.stiffness:together"});
  CHECK(has(message, "'spring.stiffness:together'"));
  CHECK(has(message, "spring 0 is among 'spring.stiffness@cube', too"));
  CHECK(refused({"spring.stiffness", "viscosity.damping", "mass"}).empty());
  const std::vector<Learnable> found = select_learnables(net, *plugins(), {"spring.stiffness@cube:together", "mass"});
  CHECK(found[0].body == "cube");
  CHECK(found[1].body.empty());
}

TEST_CASE("a group of a body is selected with the springs and elements that have all of their nodes in it") {
  Network net;
  net.begin_body("rope/1");
  for (int k = 0; k < 5; ++k) net.add_node(point({static_cast<double>(k), 0, 0}));
  const MaterialIndex soft = net.add_material(damped(20.0, 1.0));
  for (NodeIndex k = 0; k < 4; ++k) net.add_spring(k, k + 1, soft);
  net.add_element(Invariant::angle, {1, 2, 3}, soft, 3.0);
  net.add_element(Invariant::angle, {0, 1, 2}, soft, 3.0);
  net.add_group("middle/part", {1, 2, 3});
  net.add_group("end", {0});
  net.end_body();
  net.fix(2);
  const auto members = [&](const std::string& text) { return select_learnable(net, *plugins(), text).values.members; };
  using Members = std::vector<std::uint32_t>;
  CHECK(members("spring.stiffness@rope/1") == Members{0, 1, 2, 3});
  CHECK(members("spring.stiffness@rope/1/middle/part") == Members{1, 2});
  CHECK(members("viscosity.damping@rope/1/middle/part:together") == Members{1, 2});
  CHECK(members("rest_length@rope/1/middle/part") == Members{1, 2});
  CHECK(members("element.spring.stiffness@rope/1/middle/part") == Members{0});
  CHECK(members("reference@rope/1/middle/part") == Members{0});
  CHECK(members("mass@rope/1/middle/part") == Members{1, 3});
  CHECK(members("mass@rope/1/end") == Members{0});
  const auto refused = [&](const std::string& text) { return refusal_of([&] { static_cast<void>(members(text)); }); };
  CHECK(refused("mass@rope/1/midle").find("there is no group 'rope/1/midle'") != std::string::npos);
  CHECK(refused("mass@rope").find("there is no body 'rope'") != std::string::npos);
  CHECK_FALSE(refused("rest_length@rope/1/end").empty());
}

TEST_CASE("observations and starts that do not fit are refused") {
  const Network net = oscillator(damped(8.0, 0.2), 2.0, 0.1);
  const auto refused = [&](Observations seen, std::vector<Learnable> learnables) {
    return refusal_of([&] {
      static_cast<void>(learn({experiment(net, to_learn_with(0.5, 0.04), std::move(seen))}, plugins(), learnables));
    });
  };
  CHECK(has(refused({}, {stiffness}), "observ"));
  CHECK(has(refusal_of([&] { static_cast<void>(learn({}, plugins(), {stiffness})); }), "no experiment"));
  Observations unknown = of_oscillator(1.0);
  unknown.positions[0].node = 7;
  CHECK(has(refused(unknown, {stiffness}), "7"));
  Observations reactions = of_oscillator(1.0);
  reactions.reactions.push_back(row(0.5, 1, {1, 0, 0}));
  CHECK(has(refused(reactions, {stiffness}), "neither fixed nor moved"));
  CHECK(has(refused(of_oscillator(1.0), {}), "nothing to be learned"));
  Learnable outside = stiffness;
  outside.lower = 10.0;
  CHECK(has(refused(of_oscillator(1.0), {outside}), "starts at 8"));
}
