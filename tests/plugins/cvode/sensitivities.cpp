// Sensitivities of the plugin alone, in a small host.
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "small_host.hpp"

namespace {

using Vector = SmallHost::Vector;
using Matrix = SmallHost::Matrix;

// a = -9 p
void make_oscillate(SmallHost& host) {
  host.acceleration = [](double, const Vector& p, const Vector&) -> Vector { return -9.0 * p; };
  host.derivatives = [](double, const Vector&, const Vector&) {
    return std::pair<Matrix, Matrix>(-9.0 * Matrix::Identity(3, 3), Matrix::Zero(3, 3));
  };
}

}  // namespace

// By the start: x = cos(3 t), or sin(3 t) / 3.
TEST_CASE("sensitivities by the start are those of the oscillator, through restarts, until they are ended") {
  const Vector one = Vector::Unit(3, 0), none_at_all = Vector::Zero(3);
  const std::uint8_t fixed[] = {0};
  for (const Method method : {bdf, adams})
    for (const Solver solver : {automatic, direct, krylov, none}) {
      if (method == adams && solver == direct) continue;
      CAPTURE(method);
      CAPTURE(solver);
      SmallHost host(1);
      make_oscillate(host);
      host.network().fixed = host.network().held = fixed;
      host.discontinuities = {0.7};
      host.start(one, none_at_all);
      REQUIRE(host.create(options(method, solver, 1e-10)) == "");
      CHECK(host.sensitivity(0).size() == 0);
      REQUIRE(host.begin_sensitivities({{one, none_at_all}, {none_at_all, one}}) == "");
      CHECK(host.sensitivity(1)[3] == 1.0);
      for (const double time : {0.4, 1.2}) {
        REQUIRE(host.advance(time) == "");
        const Vector by_position = host.sensitivity(0), by_velocity = host.sensitivity(1);
        // 1e-10 in each of some hundred steps
        CHECK(std::abs(by_position[0] - std::cos(3.0 * time)) < 1e-7);
        CHECK(std::abs(by_position[3] + 3.0 * std::sin(3.0 * time)) < 1e-7);
        CHECK(std::abs(by_velocity[0] - std::sin(3.0 * time) / 3.0) < 1e-7);
        CHECK(std::abs(by_velocity[3] - std::cos(3.0 * time)) < 1e-7);
        CHECK(by_velocity[1] == 0.0);
      }
      CHECK(host.sensitivity(2).size() == 0);
      REQUIRE(host.begin_sensitivities({}) == "");
      REQUIRE(host.advance(1.5) == "");
      CHECK(host.sensitivity(0).size() == 0);
    }
}

TEST_CASE("the error of a sensitivity is held below the tolerance over its scale") {
  const Vector one = Vector::Unit(3, 0), nothing = Vector::Zero(3);
  const std::uint8_t fixed[] = {0};
  std::uint64_t steps[2];
  for (const int large : {0, 1}) {
    SmallHost host(1);
    make_oscillate(host);
    host.network().fixed = host.network().held = fixed;
    host.start(nothing, nothing);  // at rest: the sensitivity alone needs steps
    REQUIRE(host.create(options(bdf, direct, 1e-6)) == "");
    REQUIRE(host.begin_sensitivities({{1e-3 * one, nothing}}, large ? 1e3 : 1.0) == "");
    REQUIRE(host.advance(1.2) == "");
    CHECK(std::abs(host.sensitivity(0)[0] - 1e-3 * std::cos(3.6)) < 100.0 * (large ? 1e-9 : 1e-6));
    steps[large] = host.report.steps;
  }
  CHECK(steps[1] > 2 * steps[0]);
}

TEST_CASE("sensitivities are refused where the motion has no derivatives") {
  const Vector one = Vector::Unit(3, 0), nothing = Vector::Zero(3);
  const std::uint8_t fixed[] = {0}, touching[] = {1};
  SmallHost host(1);
  make_oscillate(host);
  host.network().fixed = host.network().held = fixed;
  host.events.push_back(
      {[](double, const Vector& p, const Vector&) { return p[0]; }, -1, [](SmallHost&, Vector&, Vector&) {}});
  host.start(one, nothing);
  REQUIRE(host.create(options(bdf, direct)) == "");
  CHECK(host.begin_sensitivities({{one, nothing}}, 0.0).find("scale") != std::string::npos);
  REQUIRE(host.begin_sensitivities({{one, nothing}}) == "");
  CHECK(host.advance(1.0).find("which there is at 0.52359") != std::string::npos);  // pi / 6
  host.network().touching = touching;
  host.network().surface_count = 1;
  host.change();
  CHECK(host.advance(1.0).find("with contact, which there is at") != std::string::npos);
  host.network().surface_count = 0;
  host.network().rigid_count = 1;
  CHECK(host.begin_sensitivities({{one, nothing}}).find("rigid connections") != std::string::npos);
  host.network().rigid_count = 0;
  host.network().internal_count = 1;
  CHECK(host.begin_sensitivities({{one, nothing}}).find("internal states") != std::string::npos);
}
