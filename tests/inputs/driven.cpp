// Masses and states that a signal drives, against closed forms, in every integrator and rule.
#include <cmath>
#include <functional>
#include <vector>

#include <doctest/doctest.h>

#include "../states/methods.hpp"
#include "laws.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;
using enum Signal::Interpolation;

constexpr double mass = 2.0, end = 1.2;

Network driven(const LawUse& law, const Signal& signal, bool held) {
  Network net = oscillator({law, std::nullopt}, mass, 0.5);
  if (held) net.fix(1);
  net.add_node(point({0, 0, 5}));  // something that moves
  Input input;
  input.input = "tension";
  input.springs = {0};
  input.signal = signal;
  net.add_input(input);
  return net;
}

// The integral over [0, t] of the function, and the integral of that, by Simpson's rule on pieces without kinks.
struct Integrals {
  double once, twice;
};
Integrals integrate(const std::function<double(double)>& u, const std::vector<double>& kinks, double t) {
  Integrals sum{0.0, 0.0};
  std::vector<double> ends{0.0};
  for (const double kink : kinks)
    if (kink > 0.0 && kink < t) ends.push_back(kink);
  ends.push_back(t);
  constexpr int pieces = 200;
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    const double a = ends[k], h = (ends[k + 1] - a) / pieces, inside = 1e-12 * h;
    for (int i = 0; i < pieces; ++i) {
      const double from = a + i * h, to = from + h, middle = from + 0.5 * h;
      const double u0 = u(from + inside), u1 = u(middle), u2 = u(to - inside);
      sum.once += h / 6.0 * (u0 + 4.0 * u1 + u2);
      sum.twice += h / 6.0 * (u0 * (t - from) + 4.0 * u1 * (t - middle) + u2 * (t - to));
    }
  }
  return sum;
}

struct Driving {
  const char* name;
  Signal signal;
  std::function<double(double)> value;
  std::vector<double> kinks;
};

std::vector<Driving> drivings() {
  Signal wave;
  wave.mean = 1.0;
  wave.amplitude = 3.0;
  wave.frequency = 1.25;
  return {{"hold",
           table({0, 0.4, 0.8}, {2, -5, 4}, hold),
           [](double t) { return t < 0.4   ? 2.0
                                 : t < 0.8 ? -5.0
                                           : 4.0; },
           {0.4, 0.8}},
          {"linear",
           table({0, 0.4, 0.8}, {0, 4, -2}, linear),
           [](double t) { return t < 0.4   ? 10.0 * t
                                 : t < 0.8 ? 4.0 - 15.0 * (t - 0.4)
                                           : -2.0; },
           {0.4, 0.8}},
          // Two entries: Hermite's cubic with level ends.
          {"cubic",
           table({0, 0.8}, {0, 4}, cubic),
           [](double t) {
             const double s = std::min(t / 0.8, 1.0);
             return 4.0 * s * s * (3.0 - 2.0 * s);
           },
           {0.8}},
          {"sinusoid", wave, [](double t) { return 1.0 + 3.0 * std::sin(2.5 * std::acos(-1.0) * t); }, {}}};
}

}  // namespace

TEST_CASE("a mass that a signal draws follows the integral of the signal") {
  for (const Driving& course : drivings()) {
    const Integrals exact = integrate(course.value, course.kinks, end);
    const Network net = driven({"motor", {}}, course.signal, false);
    const auto error = [&](const LawUse& integrator, double h) {
      Simulation simulation = simulate_with_inputs(net, integrator, h);
      simulation.advance_to(end);
      return std::hypot(simulation.position(1)[0] - (1.5 - exact.twice / mass),
                        simulation.velocity(1)[0] + exact.once / mass);
    };
    for (const StateMethod& method : state_methods(1e-12)) {
      CAPTURE(course.name);
      CAPTURE(method.name);
      if (method.order == 0) {
        // Without a stop at a jump its step control would meet it by chance.
        CHECK(error(method.integrator, 0.3) < 1e-8);
        continue;
      }
      // Steps end at the jumps and kinks. A trapezoidal step is exact where the signal is constant.
      const double coarse = error(method.integrator, 0.02), fine = error(method.integrator, 0.01);
      CAPTURE(coarse);
      CAPTURE(fine);
      if (method.order == 2 && coarse < 1e-10) continue;
      CHECK(fine < (method.order == 1 ? 0.1 : 2e-3));
      CHECK(std::log2(coarse / fine) == doctest::Approx(method.order).epsilon(0.1));
    }
  }
}

TEST_CASE("a trapezoidal step is exact between jumps of a signal at the ends of steps") {
  const Driving course = drivings().front();
  const Integrals exact = integrate(course.value, course.kinks, end);
  for (const char* rule : update_rules) {
    CAPTURE(rule);
    Simulation simulation = simulate_with_inputs(driven({"motor", {}}, course.signal, false),
                                                 recurrent(update_named(rule), 1e-12, {{"theta", 0.5}}), 0.02);
    simulation.advance_to(end);
    CHECK(simulation.position(1)[0] == doctest::Approx(1.5 - exact.twice / mass).epsilon(1e-12));
    CHECK(simulation.velocity(1)[0] == doctest::Approx(-exact.once / mass).epsilon(1e-12));
  }
}

TEST_CASE("a step with located events is divided at each of the jumps within it") {
  // 2 N, from 0.1 s on -5 N, from 0.3 s on 4 N; steps of 0.4 s.
  const auto value = [](double t) { return t < 0.1 ? 2.0 : t < 0.3 ? -5.0 : 4.0; };
  const Integrals exact = integrate(value, {0.1, 0.3}, end);
  Simulation simulation = simulate_with_inputs(driven({"motor", {}}, table({0, 0.1, 0.3}, {2, -5, 4}, hold), false),
                                               recurrent(newton, 1e-12, {{"theta", 0.5}, {"events", 1}}), 0.4);
  simulation.advance_to(end);
  CHECK(simulation.position(1)[0] == doctest::Approx(1.5 - exact.twice / mass).epsilon(1e-12));
  CHECK(simulation.velocity(1)[0] == doctest::Approx(-exact.once / mass).epsilon(1e-12));
}

// z' = (u - z) / tau with u from straight pieces: z = u - s tau + (z0 - u0 + s tau) exp(-t / tau) on each.
TEST_CASE("a state that follows a signal converges in the order of its method") {
  constexpr double tau = 0.15;
  const std::vector<double> times{0, 0.4, 0.8, end}, values{1, 4, -2, -2};
  double exact = 0.0;
  for (std::size_t k = 0; k + 1 < times.size(); ++k) {
    const double t = times[k + 1] - times[k], lag = (values[k + 1] - values[k]) / t * tau;
    exact = values[k + 1] - lag + (exact - values[k] + lag) * std::exp(-t / tau);
  }
  const Signal signal = table({0, 0.4, 0.8}, {1, 4, -2}, linear);
  for (const char* law : {"follower", "exact_follower"}) {
    const bool own_step = law[0] == 'e';
    const Network net = driven({law, {{"lag", tau}}}, signal, true);
    for (const StateMethod& method : state_methods(1e-12)) {
      CAPTURE(law);
      CAPTURE(method.name);
      const auto error = [&](double h) {
        Simulation simulation = simulate_with_inputs(net, method.integrator, h);
        simulation.advance_to(end);
        return std::abs(simulation.internal_states(0).at(0) - exact);
      };
      if (method.order == 0) {
        CHECK(error(0.3) < 1e-8);
        continue;
      }
      const double coarse = error(0.01), fine = error(0.005);
      CAPTURE(coarse);
      CAPTURE(fine);
      if (own_step) {
        CHECK(coarse < 1e-12);
        continue;
      }
      CHECK(fine < (method.order == 1 ? 0.1 : 1e-3));
      CHECK(std::log2(coarse / fine) == doctest::Approx(method.order).epsilon(0.1));
    }
  }
}

// A jump is the limit of a steep ramp.
TEST_CASE("a jump is a steep ramp") {
  const auto position = [](const Signal& signal) {
    Simulation simulation = simulate_with_inputs(driven({"motor", {}}, signal, false), cvode(1e-10), 0.1);
    simulation.advance_to(end);
    return simulation.position(1)[0];
  };
  const double jump = position(table({0, 0.4}, {2, -5}, hold));
  for (const double width : {1e-2, 1e-4, 1e-6}) {
    const double ramp = position(table({0.4 - 0.5 * width, 0.4 + 0.5 * width}, {2, -5}, linear));
    // The same momentum; the positions differ by 7 N width^2 / (24 m).
    CHECK(std::abs(ramp - jump) < 0.2 * width * width + 1e-9);
  }
}
