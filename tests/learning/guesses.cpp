// Words of a scene as what is known of learned values beforehand.

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/guessed_values.hpp>
#include <springnet/scene.hpp>

#include "learning_nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// Two hanging blocks of five springs up and down; `of_first` and `of_second` are what they are made of.
std::string blocks(const std::string& of_first, const std::string& of_second) {
  const auto block = [](const char* name, double x, const std::string& material) {
    return "[[body]]\nname = \"" + std::string(name) + "\"\nmesh = { lattice = [2, 2, 3], spacing = 0.1, origin = [" +
           std::to_string(x) +
           ", 0, 0], diagonals = \"all\" }\nneuron = { type = \"point_mass\" }\nmaterial = " + material + "\n";
  };
  return "[simulation]\nduration = 0.2\ntime_step = 0.01\nintegrator = { name = \"recurrent\", theta = 0.5, "
         "force_tolerance = 1e-9 }\n[gravity]\nacceleration = [0, 0, -9.81]\n" +
         block("first", 0.0, of_first) + block("second", 1.0, of_second) +
         "[[fix]]\nselect = { box = { min = [-1, -1, 0.19], max = [2, 2, 0.21] } }\n";
}
const std::string wet = "{ feel = \"soft\", wetness = \"wet\", response = \"viscous\" }";

struct Guessed {
  explicit Guessed(const std::string& text) {
    folder.write("scene.toml", text);
    scene = load_scene(folder.path() / "scene.toml", *plugins());
  }
  [[nodiscard]] GuessedValues of(const std::vector<Learnable>& learnables) const {
    return {folder.path() / "scene.toml", plugins(), learnables};
  }
  [[nodiscard]] Learnable select(const char* what) const { return select_learnable(scene.network, *plugins(), what); }
  TemporaryFolder folder;
  Scene scene;
};

double stiffness(const Network& network, SpringIndex spring) {
  return network.materials()[network.springs()[spring].material].spring->parameters.find("stiffness")->second;
}

// Of a body, alone.
void set_stiffness(Network& network, const Body& body, double factor) {
  for (SpringIndex k = body.first_spring; k < body.first_spring + body.spring_count; ++k) {
    Material material = network.materials()[network.springs()[k].material];
    material.spring->parameters["stiffness"] *= factor;
    network.set_spring_material(k, network.add_material(material));
  }
}

}  // namespace

TEST_CASE("values follow the guesses that they come from") {
  const Guessed guessed(blocks(wet, "{ youngs_modulus = 2e4, damping_time = 0.01, wetness = \"dry\" }"));
  const std::vector<Learnable> learnables{guessed.select("spring.stiffness"), guessed.select("viscosity.damping"),
                                          guessed.select("mass")};
  const GuessedValues values = guessed.of(learnables);
  REQUIRE(values.guesses().size() == 4);
  std::vector<std::string> keys;
  for (const SceneGuess& each : values.guesses()) keys.push_back(each.key);
  const auto place = [&](const std::string& key) {
    return static_cast<Eigen::Index>(std::find(keys.begin(), keys.end(), key) - keys.begin());
  };
  const Eigen::Index modulus = place("body.0.material.youngs_modulus"), time = place("body.0.material.damping_time"),
                     density = place("body.0.density"), other = place("body.1.density");
  REQUIRE(std::max({modulus, time, density, other}) < 4);
  const auto springs = static_cast<Eigen::Index>(guessed.scene.network.springs().size());
  const Network& network = guessed.scene.network;
  // Stiffnesses follow the modulus, dampings it and the damping time, masses the density: proportionally.
  for (Eigen::Index k = 0; k < springs; ++k) {
    const bool is_first = k < springs / 2;
    CHECK(values.influence()(k, modulus) == doctest::Approx(is_first ? 1.0 : 0.0).epsilon(1e-6));
    CHECK(values.influence()(k, time) == 0.0);
    CHECK(values.influence()(springs + k, modulus) == doctest::Approx(is_first ? 1.0 : 0.0).epsilon(1e-6));
    CHECK(values.influence()(springs + k, time) == doctest::Approx(is_first ? 1.0 : 0.0).epsilon(1e-6));
  }
  const std::vector<std::uint32_t>& nodes = learnables[2].values.members;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const bool is_first = nodes[i] < network.nodes().size() / 2;
    const auto row = 2 * springs + static_cast<Eigen::Index>(i);
    CHECK(values.influence()(row, density) == doctest::Approx(is_first ? 1.0 : 0.0).epsilon(1e-6));
    CHECK(values.influence()(row, other) == doctest::Approx(is_first ? 0.0 : 1.0).epsilon(1e-6));
  }
  // A guess is one piece of knowledge, whatever the number of springs.
  std::vector<Learnable> with_widths = learnables;
  values.set_widths(with_widths);
  const SceneGuess& guess = values.guesses()[static_cast<std::size_t>(modulus)];
  const double width = std::numbers::ln10 * guess.width * std::sqrt(0.5 * static_cast<double>(springs));
  REQUIRE(with_widths[0].guess_widths.size() == static_cast<std::size_t>(springs));
  CHECK(with_widths[0].guess_widths[0] == doctest::Approx(width).epsilon(1e-6));
  CHECK(with_widths[0].by_logarithm);
  CHECK_FALSE(with_widths[2].by_logarithm);
  CHECK(with_widths[0].guess_widths.back() == 0.0);  // a number: nothing is known of it
  const SceneGuess& of_mass = values.guesses()[static_cast<std::size_t>(density)];
  CHECK(with_widths[2].guess_widths[0] ==
        doctest::Approx(of_mass.width / of_mass.value * std::sqrt(0.5 * static_cast<double>(nodes.size())))
            .epsilon(1e-4));
}

TEST_CASE("a guess with a width is weighed against observations by their standard deviations") {
  const Guessed guessed(blocks(wet, wet));
  const Network& network = guessed.scene.network;
  const Body& body = network.bodies()[0];
  Network real = network;
  constexpr double factor = 2.5, noise = 3e-3;
  set_stiffness(real, body, factor);
  SimulationOptions options = guessed.scene.options;
  options.threads = 1;
  Simulation motion(real, plugins(), options);
  Observations seen = observe(motion, 20, {body.first_node, body.first_node + 1}, noise);
  for (Observations::VectorRow& each : seen.positions) each.weight.setConstant(1.0 / (noise * noise));
  std::vector<Learnable> learnables{guessed.select("spring.stiffness@first:together")};
  const GuessedValues values = guessed.of(learnables);
  values.set_widths(learnables);
  REQUIRE(values.guesses().size() == 1);
  const double width = std::numbers::ln10 * values.guesses()[0].width;
  // The cost as it is meant, from simulations alone: its least value by the golden section.
  const auto cost = [&](double change) {
    Network own = network;
    set_stiffness(own, body, std::exp(change));
    Simulation run(own, plugins(), options);
    double sum = std::pow(change / width, 2);
    std::size_t next = 0;
    for (int k = 0; k < 20; ++k) {
      run.step();
      for (int i = 0; i < 2; ++i, ++next)
        sum += (run.position(seen.positions[next].node) - seen.positions[next].value).squaredNorm() / (noise * noise);
    }
    return 0.5 * sum;
  };
  double low = -1.0, high = 2.0;
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  while (high - low > 1e-5) {
    const double left = high - golden * (high - low), right = low + golden * (high - low);
    (cost(left) < cost(right) ? high : low) = cost(left) < cost(right) ? right : left;
  }
  const double least = 0.5 * (low + high);
  LearnOptions by_widths;
  by_widths.guess_rule = GuessRule::widths;
  const LearnedNet learned = learn({experiment(network, options, seen)}, plugins(), learnables, by_widths);
  CHECK(learned.guess_weight == 1.0);
  // The section's last interval is 1e-5 of the logarithm, and steps are settled to 1e-9 N.
  CHECK(std::log(learned.parameters[0].value / learned.parameters[0].start) == doctest::Approx(least).epsilon(1e-4));
  CHECK(learned.parameters[0].from_guess > 0.001);
  LearnOptions without;
  const LearnedNet of_data = learn({experiment(network, options, seen)}, plugins(), learnables, without);
  CHECK(std::abs(of_data.parameters[0].value - learned.parameters[0].value) > 5e-4 * of_data.parameters[0].value);
  // What the values say of the guess: 2.5 times it, as sure as their interval.
  const std::vector<GuessedValues::Found> found = values.examples(of_data);
  REQUIRE(found.size() == 1);
  const double learned_factor = of_data.parameters[0].value / of_data.parameters[0].start;
  CHECK(found[0].example.value ==
        doctest::Approx(std::log10(values.guesses()[0].value) + std::log10(learned_factor)).epsilon(1e-9));
  const double half = 0.5 * (of_data.parameters[0].upper - of_data.parameters[0].lower) / of_data.parameters[0].value;
  CHECK(found[0].example.deviation == doctest::Approx(half / 1.96 / std::numbers::ln10).epsilon(0.3));
  CHECK(std::abs(found[0].example.value - std::log10(values.guesses()[0].value) - std::log10(factor)) <
        3.0 * found[0].example.deviation);
  CHECK(stiffness(network, 0) == doctest::Approx(of_data.parameters[0].start));
}

TEST_CASE("observations without standard deviations leave a guess no weight, and it is told") {
  const Guessed guessed(blocks(wet, wet));
  SimulationOptions options = guessed.scene.options;
  options.threads = 1;
  Simulation motion(guessed.scene.network, plugins(), options);
  const Observations seen = observe(motion, 10, {0, 1});
  std::vector<Learnable> learnables{guessed.select("spring.stiffness@first:together")};
  guessed.of(learnables).set_widths(learnables);
  LearnOptions by_widths;
  by_widths.guess_rule = GuessRule::widths;
  by_widths.max_iterations = 2;
  const LearnedNet learned =
      learn({experiment(guessed.scene.network, options, seen)}, plugins(), learnables, by_widths);
  CHECK(learned.guess_weight == 0.0);
  REQUIRE_FALSE(learned.notes.empty());
  CHECK(learned.notes.back().find("standard deviations") != std::string::npos);
}

TEST_CASE("dampings alone do not tell the modulus from the damping time, with stiffnesses they do") {
  const Guessed guessed(blocks(wet, wet));
  LearnedNet learned;
  const auto add = [&](Kind kind, double start, double value) {
    LearnedParameter each;
    each.kind = kind;
    each.variable = learned.parameters.size();
    each.start = start;
    each.value = value;
    each.lower = 0.99 * value;
    each.upper = 1.01 * value;
    learned.parameters.push_back(each);
  };
  const auto body = guessed.scene.network.bodies()[0].spring_count;
  for (std::uint32_t k = 0; k < body; ++k) add(Kind::viscosity_parameter, 2.0, 12.0);
  CHECK(guessed.of({guessed.select("viscosity.damping@first")}).examples(learned).empty());
  for (std::uint32_t k = 0; k < body; ++k) add(Kind::spring_parameter, 5.0, 10.0);
  const GuessedValues both =
      guessed.of({guessed.select("viscosity.damping@first"), guessed.select("spring.stiffness@first")});
  const std::vector<GuessedValues::Found> found = both.examples(learned);
  REQUIRE(found.size() == 2);
  for (const GuessedValues::Found& each : found) {
    const SceneGuess& guess = both.guesses()[each.guess];
    const double factor = guess.key.ends_with("damping_time") ? 3.0 : 2.0;
    CHECK(each.example.value == doctest::Approx(std::log10(factor * guess.value)).epsilon(1e-9));
  }
}

TEST_CASE("values without a guess are as good as free beside those that have one, also many together") {
  const Guessed guessed(blocks(wet, "{ youngs_modulus = 2e4, damping_time = 0.01 }\ndensity = 1000.0"));
  SimulationOptions options = guessed.scene.options;
  options.threads = 1;
  Network real = guessed.scene.network;
  set_stiffness(real, real.bodies()[1], 1.5);
  Simulation motion(real, plugins(), options);
  Observations seen = observe(motion, 15, from_to(0, real.nodes().size()));
  for (Observations::VectorRow& each : seen.positions) each.weight.setConstant(1e6);
  std::vector<Learnable> learnables{guessed.select("spring.stiffness@first:together"),
                                    guessed.select("spring.stiffness@second:together")};
  guessed.of(learnables).set_widths(learnables);
  LearnOptions by_widths;
  by_widths.guess_rule = GuessRule::widths;
  const LearnedNet learned =
      learn({experiment(guessed.scene.network, options, seen)}, plugins(), learnables, by_widths);
  REQUIRE(learned.guess_weight == 1.0);
  const LearnedParameter& free = learned.parameters.back();
  CHECK(free.value / free.start == doctest::Approx(1.5).epsilon(1e-6));
  CHECK(free.from_guess < 1e-6);
}

TEST_CASE("without words there is nothing to learn of guesses") {
  const std::string numbers = "{ youngs_modulus = 2e4, damping_time = 0.01 }\ndensity = 1000.0";
  const Guessed guessed(blocks(numbers, numbers));
  std::vector<Learnable> learnables{guessed.select("spring.stiffness:together")};
  const GuessedValues none = guessed.of(learnables);
  CHECK(none.guesses().empty());
  LearnedNet learned;
  learned.parameters.resize(learnables[0].values.members.size());
  CHECK(none.examples(learned).empty());
  none.set_widths(learnables);
  CHECK(learnables[0].guess_widths.empty());
}
