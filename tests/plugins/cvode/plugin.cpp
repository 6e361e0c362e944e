// The plugin alone, in a small host.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <string>

#include <unistd.h>

#include <doctest/doctest.h>

#include "small_host.hpp"

namespace {

using Vector = SmallHost::Vector;
using Matrix = SmallHost::Matrix;
using springnet::ParameterValues;

constexpr double infinity = std::numeric_limits<double>::infinity();

// a = P p + V v with constant matrices.
void make_linear(SmallHost& host, const Matrix& by_position, const Matrix& by_velocity) {
  host.acceleration = [=](double, const Vector& p, const Vector& v) -> Vector {
    return by_position * p + by_velocity * v;
  };
  host.derivatives = [=](double, const Vector&, const Vector&) { return std::pair(by_position, by_velocity); };
}
void make_linear(SmallHost& host, double stiffness, double damping) {
  make_linear(host, -stiffness * Matrix::Identity(3, 3), -damping * Matrix::Identity(3, 3));
}

// Free fall: a = -g z.
void make_falling(SmallHost& host, double gravity) {
  host.acceleration = [=](double, const Vector&, const Vector&) -> Vector { return Eigen::Vector3d(0, 0, -gravity); };
  host.derivatives = [](double, const Vector&, const Vector&) {
    return std::pair<Matrix, Matrix>(Matrix::Zero(3, 3), Matrix::Zero(3, 3));
  };
}

// While it lives, what the process prints goes to a file, and must be nothing.
class Silence {
 public:
  Silence() : file_(mkstemp(name_)) {
    REQUIRE(file_ >= 0);
    flush();
    for (const int stream : {1, 2}) dup2(file_, stream);
  }
  ~Silence() {
    flush();
    for (const int stream : {1, 2}) dup2(kept_[stream - 1], stream);
    std::ifstream file(name_);
    const std::string printed{std::istreambuf_iterator<char>(file), {}};
    CHECK(printed == "");
    for (const int each : {kept_[0], kept_[1], file_}) close(each);
    unlink(name_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  static void flush() {
    std::cout.flush();
    std::fflush(nullptr);
  }
  char name_[31] = "/tmp/springnet_cvode_XXXXXX";
  int kept_[2] = {dup(1), dup(2)};
  int file_;
};

TEST_CASE("every method and linear solver follows the damped oscillator, to an error in proportion to the tolerance") {
  // m 1 kg, k 25 N/m, d 0.6 kg/s: p = e^(-0.3 t) (cos w t + 0.3/w sin w t)
  const double damping = 0.6, stiffness = 25.0, rate = damping / 2, w = std::sqrt(stiffness - rate * rate);
  const double t = 3.0;
  const double exact = std::exp(-rate * t) * (std::cos(w * t) + rate / w * std::sin(w * t));
  for (const auto& choice :
       {std::pair{bdf, direct}, {bdf, krylov}, {bdf, none}, {adams, none}, {adams, direct}, {adams, krylov}}) {
    const Method method = choice.first;
    const Solver solver = choice.second;
    double previous = infinity;
    for (const double tolerance : {1e-5, 1e-7, 1e-9}) {
      CAPTURE(method);
      CAPTURE(solver);
      CAPTURE(tolerance);
      SmallHost host(1);
      make_linear(host, stiffness, damping);
      REQUIRE(host.create(options(method, solver, tolerance)) == "");
      host.start(Eigen::Vector3d(1, 0, 0), Vector::Zero(3));
      REQUIRE(host.advance(t) == "");
      const double error = std::abs(host.position()[0] - exact);
      // The tolerance bounds the error of one step; some hundred steps add up.
      CHECK(error < 300 * tolerance);
      CHECK(error < previous / 5);  // 1/100 of the tolerance; a fifth leaves room for luck in a single component
      previous = error;
    }
  }
}

TEST_CASE("a stiff network is solved with a handful of iterations, which a wrong Jacobian would not allow") {
  // Two nodes, a coupling of 1e8 N/m between them and 1 N/m to the origin, a full damping matrix. Explicit methods
  // would need steps of 1e-4 s.
  Matrix pair = Matrix::Zero(6, 6);
  for (int c = 0; c < 3; ++c) {
    pair(2 * c, 2 * c) = pair(2 * c + 1, 2 * c + 1) = 1.0;
    pair(2 * c, 2 * c + 1) = pair(2 * c + 1, 2 * c) = -1.0;
  }
  const Matrix by_position = -1e8 * pair - Matrix::Identity(6, 6);
  const Matrix by_velocity = -1e5 * pair - 0.1 * Matrix::Identity(6, 6);
  Vector p(6);
  p << 1, 1, 0, 0, 0, 0;
  double first = 0.0;
  for (const Solver solver : {direct, krylov}) {
    SmallHost host(2);
    make_linear(host, by_position, by_velocity);
    REQUIRE(host.create(options(bdf, solver, 1e-6)) == "");
    host.start(p, Vector::Zero(6));
    REQUIRE(host.advance(10.0) == "");
    CAPTURE(solver);
    const double steps = host.reported["internal_steps"];
    CHECK(steps < 1000);
    CHECK(host.reported["nonlinear_iterations"] < 2 * steps);
    CHECK(host.reported["convergence_failures"] <= 2);
    CHECK(host.linearisations < steps / 5);  // derivatives are kept while they serve
    // The common motion is that of m 1 kg, k 1 N/m, d 0.1 kg/s.
    const double w = std::sqrt(1 - 0.0025);
    const double exact = std::exp(-0.5) * (std::cos(10 * w) + 0.05 / w * std::sin(10 * w));
    // tolerance of a step x a few hundred steps
    CHECK(host.position()[0] == doctest::Approx(exact).epsilon(3e-4));
    CHECK(host.position()[1] == doctest::Approx(host.position()[0]).epsilon(1e-5));
    if (solver == direct) first = host.position()[0];
    CHECK(host.position()[0] == doctest::Approx(first).epsilon(3e-4));
  }
}

TEST_CASE("the preconditioner of krylov is exact for nodes that are not coupled") {
  // Six nodes, each with full 3x3 matrices of its own, from soft to stiff.
  const Eigen::Index n = 6;
  Matrix by_position = Matrix::Zero(3 * n, 3 * n), by_velocity = by_position;
  for (Eigen::Index node = 0; node < n; ++node) {
    const double stiffness = std::pow(30.0, static_cast<double>(node));
    for (Eigen::Index row = 0; row < 3; ++row) {
      for (Eigen::Index column = 0; column < 3; ++column) {
        const double entry = row == column ? 2.0 : (row < column ? 0.5 : -0.3);
        by_position(node + row * n, node + column * n) = -stiffness * entry;
        by_velocity(node + row * n, node + column * n) = -2.0 * std::sqrt(stiffness) * entry;
      }
    }
  }
  SmallHost host(n);
  make_linear(host, by_position, by_velocity);
  // The point of rest swings, so that the stiff nodes keep moving too.
  host.acceleration = [&](double t, const Vector& p, const Vector& v) -> Vector {
    return by_position * (p - std::sin(20 * t) * Vector::Ones(3 * n)) + by_velocity * v;
  };
  REQUIRE(host.create(options(bdf, krylov, 1e-6)) == "");
  host.start(Vector::Zero(3 * n), Vector::Zero(3 * n));
  REQUIRE(host.advance(5.0) == "");
  // One iteration for each of Newton's, but for those where the factor gamma lags behind the step. With a mistake in
  // the preconditioner it is about two.
  CHECK(host.reported["krylov_iterations"] < 1.3 * host.reported["nonlinear_iterations"]);
  CHECK(host.reported["convergence_failures"] == 0);
}

TEST_CASE("direct factorises anew only when the step has changed, and keeps the derivatives") {
  SmallHost host(1);
  make_linear(host, 4.0, 0.5);
  REQUIRE(host.create(options(bdf, direct)) == "");
  host.start(Eigen::Vector3d(1, 2, 3), Vector::Zero(3));
  REQUIRE(host.advance(20.0) == "");
  CHECK(host.factorisations == host.reported["linear_setups"]);
  CHECK(host.linearisations == host.reported["linearisations"]);
  CHECK(host.linearisations < host.factorisations);
  CHECK(host.products == host.reported["jacobian_products"]);
  CHECK(host.reported["order"] >= 2);
  CHECK(host.report.steps == host.reported["internal_steps"]);
  CHECK(host.report.sweeps == static_cast<std::uint64_t>(host.evaluations));
  CHECK(host.report.outcome == SPRINGNET_SETTLED);
}

TEST_CASE("automatic choice: adams iterates without a linear system, bdf factorises") {
  SmallHost with_adams(1), with_bdf(1);
  for (SmallHost* host : {&with_adams, &with_bdf}) {
    make_linear(*host, 4.0, 0.5);
    host->start(Eigen::Vector3d(1, 0, 0), Vector::Zero(3));
  }
  REQUIRE(with_adams.create(options(adams, automatic)) == "");
  REQUIRE(with_adams.advance(1.0) == "");
  CHECK(with_adams.linearisations == 0);
  REQUIRE(with_bdf.create(options(bdf, automatic)) == "");
  REQUIRE(with_bdf.advance(1.0) == "");
  CHECK(with_bdf.factorisations > 0);
}

TEST_CASE("steps do not depend on how often the state is requested") {
  SmallHost seldom(1), often(1);
  for (SmallHost* host : {&seldom, &often}) {
    make_linear(*host, 4.0, 0.5);
    host->start(Eigen::Vector3d(1, 0, 0), Vector::Zero(3));
    REQUIRE(host->create(options(bdf, direct)) == "");
  }
  REQUIRE(seldom.advance(2.0) == "");
  for (int i = 1; i <= 200; ++i) REQUIRE(often.advance(i * 0.01) == "");
  CHECK(often.reported["internal_steps"] == seldom.reported["internal_steps"]);
  CHECK(often.reported["restarts"] == 0);
  CHECK(often.position() == seldom.position());  // the same steps, the same interpolation
  CHECK(often.commits.size() == 200);
}

TEST_CASE("steps stop at known discontinuities exactly, and loads are evaluated between them") {
  // A force of 3 N until 0.7312345 s on 1 kg at rest: an impulse of 3 x 0.7312345 N s.
  const double off = 0.7312345;
  for (const Method method : {bdf, adams}) {
    SmallHost host(1);
    bool passed = false;  // an evaluation beyond the discontinuity before the step began there
    host.acceleration = [&](double t, const Vector&, const Vector&) -> Vector {
      passed = passed || (t > off && host.steps_begun.back().first < off);
      return Eigen::Vector3d(host.steps_begun.back().first < off ? 3.0 : 0.0, 0, 0);
    };
    host.derivatives = [](double, const Vector&, const Vector&) {
      return std::pair<Matrix, Matrix>(Matrix::Zero(3, 3), Matrix::Zero(3, 3));
    };
    host.discontinuities = {off};
    REQUIRE(host.create(options(method, automatic)) == "");
    host.start(Vector::Zero(3), Vector::Zero(3));
    for (const double t : {0.5, 1.0, 2.0}) REQUIRE(host.advance(t) == "");
    CHECK(host.commits == std::vector{0.5, off, 1.0, 2.0});
    CHECK(!passed);
    CHECK(host.steps_begun.front() == std::pair(0.0, off));
    CHECK(host.steps_begun.back() == std::pair(1.0, infinity));
    // The velocity is linear in time, which every order integrates exactly: rounding only, of some hundred steps.
    CHECK(host.velocity()[0] == doctest::Approx(3 * off).epsilon(1e-13));
    CHECK(host.reported["restarts"] == 1);
  }
}

TEST_CASE("discontinuities that differ by rounding from each other and from an output do no harm") {
  SmallHost host(1);
  make_linear(host, 4.0, 0.0);
  host.discontinuities = {0.3, std::nextafter(0.3, 1.0), 0.1 + 0.2, 0.7};
  REQUIRE(host.create(options(bdf, automatic)) == "");
  host.start(Eigen::Vector3d(1, 0, 0), Vector::Zero(3));
  REQUIRE(host.advance(0.1 + 0.2) == "");
  REQUIRE(host.advance(0.7) == "");
  CHECK(host.time() == 0.7);
  // 1e-8 a step, some ten steps
  CHECK(std::abs(host.position()[0] - std::cos(1.4)) < 1e-6);
}

TEST_CASE("an event is found in time, carried out and committed") {
  // Falls from 1 m with 2 m/s^2: on the ground at 1 s, held there; the hold ends at 1.5 s by a second event.
  SmallHost host(1);
  bool held = false;
  host.acceleration = [&](double t, const Vector&, const Vector&) -> Vector {
    return held ? Vector::Zero(3) : Vector(Eigen::Vector3d(0, 0, t < 1.25 ? -2.0 : 4.0));
  };
  host.derivatives = [](double, const Vector&, const Vector&) {
    return std::pair<Matrix, Matrix>(Matrix::Zero(3, 3), Matrix::Zero(3, 3));
  };
  const SmallHost::Event release{[](double t, const Vector&, const Vector&) { return t - 1.5; }, +1,
                                 [&](SmallHost& self, Vector&, Vector&) {
                                   held = false;
                                   self.events.clear();
                                 }};
  host.events = {{[](double, const Vector& p, const Vector&) { return p[2]; }, -1,
                  [&](SmallHost& self, Vector& p, Vector& v) {
                    held = true;
                    p[2] = 0;
                    v[2] = 0;
                    self.events = {release, release};
                  }}};
  REQUIRE(host.create(options(bdf, automatic)) == "");
  host.start(Eigen::Vector3d(0, 0, 1), Vector::Zero(3));
  REQUIRE(host.advance(1.2) == "");
  REQUIRE(host.commits.size() == 2);
  // CVODE locates a root to 100 roundings of the time
  CHECK(host.commits[0] == doctest::Approx(1.0).epsilon(1e-7));
  CHECK(held);
  CHECK(host.position()[2] == 0.0);
  REQUIRE(host.advance(2.5) == "");
  CHECK(!held);
  REQUIRE(host.commits.size() == 4);
  CHECK(host.commits[2] == doctest::Approx(1.5).epsilon(1e-13));
  CHECK(host.position()[2] == doctest::Approx(0.5 * 4.0 * 1.0).epsilon(1e-7));
  CHECK(host.reported["restarts"] == 2);
}

TEST_CASE("an event whose value is 0 at the start is found when it comes back") {
  // Thrown up from the ground with 1 m/s at 2 m/s^2: back after 1 s.
  SmallHost host(1);
  make_falling(host, 2.0);
  int landed = 0;
  host.events = {{[](double, const Vector& p, const Vector&) { return p[2]; }, -1,
                  [&](SmallHost&, Vector& p, Vector& v) {
                    ++landed;
                    p[2] = 0;
                    v[2] = 1;
                  }}};
  REQUIRE(host.create(options(bdf, automatic)) == "");
  host.start(Vector::Zero(3), Eigen::Vector3d(0, 0, 1));
  REQUIRE(host.advance(3.5) == "");
  CHECK(landed == 3);
  REQUIRE(host.commits.size() == 4);
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(host.commits[i] == doctest::Approx(static_cast<double>(i + 1)).epsilon(1e-7));
}

TEST_CASE("an event happens in its own direction only") {
  // Thrown up from 1 m below with 2 m/s at 1 m/s^2: through 0 rising at 2 - sqrt(2) s, falling at 2 + sqrt(2) s.
  SmallHost host(1);
  make_falling(host, 1.0);
  int happened = 0;
  const auto height = [](double, const Vector& p, const Vector&) { return p[2]; };
  host.events = {{height, -1, [&](SmallHost&, Vector&, Vector&) { ++happened; }}};
  REQUIRE(host.create(options(bdf, automatic)) == "");
  host.start(Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0, 0, 2));
  REQUIRE(host.advance(3.0) == "");
  CHECK(happened == 0);
  REQUIRE(host.advance(3.5) == "");
  CHECK(happened == 1);
  REQUIRE(host.commits.size() == 3);
  CHECK(host.commits[1] == doctest::Approx(2 + std::sqrt(2.0)).epsilon(1e-7));  // 1e-8 a step, some ten steps
}

TEST_CASE("an event that recurs without end at one time is an error") {
  SmallHost host(1);
  make_falling(host, 2.0);
  // A node that is released at 0.5 s, and again as soon as the motion goes on.
  host.events = {{[](double t, const Vector&, const Vector&) { return t < 0.5 ? -1.0 : 1.0; }, +1,
                  [](SmallHost&, Vector&, Vector&) {}}};
  REQUIRE(host.create(options(bdf, automatic)) == "");
  host.start(Vector::Zero(3), Vector::Zero(3));
  const std::string message = host.advance(1.0);
  CAPTURE(message);
  CHECK(message.find("t = 0.5 s") != std::string::npos);
}

TEST_CASE("a change of the network restarts the method") {
  SmallHost host(1);
  make_linear(host, 0.0, 0.0);
  REQUIRE(host.create(options(adams, automatic)) == "");
  host.start(Vector::Zero(3), Eigen::Vector3d(1, 0, 0));
  REQUIRE(host.advance(1.0) == "");
  // Without a restart the interpolation polynomial of the old motion would still be in use.
  host.start(Eigen::Vector3d(5, 0, 0), Eigen::Vector3d(-2, 0, 0), 1.0);
  host.change();
  REQUIRE(host.advance(2.0) == "");
  CHECK(host.position()[0] == doctest::Approx(3.0).epsilon(1e-13));  // exact but for rounding
  CHECK(host.reported["restarts"] == 1);
}

TEST_CASE("messages of failures name the cause and the remedy; nothing is printed") {
  const Silence silence;
  const auto contains = [](const std::string& text, const char* part) {
    CAPTURE(text);
    CHECK(text.find(part) != std::string::npos);
  };

  SUBCASE("too few steps") {
    SmallHost host(1);
    make_linear(host, 1e4, 0.0);
    auto few = options(bdf, direct);
    few["max_steps"] = 20;
    REQUIRE(host.create(few) == "");
    host.start(Eigen::Vector3d(1, 0, 0), Vector::Zero(3));
    const std::string message = host.advance(10.0);
    contains(message, "20 internal steps");
    contains(message, "max_steps");
    CHECK(host.time() == 0.0);
    // The network can go on after a failure.
    CHECK(host.advance(1e-4) == "");
  }
  SUBCASE("forces that are not finite from a time on") {
    SmallHost host(1);
    make_linear(host, 1.0, 0.0);
    host.acceleration = [](double t, const Vector& p, const Vector&) -> Vector {
      return t < 0.5 ? Vector(-p) : Vector(Vector::Constant(3, std::nan("")));
    };
    REQUIRE(host.create(options(bdf, direct)) == "");
    host.start(Eigen::Vector3d(1, 0, 0), Vector::Zero(3));
    const std::string message = host.advance(1.0);
    contains(message, "law 'made up' answered nan for spring 7");
    contains(message, "0.5");  // after steps so short that CVODE warns of them
  }
  SUBCASE("forces that are not finite at the start") {
    SmallHost host(1);
    make_linear(host, std::nan(""), 0.0);
    REQUIRE(host.create(options(bdf, direct)) == "");
    host.start(Eigen::Vector3d(1, 0, 0), Vector::Zero(3));
    contains(host.advance(1.0), "not finite in the state that the step starts from");
  }
  SUBCASE("a tolerance below rounding") {
    SmallHost host(1);
    make_linear(host, 1.0, 0.0);
    auto fine = options(bdf, direct);
    fine["position_tolerance"] = 1e-12;
    REQUIRE(host.create(fine) == "");
    host.start(Eigen::Vector3d(1e6, 0, 0), Vector::Zero(3));
    contains(host.advance(1.0), "finer than the rounding");
  }
  SUBCASE("an order that bdf does not have") {
    SmallHost host(1);
    make_linear(host, 1.0, 0.0);
    auto high = options(bdf, direct);
    high["max_order"] = 7;
    const std::string message = host.create(high);
    contains(message, "max_order");
    contains(message, " 5");
  }
}

TEST_CASE("a force that is not finite for a trial step shortens the step") {
  // The law is not defined beyond p = 1.2, which the motion never reaches.
  SmallHost host(1);
  host.acceleration = [](double, const Vector& p, const Vector&) -> Vector {
    return p.cwiseAbs().maxCoeff() > 1.2 ? Vector(Vector::Constant(3, std::nan(""))) : Vector(-100 * p);
  };
  host.derivatives = [](double, const Vector&, const Vector&) {
    return std::pair<Matrix, Matrix>(-100 * Matrix::Identity(3, 3), Matrix::Zero(3, 3));
  };
  REQUIRE(host.create(options(bdf, direct, 1e-3)) == "");
  host.start(Eigen::Vector3d(1, 0, 0), Vector::Zero(3));
  CHECK(host.advance(3.0) == "");
}

TEST_CASE("limits of step and order are kept") {
  SmallHost host(1);
  make_linear(host, 1.0, 0.0);
  auto limited = options(bdf, direct);
  limited["max_step"] = 1e-3;
  limited["max_order"] = 1;
  REQUIRE(host.create(limited) == "");
  host.start(Eigen::Vector3d(1, 0, 0), Vector::Zero(3));
  REQUIRE(host.advance(0.1) == "");
  CHECK(host.reported["internal_steps"] >= 100);
  CHECK(host.reported["order"] == 1);
  CHECK(host.reported["last_step_s"] <= 1e-3);
}

}  // namespace
