// Loads over time: impulses, closed forms, orders.
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "methods.hpp"
#include "network/load_course.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

const double pi = std::acos(-1.0);

Course sinusoid(double frequency, double phase = 0.0, double mean = 0.0) {
  Course course;
  course.frequency = frequency;
  course.phase = phase;
  course.mean = mean;
  return course;
}
Course ramp(double seconds) {
  Course course;
  course.ramp = seconds;
  return course;
}
Course uneven_course(Motion::Interpolation interpolation) {
  Course course;
  course.times = {0.11, 0.3, 0.42, 0.9};
  course.factors = {0.0, 2.0, -1.0, 0.5};
  course.interpolation = interpolation;
  return course;
}

std::vector<Course> all_courses() {
  return {{},
          sinusoid(3.7, 0.4, 0.2),
          ramp(0.33),
          uneven_course(Motion::Interpolation::linear),
          uneven_course(Motion::Interpolation::smooth)};
}

Network under(Network net, const Vector3& force, const Course& course, double from, double until) {
  Load load{{static_cast<NodeIndex>(net.nodes().size() - 1)}, force, from, until};
  load.course = course;
  net.add_load(load);
  return net;
}

}  // namespace

TEST_CASE("the impulse of a load over time is exact, whatever the steps") {
  constexpr double mass = 0.4, end = 1.0;
  const Vector3 force(2.0, -1.0, 0.5);
  const LawUse ways[] = {recurrent(newton, 1e-13),
                         recurrent(newton, 1e-13, {{"theta", 0.5}}),
                         recurrent(wavefront, 1e-13, {{"theta", 0.5}}),
                         single_sweep(),
                         {"verlet", {}}};
  for (const Course& course : all_courses()) {
    for (const auto& [from, until] : {std::pair{0.07, 0.77}, {0.0, 2.0}}) {
      Network single;
      single.add_node(point(Vector3::Zero(), mass));
      const Network net = under(single, force, course, from, until);
      const double last = std::min(until, end);
      const Vector3 momentum = force * LoadCourse(net.loads()[0]).mean(from, last) * (last - from);
      for (const LawUse& way : ways) {
        for (const double step : {0.25, 0.03, 0.0071}) {
          Simulation simulation = simulate(net, way, step);
          simulation.advance_to(end);
          CHECK((simulation.momentum() - momentum).norm() <= 1e-13);
        }
      }
      // The reference to its tolerance; it stops at every kink.
      Simulation reference = simulate(net, cvode(reference_tolerance), 0.25);
      reference.advance_to(end);
      CHECK((reference.momentum() - momentum).norm() <= 10.0 * mass * reference_error(reference));
    }
  }
}

TEST_CASE("an oscillator in resonance follows its closed form, in CVODE") {
  constexpr double mass = 0.5, stiffness = 8.0, force = 0.01;  // 4 rad/s
  const double rate = std::sqrt(stiffness / mass);
  const Network net = under(oscillator(damped(stiffness, 0.0), mass, 0.0), {force, 0, 0}, sinusoid(rate / (2 * pi)),
                            0.0, std::numeric_limits<double>::infinity());
  for (const double method : {0.0, 1.0}) {
    Simulation simulation = simulate(net, cvode(reference_tolerance, {{"method", method}}), 0.5);
    for (int i = 1; i <= 12; ++i) {
      simulation.step();
      const double t = 0.5 * i;
      // m x'' + k x = F sin(w t) from rest: x = F / (2 k) (sin(w t) - w t cos(w t)).
      const double x = force / (2.0 * stiffness) * (std::sin(rate * t) - rate * t * std::cos(rate * t));
      CHECK(std::abs(simulation.position(1).x() - 1.0 - x) <= 10.0 * reference_error(simulation));
    }
  }
}

TEST_CASE("a free node under a ramp, in CVODE: the third power of time, then the second") {
  Network single;
  single.add_node(point(Vector3::Zero(), 2.0));
  const Network net = under(single, {0, 3, 0}, ramp(0.4), 0.1, 2.0);
  Simulation simulation = simulate(net, cvode(reference_tolerance), 0.05);
  for (int i = 1; i <= 20; ++i) {
    simulation.step();
    const double t = 0.05 * i, rise = std::clamp(t - 0.1, 0.0, 0.4), held = std::max(0.0, t - 0.5);
    const double a = 1.5;
    const double y = a * (rise * rise * rise / (6.0 * 0.4) + held * (0.4 / 2.0) + held * held / 2.0);
    CHECK(std::abs(simulation.position(0).y() - y) <= 10.0 * reference_error(simulation));
    CHECK(simulation.force(0).y() == doctest::Approx(3.0 * rise / 0.4).epsilon(1e-11));  // at the time of the record
  }
}

TEST_CASE("orders of convergence hold under a load that changes continuously") {
  const Network net = under(oscillator(damped(30.0, 1.0), 0.5, 0.1), {1.0, 0.4, 0}, sinusoid(1.3, 0.7, 0.1), 0.0, 10.0);
  constexpr double end = 1.0;
  Simulation reference = simulate(net, cvode(1e-11), end);
  reference.advance_to(end);
  const auto error = [&](const LawUse& way, double step) {
    Simulation simulation = simulate(net, way, step);
    simulation.advance_to(end);
    return (simulation.position(1) - reference.position(1)).norm();
  };
  const auto ratio = [&](const LawUse& way, double step) { return error(way, step) / error(way, 0.5 * step); };
  // Up to the next order in the step.
  CHECK(ratio(recurrent(newton, 1e-13), 0.005) == doctest::Approx(2.0).epsilon(0.1));
  CHECK(ratio(recurrent(newton, 1e-13, {{"theta", 0.5}}), 0.02) == doctest::Approx(4.0).epsilon(0.1));
  CHECK(ratio({"verlet", {}}, 0.01) == doctest::Approx(4.0).epsilon(0.15));
  CHECK(ratio(generalized_alpha(), 0.01) == doctest::Approx(4.0).epsilon(0.15));
}

TEST_CASE("a load that rises presses a node down, and one that swings lifts it again") {
  for (const LawUse& way : {recurrent(newton, 1e-10), cvode(1e-9)}) {
    Network net;
    net.add_node(point({0, 0, 0}));
    net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
    Load load{{0}, {0, 0, -2}, 0.0};
    load.course = sinusoid(0.5, 0.5 * pi);  // cosine: it turns up after half a second
    net.add_load(load);
    Simulation simulation = simulate(net, way, 0.02);
    simulation.advance_to(0.4);
    CHECK(simulation.touching(0));
    // The network's is the mean over its last step.
    CHECK(simulation.reaction(0).z() == doctest::Approx(2.0 * std::cos(pi * 0.4)).epsilon(0.12));
    simulation.advance_to(0.6);
    CHECK_FALSE(simulation.touching(0));
    CHECK(simulation.position(0).z() > 0.0);
  }
}

TEST_CASE("the reaction of a fixed node balances the load at that time") {
  Network net = oscillator(damped(10.0, 0.0), 1.0, 0.0);
  Load load{{0}, {3, 0, 0}, 0.0};
  load.course = ramp(2.0);
  net.add_load(load);
  Simulation simulation = simulate(net, cvode(1e-9), 0.5);
  simulation.step();
  CHECK(simulation.reaction(0).x() == doctest::Approx(-0.75).epsilon(1e-12));
}
