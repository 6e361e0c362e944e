// Derivatives of motions whose laws have internal states: the adjoint against the tangent, and both against differences
// of the motion, for each law with states.

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/formula.hpp>
#include <springnet/host_laws.hpp>
#include <springnet/motion_derivatives.hpp>

#include "generator.hpp"
#include "motion_loss.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// Steps exactly where the length is what it is in the middle: its own update reads the start of the step.
struct MiddleMaxwell : sdk::SpringFunction {
  using has = sdk::Has<sdk::Update>;
  static constexpr const char *id = "middle_maxwell", *summary = "relaxes by an exponential";
  static constexpr bool fits_elements = true;
  static constexpr bool reads_rate = true;
  static constexpr sdk::Parameter parameters[] = {
      sdk::number("stiffness", "N/m", "of the spring").at_least(0).learnable(),
      sdk::number("relaxation_time", "s", "of the dashpot").above(0).learnable()};
  static constexpr sdk::Parameter states[] = {sdk::number("flow", "m", "of the dashpot").preset(0).learnable(0.01)};

  static auto force(const auto& e, const auto& p) { return p[0] * (e.elongation() - e.state(0)); }
  static auto state_rates(const auto& e, const auto& p) {
    return std::array{(e.elongation() - e.state(0)) / p[1] + 0.1 * e.rate};
  }
  static auto update(const auto& e, const auto& p, const auto& step) {
    const auto x = 0.5 * (e.q + step.start_q) - e.reference;
    return std::array{x + (e.state(0) - x) * exp(-step.duration / p[1]) +
                      0.05 * step.duration * (e.rate + step.start_rate)};
  }
};

// A damper along the relative velocity that gets weaker by use.
struct Wearing : sdk::ViscosityFunction {
  static constexpr const char *id = "wearing", *summary = "Q = d (1 - z) |dv|, z' = r (|dv| - z)";
  static constexpr std::uint32_t invariant = SPRINGNET_RELATIVE_SPEED;
  static constexpr bool reads_rate = false;
  static constexpr sdk::Parameter parameters[] = {
      sdk::number("damping", "N s/m", "of the new damper").at_least(0).learnable(),
      sdk::number("wear", "1/s", "how fast it wears").at_least(0).learnable()};
  static constexpr sdk::Parameter states[] = {sdk::number("worn", "1", "share").preset(0.1).learnable(0.1)};
  static auto force(const auto& e, const auto& p) { return p[0] * (1.0 - 0.3 * e.state(0)) * e.q; }
  static auto state_rates(const auto& e, const auto& p) { return std::array{p[1] * (e.q - e.state(0))}; }
};

std::shared_ptr<const PluginHost> all_laws() {
  static const std::shared_ptr<const PluginHost> host = [] {
    auto made = std::make_shared<PluginHost>(PluginHost::with_default_search());
    made->add(spring_function(MiddleMaxwell{}));
    made->add(viscosity_function(Wearing{}));
    return made;
  }();
  return host;
}

// Two states that drive each other, and read the rate and an input.
LawUse formula() {
  LawFormula law;
  law.force = "k*e*(1 + 0.3*a) + c*flow - d*seen";
  law.parameters = {{"k"}, {"c"}, {"d"}, {"tau"}};
  law.inputs = {{"a"}};
  law.states = {{"flow", "(e - flow)/tau + 0.2*seen"}, {"seen", "(rate - seen)/0.05 - a*flow"}};
  law.smooth_rates = true;
  return law_of(law, {{"k", 30.0}, {"c", 12.0}, {"d", 0.5}, {"tau", 0.12}});
}

struct Case {
  std::string name;
  LawUse law;
  std::vector<std::string> parameters;
  bool elements = true;  // it fits them
  // Of the differences. A law with kinks has to stay between two of them: a short step, and more of the rounding and of
  // the tolerance of the motion's own steps, 1e-12 N, over it.
  double step = 2e-3, precision = 1e-7;
};

// A block with the law in some springs, an angle, an area and a volume, beside springs and dampers that hold it.
Network held_block(const Case& of, const LawUse& viscosity) {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 2, 2};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, {}, net.add_material(damped(40.0, 0.4)));
  Dice dice(5);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.position += dice.in_box(0.05);
    own.velocity = dice.in_box(0.8);
    own.mass = dice.between(0.5, 2.0);
    net.set_node(k, own);
  }
  net.fix(0);
  const MaterialIndex material = net.add_material({of.law, viscosity.id.empty() ? std::optional<LawUse>() : viscosity});
  for (const auto& [a, b] : {std::pair{1u, 6u}, {2u, 11u}, {3u, 8u}, {4u, 9u}, {5u, 10u}})
    net.add_spring(a, b, material, 1.3);
  if (of.elements) {
    const MaterialIndex own = net.add_material({of.law, {}});
    net.add_element(Invariant::angle, {1, 2, 5}, own, 1.4);
    net.add_element(Invariant::area, {3, 4, 7}, own, 0.6);
    net.add_element(Invariant::volume, {3, 4, 7, 10}, own, 0.25);
  }
  Load load;
  load.nodes = {10, 11};
  load.force = {12.0, 0, 4.0};
  load.from = 0.03;
  load.until = 0.17;
  net.add_load(load);
  net.set_gravity({0, 0, -3.0});
  return net;
}

void check(const Case& of, const LawUse& viscosity = {}, const Signal* signal = nullptr,
           std::vector<LearnedValues> more = {}) {
  CAPTURE(of.name);
  Network made = held_block(of, viscosity);
  const std::size_t springs = made.springs().size(), elements = made.elements().size();
  std::vector<std::uint32_t> own;
  for (std::size_t s = springs - 5; s < springs; ++s) own.push_back(static_cast<std::uint32_t>(s));
  if (signal != nullptr) made.add_input({"a", "", own, all(elements), *signal});
  const auto net = std::make_shared<const Network>(std::move(made));
  std::vector<LearnedValues> learned = std::move(more);
  for (const std::string& each : of.parameters) {
    learned.push_back({Kind::spring_parameter, false, each, own});
    if (of.elements) learned.push_back({Kind::spring_parameter, true, each, all(elements)});
  }
  learned.push_back({Kind::rest_length, false, "", all(springs)});
  if (of.elements) learned.push_back({Kind::rest_length, true, "", all(elements)});
  learned.push_back({Kind::viscosity_parameter, false, "damping", all(springs - 5)});
  learned.push_back({Kind::mass, false, "", {1, 4, 7}});
  learned.push_back({Kind::initial_velocity, false, "", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}});
  for (const double theta : {1.0, 0.5})
    for (const double rule : {newton, synchronous}) {
      CAPTURE(theta);
      CAPTURE(rule);
      MotionDerivatives motion(net, all_laws(), method(theta, rule), 0.3, learned);
      const VectorXd values = motion.values_of_network();
      motion.run(values);
      const Loss loss(16, net->nodes().size());
      const VectorXd gradient = loss.gradient(motion);
      Dice dice(3);
      Eigen::MatrixXd changes(values.size(), 3);
      for (Eigen::Index i = 0; i < changes.size(); ++i)
        changes.data()[i] = 0.3 * dice.between(-1, 1) * std::max(0.1, std::abs(values[i % values.size()]));
      const VectorXd along = loss.along(motion, changes);
      for (Eigen::Index j = 0; j < 3; ++j) {
        CHECK(gradient.dot(changes.col(j)) == doctest::Approx(along[j]).epsilon(1e-9));  // systems are solved to 1e-10
        const auto at = [&](double h) {
          motion.run(values + h * changes.col(j));
          return loss.of(motion);
        };
        const double h = of.step;
        const double difference =
            (45.0 * (at(h) - at(-h)) - 9.0 * (at(2 * h) - at(-2 * h)) + at(3 * h) - at(-3 * h)) / (60.0 * h);
        CHECK(along[j] == doctest::Approx(difference).epsilon(of.precision));
      }
    }
}

}  // namespace

TEST_CASE("the gradient of a motion with internal states is that of its differences, for each law that has some") {
  check({"maxwell", {"maxwell", {{"stiffness", 60.0}, {"relaxation_time", 0.1}}}, {"stiffness", "relaxation_time"}});
  check({"standard_linear_solid",
         {"standard_linear_solid", {{"stiffness", 20.0}, {"fast_stiffness", 50.0}, {"relaxation_time", 0.07}}},
         {"stiffness", "fast_stiffness", "relaxation_time"}});
  check({"plastic",
         {"plastic", {{"stiffness", 50.0}, {"yield_tension", 3.0}, {"hardening", 5.0}, {"relaxation_time", 0.05}}},
         {"stiffness", "yield_tension", "hardening", "relaxation_time"},
         true,
         1e-5,
         1e-6});
  check({"damaging",
         {"damaging",
          {{"stiffness", 60.0}, {"threshold_strain", 0.02}, {"softening_strain", 0.8}, {"relaxation_time", 0.1}}},
         {"stiffness", "threshold_strain", "softening_strain", "relaxation_time"},
         true,
         1e-5,
         1e-6});
}

TEST_CASE("states that start by a rest length which is learned are refused") {
  const Case relaxed{
      "relaxed", {"maxwell", {{"stiffness", 60.0}, {"relaxation_time", 0.1}, {"starts_relaxed", 1}}}, {}, false};
  const auto net = std::make_shared<const Network>(held_block(relaxed, {}));
  const auto last = static_cast<SpringIndex>(net->springs().size() - 1);
  CHECK_THROWS_WITH_AS(
      MotionDerivatives(net, all_laws(), method(1.0, newton), 0.3, {{Kind::rest_length, false, "", {0, last}}}),
      doctest::Contains(("internal states of spring " + std::to_string(last)).c_str()), Error);
  MotionDerivatives(net, all_laws(), method(1.0, newton), 0.3, {{Kind::rest_length, false, "", {0}}});
  MotionDerivatives(net, all_laws(), method(1.0, newton), 0.3, {{Kind::spring_parameter, false, "stiffness", {last}}});
}

TEST_CASE("so it is for formulas with an input, viscosities with states and steps of a law's own") {
  Signal signal;
  signal.mean = 0.4;
  signal.amplitude = 0.3;
  signal.frequency = 4.0;
  check({"formula", formula(), {"k", "c", "d", "tau"}}, {}, &signal);
  check({"middle_maxwell",
         {"middle_maxwell", {{"stiffness", 60.0}, {"relaxation_time", 0.1}}},
         {"stiffness", "relaxation_time"}});
  const LawUse wearing{"wearing", {{"damping", 1.5}, {"wear", 4.0}}};
  check({"wearing beside maxwell", {"maxwell", {{"stiffness", 60.0}, {"relaxation_time", 0.1}}}, {"stiffness"}},
        wearing);
}
