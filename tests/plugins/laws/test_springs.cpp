// Spring functions against their formulas, differences and an independent quadrature.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "shipped.hpp"

using namespace springnet::test;

namespace {

struct Case {
  const char* id;
  std::vector<std::vector<double>> parameters;
};
const std::vector<Case> cases{{"linear", {{3.0}, {250.0}, {0.0}}},
                              {"nonlinear", {{3.0, 0.0, 0.0}, {3.0, 2.0, 5.0}, {3.0, -1.0, 0.2}, {0.0, 4.0, 0.0}}},
                              {"exponential", {{3.0, 0.01}, {3.0, 1.0}, {3.0, 10.0}, {250.0, 4.0}}},
                              {"rupturing", {{3.0, 1.5, 0.0}, {3.0, 1.5, 1.0}}}};
const std::vector<double> lengths{0.3, 0.7, 0.99, 1.0, 1.2, 1.7, 2.4};
constexpr double rest_length = 1.2;  // m

template <class Check>
void for_every_sample(const Check& check) {
  for (const Case& each : cases) {
    for (const auto& parameters : each.parameters) {
      for (const double q : lengths) {
        CAPTURE(std::string(each.id));
        CAPTURE(parameters.size());
        CAPTURE(q);
        check(spring(each.id), Sample{q, 0.0, rest_length, parameters});
      }
    }
  }
}

// Integral of f over [a, b] by Gauss-Legendre quadrature with five points on each of 64 parts: for the smooth forces
// here the error is far below rounding.
template <class Function>
double integral(const Function& f, double a, double b) {
  const double r = 2.0 * std::sqrt(10.0 / 7.0);
  const std::array<double, 3> x{0.0, std::sqrt(5.0 - r) / 3.0, std::sqrt(5.0 + r) / 3.0};
  const std::array<double, 3> w{128.0 / 225.0, (322.0 + 13.0 * std::sqrt(70.0)) / 900.0,
                                (322.0 - 13.0 * std::sqrt(70.0)) / 900.0};
  constexpr int parts = 64;
  const double half = (b - a) / (2.0 * parts);
  double sum = 0.0;
  for (int i = 0; i < parts; ++i) {
    const double middle = a + (2.0 * i + 1.0) * half;
    sum += w[0] * f(middle);
    for (std::size_t k = 1; k < 3; ++k) sum += w[k] * (f(middle - x[k] * half) + f(middle + x[k] * half));
  }
  return sum * half;
}

}  // namespace

TEST_CASE("tension of the spring functions, by their formulas") {
  CHECK(force(spring("linear"), {1.5, 0.0, 1.0, {3.0}}) == 1.5);
  CHECK(force(spring("linear"), {0.5, 0.0, 1.0, {3.0}}) == -1.5);
  CHECK(force(spring("nonlinear"), {1.5, 0.0, 1.0, {3.0, 4.0, 16.0}}) == 3.0 * 0.5 + 4.0 * 0.125 + 16.0 * 0.03125);
  CHECK(force(spring("nonlinear"), {0.5, 0.0, 1.0, {3.0, 4.0, 16.0}}) == -2.5);
  CHECK(force(spring("rupturing"), {1.5, 0.0, 1.0, {3.0, 1.0, 0.0}}) == 1.5);
  // T = k l0 / a (exp(a e) - 1) with e = 1/4; rounding of two exponentials.
  CHECK(relative(force(spring("exponential"), {2.5, 0.0, 2.0, {3.0, 8.0}}), 3.0 * 2.0 / 8.0 * (std::exp(2.0) - 1.0)) <
        1e-15);
}

TEST_CASE("no tension and no energy at the rest length") {
  for (const Case& each : cases) {
    for (const auto& parameters : each.parameters) {
      CAPTURE(std::string(each.id));
      const LawAnswer at_rest = evaluate(spring(each.id), Sample{rest_length, 0.0, rest_length, parameters});
      CHECK(at_rest.force[0] == 0.0);
      CHECK(at_rest.energy[0] == 0.0);
      // The stiffness is the slope at rest in every law, rounded.
      CHECK(relative(at_rest.by_q[0], parameters[0]) < 1e-15);
    }
  }
}

TEST_CASE("tension is the derivative of the energy") {
  for_every_sample([](const springnet_component& law, const Sample& at) {
    const auto f = [&](double q) { return energy(law, {q, at.rate, at.reference, at.parameters}); };
    const double h = 1e-2;
    // Step 1e-2: the difference rounds by 2e-16 E / h; E grows within its reach of 4 h.
    const double scale = std::max({1.0, f(at.q + 4 * h), f(at.q - 4 * h)});
    CHECK(std::abs(derivative(f, at.q, h) - force(law, at)) < 1e-12 * scale / h);
  });
}

TEST_CASE("derivatives of the tension with respect to length and parameters") {
  for_every_sample([](const springnet_component& law, const Sample& at) {
    const LawAnswer answer = evaluate(law, at);
    const double h = 1e-3;
    const auto of_length = [&](double q) { return force(law, {q, at.rate, at.reference, at.parameters}); };
    // Rounding 2e-16 T / h; what is cut off is of order (a h / l0)^8.
    const double scale = std::max({1.0, std::abs(of_length(at.q + 4 * h)), std::abs(of_length(at.q - 4 * h))});
    CHECK(std::abs(derivative(of_length, at.q, h) - answer.by_q[0]) < 1e-12 * scale / h);
    CHECK(answer.by_rate[0] == 0.0);
    for (std::size_t j = 0; j < at.parameters.size(); ++j) {
      CAPTURE(j);
      const auto of_parameter = [&](double p) {
        Sample moved = at;
        moved.parameters[j] = p;
        return force(law, moved);
      };
      CHECK(std::abs(derivative(of_parameter, at.parameters[j], h) - answer.by_parameters[j][0]) < 1e-12 * scale / h);
    }
  });
}

TEST_CASE("energy is the work of the tension: nonlinear and exponential against a quadrature") {
  for (const char* id : {"nonlinear", "exponential"}) {
    for (const Case& each : cases) {
      if (std::string(each.id) != id) continue;
      for (const auto& parameters : each.parameters) {
        for (const double q : lengths) {
          if (q == rest_length) continue;
          CAPTURE(std::string(id));
          CAPTURE(q);
          const Sample at{q, 0.0, rest_length, parameters};
          const auto tension = [&](double l) { return force(spring(id), {l, 0.0, rest_length, parameters}); };
          // 320 rounded terms; relative to the work itself, so that small strains count as well.
          CHECK(relative(energy(spring(id), at), integral(tension, rest_length, q), 0.0) < 1e-13);
        }
      }
    }
  }
}

TEST_CASE("exponential keeps its digits at small strain") {
  // Series to third order; the next term is (a e)^3 / 24 < 1e-19 of it at a e = 1e-6.
  for (const double strain : {1e-6, -1e-6, 1e-9, 1e-12}) {
    CAPTURE(strain);
    const double a = 1.0, k = 3.0, x = strain;  // l0 = 1: l - l0 = e, written so that l - l0 is exact
    const double l = 1.0 + x, e = l - 1.0;
    const Sample at{l, 0.0, 1.0, {k, a}};
    CHECK(relative(force(spring("exponential"), at), k * e * (1.0 + e / 2.0 + e * e / 6.0), 0.0) < 1e-15);
    CHECK(relative(energy(spring("exponential"), at), k * e * e * (0.5 + e / 6.0 + e * e / 24.0), 0.0) < 1e-15);
    CHECK(relative(evaluate(spring("exponential"), at).by_q[0], k * (1.0 + e + e * e / 2.0), 0.0) < 1e-15);
  }
}

TEST_CASE("exponential energy is continuous where its series ends") {
  // The series serves |a e| < 1/2; both sides of the seam differ by rounding of exp(x) - 1 - x = 0.149 and by the
  // distance of the two arguments, 2 ulp.
  const double l0 = 1.0, a = 1.0, k = 1.0;
  for (const double seam : {1.5, 0.5}) {
    const double below = energy(spring("exponential"), {std::nextafter(seam, 1.0), 0.0, l0, {k, a}});
    const double above = energy(spring("exponential"), {seam, 0.0, l0, {k, a}});
    CHECK(relative(below, above, 0.0) < 1e-14);
  }
}

TEST_CASE("exponential tends to the linear law for a small exponent, and pushes with a bounded force") {
  // The difference is of order a e / 2 = 2.5e-10.
  CHECK(relative(force(spring("exponential"), {1.5, 0.0, 1.0, {3.0, 1e-9}}), 1.5) < 1e-9);
  CHECK(force(spring("exponential"), {0.0, 0.0, 1.0, {3.0, 50.0}}) > -3.0 / 50.0 - 1e-15);  // > -k l0 / a, rounded
}

TEST_CASE("rupturing: the margin is 1 at rest, falls with the tension and ends at the strength") {
  const auto of = [](double l, double compression) {
    return margin(spring("rupturing"), {l, 0.0, 1.0, {4.0, 2.0, compression}});
  };
  CHECK(of(1.0, 0.0) == 1.0);
  CHECK(of(1.25, 0.0) == 0.5);
  CHECK(of(1.5, 0.0) == 0.0);
  CHECK(of(1.75, 0.0) == -0.5);
  CHECK(of(0.25, 0.0) == 2.5);   // compression only relieves it,
  CHECK(of(0.25, 1.0) == -0.5);  // unless it breaks there too
  CHECK(of(0.5, 1.0) == 0.0);
  CHECK(of(1.5, 1.0) == 0.0);
}

TEST_CASE("spring functions return nan for nan, which the engine detects") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Case& each : cases) {
    CAPTURE(std::string(each.id));
    const auto& parameters = each.parameters[1];
    CHECK(std::isnan(force(spring(each.id), {nan, 0.0, 1.0, parameters})));
    CHECK(std::isnan(energy(spring(each.id), {nan, 0.0, 1.0, parameters})));
    CHECK(std::isnan(evaluate(spring(each.id), Sample{1.1, 0.0, nan, parameters}).force[0]));
    std::vector<double> bad = parameters;
    bad[0] = nan;
    CHECK(std::isnan(force(spring(each.id), {1.1, 0.0, 1.0, bad})));
  }
  CHECK(std::isnan(margin(spring("rupturing"), {nan, 0.0, 1.0, {3.0, 1.0, 0.0}})));
  // A rest length of 0 has no strain.
  CHECK_FALSE(std::isfinite(force(spring("exponential"), {1.0, 0.0, 0.0, {3.0, 1.0}})));
}
