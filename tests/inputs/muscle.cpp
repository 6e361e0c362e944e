// The muscle against Hill's equation and the curves of the literature.
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "law_call.hpp"
#include "laws.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

struct Sample {
  double length, rate, activation;
};

// Rest length l0, strength F; damping 0.
constexpr double l0 = 0.12, F = 80.0, v_max = 8.0, c = 0.3, f_max = 1.5, w = 0.4, k = 4.0, strain = 0.5;

test::LawAnswer evaluate(const std::vector<Sample>& samples, double damping = 0.0) {
  const auto law = plugins()->require(ComponentKind::spring_function, "muscle");
  test::LawInput input;
  input.count = static_cast<std::uint32_t>(samples.size());
  input.reference = {l0};
  input.parameters = {{F}, {v_max}, {c}, {f_max}, {w}, {k}, {strain}, {damping}};
  input.inputs.resize(1);
  for (const Sample& sample : samples) {
    input.q.push_back(sample.length);
    input.rate.push_back(sample.rate);
    input.inputs[0].push_back(sample.activation);
  }
  test::LawAnswer answer = test::evaluate(*law->description, input);
  REQUIRE(answer.status == SPRINGNET_OK);
  return answer;
}
double tension(const Sample& sample, double damping = 0.0) { return evaluate({sample}, damping).force[0]; }

}  // namespace

TEST_CASE("in shortening a muscle obeys Hill's equation") {
  // (P + a) (v + b) = (F + a) b with a = c F, b = c v_max, at the rest length.
  for (double share = 0.05; share < 1.0; share += 0.05) {
    const double v = share * v_max, P = tension({l0, -v * l0, 1.0});
    CHECK((P + c * F) * (v + c * v_max) == doctest::Approx((F + c * F) * c * v_max).epsilon(1e-13));
  }
  CHECK(tension({l0, -v_max * l0, 1.0}) == doctest::Approx(0.0).epsilon(1e-12));
  CHECK(tension({l0, -3.0 * v_max * l0, 1.0}) == 0.0);
}

TEST_CASE("force over length, passive force, fast lengthening") {
  CHECK(tension({l0, 0, 1}) == doctest::Approx(F).epsilon(1e-14));
  CHECK(tension({l0, 0, 0.25}) == doctest::Approx(0.25 * F).epsilon(1e-14));
  CHECK(tension({l0, 0, 0}) == 0.0);
  const double short_by = 0.3;
  CHECK(tension({(1 - short_by) * l0, 0, 1}) == doctest::Approx(F * std::exp(-short_by * short_by / w)).epsilon(1e-13));
  CHECK(tension({(1 + strain) * l0, 0, 0}) == doctest::Approx(F).epsilon(1e-13));
  CHECK(tension({(1 + 0.5 * strain) * l0, 0, 0}) ==
        doctest::Approx(F * std::expm1(0.5 * k) / std::expm1(k)).epsilon(1e-13));
  CHECK(tension({l0, 1e9, 1}) == doctest::Approx(f_max * F).epsilon(1e-6));
  CHECK(tension({l0, 0.5 * v_max * l0, 0}, 0.2) == doctest::Approx(0.2 * 0.5 * F).epsilon(1e-13));
}

TEST_CASE("the slope over the speed is continuous where a muscle is at rest") {
  constexpr double d = 1e-6;
  const auto at = [&](double v) { return tension({l0, v * l0 * v_max, 1.0}); };
  const double before = (at(0) - at(-d)) / d, after = (at(d) - at(0)) / d;
  CHECK(before == doctest::Approx(F * (1 + 1 / c)).epsilon(1e-4));
  CHECK(after == doctest::Approx(before).epsilon(1e-4));
  for (const double v : {-1e-300, -0.0, 0.0, 1e-300})
    CHECK(evaluate({{l0, v, 1.0}}).by_rate[0] == doctest::Approx(F * (1 + 1 / c) / (l0 * v_max)).epsilon(1e-14));
}

TEST_CASE("derivatives are those of the tension") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> length(0.5, 1.6), speed(-0.9, 0.9), activation(0, 1);
  for (int n = 0; n < 200; ++n) {
    Sample at{length(random) * l0, speed(random) * v_max * l0, activation(random)};
    if (std::abs(at.length / l0 - 1) < 0.02 || std::abs(at.rate) < 0.02 * v_max * l0)
      continue;  // second derivatives jump
    const test::LawAnswer answer = evaluate({at}, 0.1);
    const auto difference = [&](double Sample::*of, double size) {
      const auto moved = [&](double by) {
        Sample sample = at;
        sample.*of += by * size;
        return tension(sample, 0.1);
      };
      return (45 * (moved(1) - moved(-1)) - 9 * (moved(2) - moved(-2)) + (moved(3) - moved(-3))) / (60 * size);
    };
    CHECK(answer.by_q[0] == doctest::Approx(difference(&Sample::length, 1e-3 * l0)).epsilon(1e-7).scale(F / l0));
    CHECK(answer.by_rate[0] ==
          doctest::Approx(difference(&Sample::rate, 1e-3 * l0 * v_max)).epsilon(1e-7).scale(F / (l0 * v_max)));
  }
}

// Without a load the muscle shortens at its greatest speed, but for the force that its mass takes.
TEST_CASE("a weight that a muscle lifts rises at Hill's speed") {
  // At the rest length, where the force over length is flat: started there at the speed of the equation it stays.
  constexpr double weight = 30.0, mass = 1e-4;  // N, kg
  const double v = v_max * c * (F - weight) / (weight + c * F);
  Network net = oscillator(
      {LawUse{"muscle",
              {{"strength", F}, {"maximum_speed", v_max}, {"curvature", c}, {"width", 1e6}, {"damping", 0.0}}},
       std::nullopt},
      mass, 0.0, -v);
  net.add_load({{1}, {weight, 0, 0}});
  Input input;
  input.input = "activation";
  input.springs = {0};
  input.signal = constant(1);
  net.add_input(input);
  for (const LawUse& method : {recurrent(newton, 1e-9), cvode(1e-9), recurrent(newton, 1e-9, {{"theta", 0.5}})}) {
    CAPTURE(method.id);
    Simulation simulation = simulate_with_inputs(net, method, 1e-3);
    simulation.advance_to(0.02);
    CHECK(simulation.position(1)[0] == doctest::Approx(1.0 - 0.02 * v).epsilon(1e-5));
    CHECK(simulation.velocity(1)[0] == doctest::Approx(-v).epsilon(1e-4));
  }
}
