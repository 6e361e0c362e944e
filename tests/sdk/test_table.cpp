// Curves through points: MonotoneCubic.
#include <springnet/sdk/table.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

using springnet::sdk::Beyond;
using springnet::sdk::Dual;
using springnet::sdk::MonotoneCubic;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity(), not_a_number = std::numeric_limits<double>::quiet_NaN();

struct Points {
  std::vector<double> x, y;
  [[nodiscard]] MonotoneCubic curve(Beyond beyond = Beyond::linear) const { return {x, y, beyond}; }
};

Points sampled(const std::function<double(double)>& f, double from, double until, int pieces) {
  Points points;
  for (int k = 0; k <= pieces; ++k) {
    points.x.push_back(from + (until - from) * k / pieces);
    points.y.push_back(f(points.x.back()));
  }
  return points;
}

// Irregular, with extrema, level pieces and steps.
Points random_points(std::mt19937& random, bool monotone) {
  std::uniform_real_distribution<double> step(0.01, 1.0), value(-1.0, 1.0);
  Points points;
  double x = -2.0, y = -3.0;
  for (int k = 0; k < 17; ++k) {
    points.x.push_back(x += step(random));
    const double change = k % 5 == 3 ? 0.0 : value(random);
    points.y.push_back(monotone ? y += std::abs(change * change * change) : change);
  }
  return points;
}

template <class Function>
double largest_difference(const Function& a, const Function& b, double from, double until) {
  double largest = 0.0;
  for (int k = 0; k <= 4001; ++k) {
    const double x = from + (until - from) * k / 4001;
    largest = std::max(largest, std::abs(a(x) - b(x)));
  }
  return largest;
}

double slope_of(const MonotoneCubic& curve, double x) { return curve(Dual<1>::variable(x, 0)).derivatives[0]; }

// Gauss's rule of three points is exact for cubics.
double quadrature(const MonotoneCubic& curve, double from, double until) {
  const double middle = (from + until) / 2, half = (until - from) / 2, node = std::sqrt(0.6);
  return half / 9 * (5 * curve(middle - node * half) + 8 * curve(middle) + 5 * curve(middle + node * half));
}

}  // namespace

TEST_CASE("two points give a straight line, and beyond them what was chosen") {
  const Points points{{1.0, 3.0}, {-2.0, 4.0}};
  const MonotoneCubic line = points.curve(), level = points.curve(Beyond::constant);
  for (const double x : {1.0, 1.7, 3.0}) {
    CHECK(line(x) == doctest::Approx(3 * x - 5).epsilon(1e-15));
    CHECK(level(x) == line(x));
  }
  CHECK(line(-9.0) == doctest::Approx(-32.0));
  CHECK(line(9.0) == doctest::Approx(22.0));
  CHECK(level(-9.0) == -2.0);
  CHECK(level(9.0) == 4.0);
  CHECK(slope_of(level, 9.0) == 0.0);
  CHECK(slope_of(line, 9.0) == doctest::Approx(3.0));
  CHECK(line.integral(1.0) == 0.0);
  CHECK(line.integral(3.0) == doctest::Approx(2.0));
  CHECK(line.integral(5.0) == doctest::Approx(1.5 * 24 - 5 * 4));
  CHECK(line.integral(-1.0) == doctest::Approx(-5 * -2.0));
  CHECK(level.integral(-1.0) == doctest::Approx(4.0));
  CHECK(level.integral(5.0) == doctest::Approx(2.0 + 8.0));
}

TEST_CASE("points on a line stay on it, whatever their spacing") {
  std::mt19937 random(3);
  for (int n = 0; n < 20; ++n) {
    Points points = random_points(random, true);
    for (std::size_t k = 0; k < points.x.size(); ++k) points.y[k] = 0.25 - 1.75 * points.x[k];
    const MonotoneCubic curve = points.curve();
    const auto line = [](double x) { return 0.25 - 1.75 * x; };
    CHECK(largest_difference<std::function<double(double)>>(curve, line, -5.0, 20.0) < 1e-12);
  }
}

TEST_CASE("the points themselves are met exactly, and the curve lies between neighbours") {
  std::mt19937 random(5);
  for (int n = 0; n < 50; ++n) {
    const Points points = random_points(random, n % 2 == 0);
    const MonotoneCubic curve = points.curve();
    for (std::size_t k = 0; k < points.x.size(); ++k) CHECK(curve(points.x[k]) == points.y[k]);
    for (std::size_t k = 0; k + 1 < points.x.size(); ++k) {
      const auto [low, high] = std::minmax(points.y[k], points.y[k + 1]);
      const double sign = points.y[k] < points.y[k + 1] ? 1.0 : -1.0, rounding = 1e-14;
      double last = points.y[k];
      for (int i = 1; i < 100; ++i) {
        const double y = curve(points.x[k] + (points.x[k + 1] - points.x[k]) * i / 100);
        CHECK((y >= low - rounding && y <= high + rounding));
        CHECK(sign * (y - last) >= -rounding);
        last = y;
      }
    }
  }
}

TEST_CASE("value and slope are continuous; derivatives agree with differences, the integral with quadrature") {
  std::mt19937 random(7);
  for (int n = 0; n < 20; ++n) {
    const Points points = random_points(random, n % 2 == 0);
    const MonotoneCubic curve = points.curve();
    for (const double x : points.x) {
      const double before = std::nextafter(x, -inf);
      CHECK(curve(before) == doctest::Approx(curve(x)).epsilon(1e-12));
      CHECK(slope_of(curve, before) == doctest::Approx(slope_of(curve, x)).epsilon(1e-9).scale(1.0));
      CHECK(curve.integral(before) == doctest::Approx(curve.integral(x)).epsilon(1e-12));
    }
    double sum = 0.0;
    std::vector<double> ends = points.x;
    ends.insert(ends.begin(), points.x.front() - 1.0);
    ends.push_back(points.x.back() + 1.0);
    CHECK(curve.integral(points.x.front()) == 0.0);
    for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
      const double from = ends[k], until = ends[k + 1], h = (until - from) / 8, inside = from + 0.37 * (until - from);
      // Exact for cubics.
      const double difference =
          (8 * (curve(inside + h) - curve(inside - h)) - curve(inside + 2 * h) + curve(inside - 2 * h)) / (12 * h);
      CHECK(slope_of(curve, inside) == doctest::Approx(difference).epsilon(1e-10).scale(1.0));
      CHECK(curve.integral(Dual<1>::variable(inside, 0)).derivatives[0] == curve(inside));
      CHECK(curve.integral(until) - curve.integral(from) ==
            doctest::Approx(quadrature(curve, from, until)).epsilon(1e-13).scale(1.0));
      if (k > 0) sum += quadrature(curve, from, until);
      if (k + 2 < ends.size()) CHECK(curve.integral(until) == doctest::Approx(sum).epsilon(1e-12).scale(1.0));
    }
  }
}

// The slopes of parabolas are off by O(h^2), which moves the curve by O(h^3): y''' h^3 s (1 - s) (1 - 2 s) / 6, of no
// effect on the integral over a piece, which therefore converges with the fourth order.
TEST_CASE("the error falls with the third power of the spacing, that of the integral with the fourth") {
  const auto f = [](double x) { return std::exp(3.0 * x); };
  const auto F = [](double x) { return (std::exp(3.0 * x) - std::exp(-3.0)) / 3.0; };
  std::array<double, 2> value{}, integral{};
  for (const int k : {0, 1}) {
    const MonotoneCubic curve = sampled(f, -1.0, 1.0, k == 0 ? 100 : 200).curve();
    const auto i = static_cast<std::size_t>(k);
    using Function = std::function<double(double)>;
    value[i] = largest_difference<Function>(curve, f, -1.0, 1.0);
    integral[i] = largest_difference<Function>([&](double x) { return curve.integral(x); }, F, -1.0, 1.0);
  }
  CHECK(std::log2(value[0] / value[1]) == doctest::Approx(3.0).epsilon(0.05));
  CHECK(std::log2(integral[0] / integral[1]) == doctest::Approx(4.0).epsilon(0.05));
}

TEST_CASE("an extremum between points is cut off: second order there, third elsewhere") {
  const auto f = [](double x) { return std::cos(x); };
  std::array<double, 2> near{}, far{};
  // The extremum lies in the middle of a piece.
  for (const int k : {0, 1}) {
    const MonotoneCubic curve = sampled(f, -1.0, 1.0, k == 0 ? 101 : 303).curve();
    const auto i = static_cast<std::size_t>(k);
    near[i] = largest_difference<std::function<double(double)>>(curve, f, -0.1, 0.1);
    far[i] = largest_difference<std::function<double(double)>>(curve, f, 0.2, 0.9);
  }
  CHECK(std::log(near[0] / near[1]) / std::log(3.0) == doctest::Approx(2.0).epsilon(0.05));
  CHECK(near[1] > 10 * far[1]);
  CHECK(std::log(far[0] / far[1]) / std::log(3.0) == doctest::Approx(3.0).epsilon(0.05));
}

TEST_CASE("any number of points, any argument") {
  for (std::size_t count = 2; count < 70; ++count) {
    Points points;
    for (std::size_t k = 0; k < count; ++k) {
      points.x.push_back(static_cast<double>(k));
      points.y.push_back(static_cast<double>(k * k));
    }
    const MonotoneCubic curve = points.curve();
    for (std::size_t k = 0; k < count; ++k) {
      CHECK(curve(points.x[k]) == points.y[k]);
      if (k > 0) CHECK((curve(points.x[k] - 0.5) > points.y[k - 1] && curve(points.x[k] - 0.5) < points.y[k]));
    }
    CHECK(std::isnan(curve(not_a_number)));
    CHECK(std::isnan(curve.integral(not_a_number)));
    CHECK_FALSE(std::isfinite(curve(inf)));
    CHECK(std::isfinite(curve(-1e100)));
  }
}

TEST_CASE("points that make no curve are refused") {
  const auto refusal = [](const Points& points) -> std::string {
    try {
      static_cast<void>(points.curve());
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  const auto contains = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  CHECK(contains(refusal({}), "two points"));
  CHECK(contains(refusal({{1.0}, {1.0}}), "two points"));
  CHECK(contains(refusal({{1.0, 2.0}, {1.0}}), "as many"));
  CHECK(contains(refusal({{1.0, 2.0, 2.0}, {1.0, 2.0, 3.0}}), "not after point 2"));
  CHECK(contains(refusal({{1.0, not_a_number}, {1.0, 2.0}}), "not after point 1"));
  CHECK(contains(refusal({{1.0, 2.0}, {1.0, not_a_number}}), "not finite"));
  CHECK(contains(refusal({{1.0, 2.0}, {inf, 2.0}}), "not finite"));
  CHECK(contains(refusal({{1.0, inf}, {1.0, 2.0}}), "not finite"));
  CHECK(contains(refusal({{0.0, 5e-324}, {0.0, 1.0}}), "not finite"));
  CHECK(contains(refusal({{-1e308, 1e308}, {0.0, 1.0}}), "not finite"));
  CHECK(contains(refusal({{0.0, 1.0, 2.0}, {0.0, 1e308, -1e308}}), "not finite"));
  // Steep, but finite.
  CHECK(refusal({{0.0, 1e-9, 1.0}, {0.0, 1.0, 1.0}}).empty());
}
