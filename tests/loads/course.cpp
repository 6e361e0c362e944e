// The factor of a load over time, and which ones a network accepts.
#include <cmath>
#include <string>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "nets.hpp"
#include "network/load_course.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Load with(const Course& course, double from = -std::numeric_limits<double>::infinity()) {
  Load load{{0}, {1, 0, 0}, from};
  load.course = course;
  return load;
}

Course table(Motion::Interpolation interpolation) {
  Course course;
  course.times = {0.5, 0.8, 1.7, 2.0};
  course.factors = {0.2, 1.4, -0.3, -0.3};
  course.interpolation = interpolation;
  return course;
}

// Simpson's rule on pieces between kinks: exact for cubics, and to (h rate)^4 for a sine.
double integral(const LoadCourse& course, double from, double until) {
  double sum = 0.0;
  for (double a = from; a < until;) {
    const double b = std::min({until, course.next_kink(a), a + 0.01});
    const double h = b - a, inside = 1e-9 * h;  // values beside a kink
    sum += h / 6.0 * (course.at(a + inside) + 4.0 * course.at(a + 0.5 * h) + course.at(b - inside));
    a = b;
  }
  return sum;
}

std::string refusal(const Load& load) {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0)}) net.add_node(point(p));
  try {
    net.add_load(load);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    CHECK(net.loads().empty());
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("a load without a course acts with the factor 1") {
  const LoadCourse course(with({}));
  CHECK(course.is_constant());
  CHECK(course.at(-3.0) == 1.0);
  CHECK(course.mean(0.0, 2.0) == 1.0);
  CHECK(course.next_kink(0.0) == std::numeric_limits<double>::infinity());
}

TEST_CASE("factors are those of the formulas") {
  Course ramp;
  ramp.ramp = 0.5;
  CHECK(LoadCourse(with(ramp)).at(0.2) == doctest::Approx(0.4));
  CHECK(LoadCourse(with(ramp, 1.0)).at(1.1) == doctest::Approx(0.2));  // counts from the start of the load
  CHECK(LoadCourse(with(ramp, 1.0)).at(9.0) == 1.0);
  CHECK(LoadCourse(with(ramp, 1.0)).next_kink(1.0) == 1.5);
  Course wave;
  wave.frequency = 2.0;
  wave.phase = 0.3;
  wave.amplitude = 1.5;
  wave.mean = -0.2;
  const double pi = std::acos(-1.0);
  CHECK(LoadCourse(with(wave, 0.1)).at(0.4) == doctest::Approx(-0.2 + 1.5 * std::sin(4.0 * pi * 0.3 + 0.3)));
  CHECK(LoadCourse(with(wave)).greatest() == doctest::Approx(1.7));
  const LoadCourse straight(with(table(Motion::Interpolation::linear)));
  CHECK(straight.at(0.0) == 0.2);  // before its first entry and after its last it stays
  CHECK(straight.at(0.65) == doctest::Approx(0.8));
  CHECK(straight.at(7.0) == -0.3);
  CHECK(straight.greatest() == 1.4);
  CHECK(straight.next_kink(0.8) == 1.7);
}

TEST_CASE("the mean over a step is the integral, over any kinks and however short the step") {
  Course ramp, wave;
  ramp.ramp = 0.7;
  wave.frequency = 3.0;
  wave.phase = 1.0;
  wave.amplitude = 2.0;
  wave.mean = 0.5;
  for (const Course& course :
       {ramp, wave, table(Motion::Interpolation::linear), table(Motion::Interpolation::smooth)}) {
    const LoadCourse own(with(course, 0.3));
    for (const std::pair<double, double>& step :
         {std::pair{0.3, 3.0}, {0.31, 0.32}, {0.4, 0.9}, {0.9, 1.0}, {1.6, 2.5}, {2.2, 2.3}, {0.0, 0.6}}) {
      const double from = step.first, until = step.second;
      CAPTURE(from);
      // Simpson's rule for the sine: (0.01 * 19 / s)^4 / 2880 of its amplitude.
      CHECK(own.mean(from, until) * (until - from) == doctest::Approx(integral(own, from, until)).epsilon(1e-6));
    }
    // Additive to rounding, whatever the parts.
    double sum = 0.0;
    constexpr int parts = 977;
    for (int i = 0; i < parts; ++i) {
      const double a = 0.3 + 2.7 * i / parts, b = 0.3 + 2.7 * (i + 1) / parts;
      sum += (b - a) * own.mean(a, b);
    }
    CHECK(sum == doctest::Approx(2.7 * own.mean(0.3, 3.0)).epsilon(1e-13));
    CHECK(own.mean(1.0, 1.0 + 1e-9) == doctest::Approx(own.at(1.0 + 5e-10)).epsilon(1e-9));
  }
}

TEST_CASE("invalid loads are refused") {
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  Course two = table(Motion::Interpolation::linear), falls = two, short_table = two, odd = two, slow;
  two.ramp = 1.0;
  falls.times[2] = 0.7;
  short_table.factors.pop_back();
  odd.interpolation = static_cast<Motion::Interpolation>(9);
  slow.frequency = -1.0;
  CHECK(has(refusal(with(odd)), "unknown interpolation 9"));
  CHECK(has(refusal(with(two)), "more than one of table, sinusoid and ramp"));
  CHECK(has(refusal(with(falls)), "must increase"));
  CHECK(has(refusal(with(short_table)), "4 times and 3 factors"));
  CHECK(has(refusal(with(slow)), "above 0 Hz"));
  Load load;
  load.pressure = 1.0;
  CHECK(has(refusal(load), "has none"));
  load.faces = {{0, 1, 1}};
  CHECK(has(refusal(load), "three different nodes"));
  load.faces = {{0, 1, 3}};
  CHECK(has(refusal(load), "there are only 3 nodes"));
  load.faces = {{0, 1, 2}};
  load.areas = {{0, 0, 1}, {0, 0, 1}};
  CHECK(has(refusal(load), "1 faces has 2 areas"));
  load.areas.clear();
  load.pressure = std::nan("");
  CHECK(has(refusal(load), "must be finite"));
  load.pressure = 2.0;
  CHECK(refusal(load).empty());
}
