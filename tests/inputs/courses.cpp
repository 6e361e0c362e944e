// Values of signals over time, at their jumps and kinks.
#include <cmath>
#include <limits>
#include <numbers>

#include <doctest/doctest.h>

#include "laws.hpp"
#include "layers/signals.hpp"
#include "network/signal_course.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;
using enum Signal::Interpolation;
constexpr double never = std::numeric_limits<double>::infinity();

Input input_of(const Signal& signal) {
  Input input;
  input.input = "tension";
  input.springs = {0};
  input.signal = signal;
  return input;
}

}  // namespace

TEST_CASE("hold keeps the value of an entry until the next, where it jumps") {
  const SignalCourse course(table({1, 2, 4}, {5, 7, -3}, hold));
  CHECK(course.at(-10) == 5);
  CHECK(course.at(1) == 5);
  CHECK(course.at(std::nextafter(2.0, 0.0)) == 5);
  CHECK(course.at(2) == 7);
  CHECK(course.at(3.9) == 7);
  CHECK(course.at(4) == -3);
  CHECK(course.at(1e9) == -3);
  CHECK(course.next_kink(1.5) == 2);
  CHECK(course.next_kink(2) == 4);
  CHECK(course.next_kink(4) == never);
}

TEST_CASE("linear and cubic signals go through their entries") {
  const std::vector<double> times{0, 1, 3, 4}, values{0, 2, 2.5, 1};
  for (const auto interpolation : {linear, cubic}) {
    const SignalCourse course(table(times, values, interpolation));
    for (std::size_t k = 0; k < times.size(); ++k) CHECK(course.at(times[k]) == doctest::Approx(values[k]));
    CHECK(course.at(-1) == 0);
    CHECK(course.at(9) == 1);
    CHECK(course.next_kink(0.5) == 1);
    for (double t = 0; t < 4; t += 0.01) CHECK((course.at(t) >= 0 && course.at(t) <= 2.5));
  }
  CHECK(SignalCourse(table(times, values, linear)).at(2) == doctest::Approx(2.25));
  // The slope of a cubic is continuous at an entry, that of lines is not.
  const auto bend = [&](Signal::Interpolation interpolation) {
    const SignalCourse course(table(times, values, interpolation));
    constexpr double d = 1e-6;
    return std::abs((course.at(1 + d) - course.at(1)) / d - (course.at(1) - course.at(1 - d)) / d);
  };
  CHECK(bend(cubic) < 1e-4);
  CHECK(bend(linear) == doctest::Approx(1.75).epsilon(1e-6));
}

TEST_CASE("a sinusoid has no kinks, a constant does not vary") {
  Signal signal;
  signal.mean = 0.5;
  signal.amplitude = 0.25;
  signal.frequency = 2.0;
  signal.phase = 0.3;
  const SignalCourse course(signal);
  CHECK(course.at(0.7) == doctest::Approx(0.5 + 0.25 * std::sin(4.0 * std::numbers::pi * 0.7 + 0.3)).epsilon(1e-14));
  CHECK(course.next_kink(0) == never);
  CHECK(SignalCourse(constant(3)).is_constant());
  CHECK(SignalCourse(constant(3)).at(17) == 3);
  CHECK(SignalCourse(table({0, 1}, {4, 4}, cubic)).at(0.5) == 4);
}

TEST_CASE("in a step signals are right limits at its start and left limits at its end") {
  layers::Signals signals({input_of(table({0, 0.3}, {1, 2}, hold))});
  const double jump = 0.1 + 0.2;  // a little after 0.3
  CHECK_FALSE(signals.set_interval(0.2, jump, 0.1));
  CHECK(signals.at(0, 0.2) == 1);
  CHECK(signals.at(0, jump) == 1);
  signals.sample(jump);
  CHECK(signals.at(0, jump) == 1);
  CHECK(signals.set_interval(jump, 0.4, 0.1));
  CHECK_FALSE(signals.set_interval(jump, 0.4, 0.1));  // a step that is made again
  CHECK(signals.at(0, jump) == 2);
  CHECK(signals.at_start(0, 0.4, 0.4 - jump) == 2);
  // Times a little before the jump are those of the jump, too.
  layers::Signals early({input_of(table({0, 0.3}, {1, 2}, hold))});
  CHECK_FALSE(early.set_interval(0.2, std::nextafter(0.3, 0.0), 0.1));
  CHECK(early.set_interval(std::nextafter(0.3, 0.0), 0.4, 0.1));
  CHECK(early.at(0, std::nextafter(0.3, 0.0)) == 2);
  CHECK(signals.next_kink(0.1) == 0.3);
  // However far the end of a step is, signals without jumps are read at the time itself.
  layers::Signals long_step({input_of(table({0, 1}, {0, 1}, linear))});
  CHECK_FALSE(long_step.set_interval(0.2, 1e9, 0.1));
  CHECK(long_step.at(0, 0.2 + 1e-6) == doctest::Approx(0.2 + 1e-6).epsilon(1e-14));
  signals.hold(0, 9);
  CHECK(signals.at(0, 0.35) == 9);
  CHECK(signals.next_kink(0.1) == never);
}
