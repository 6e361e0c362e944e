// Motions over time, against closed forms, differences, and the properties of interpolation without overshoot.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include "network/trajectory.hpp"

#include "not_finite.hpp"

using springnet::Motion;
using springnet::Trajectory;
using springnet::Vector3;
using springnet::testing::inf;

namespace {

Motion table(std::vector<double> times, std::vector<Vector3> displacements,
             Motion::Interpolation interpolation = Motion::Interpolation::smooth) {
  Motion motion;
  motion.times = std::move(times);
  motion.displacements = std::move(displacements);
  motion.interpolation = interpolation;
  return motion;
}

// Rising, falling and level pieces of lengths from 0.1 s to 10 s.
Motion random_table(std::mt19937& random, Motion::Interpolation interpolation) {
  std::uniform_real_distribution<double> exponent(-1, 1), height(-1, 1);
  std::uniform_int_distribution<int> level(0, 3);
  std::vector<double> times{height(random)};
  std::vector<Vector3> displacements{Vector3(height(random), height(random), height(random))};
  for (int k = 0; k < 11; ++k) {
    times.push_back(times.back() + std::pow(10, exponent(random)));
    Vector3 next = displacements.back();
    for (double& coordinate : next) {
      if (level(random) > 0) coordinate += height(random);
    }
    displacements.push_back(next);
  }
  return table(times, displacements, interpolation);
}

// Velocity and acceleration are the derivatives of displacement and velocity.
void check_derivatives(const Trajectory& trajectory, double time) {
  const double h = 1e-5;
  const auto before = trajectory.at(time - h), here = trajectory.at(time), after = trajectory.at(time + h);
  // Central differences are off by h^2 / 6 times the third derivative. In pieces of 0.1 s and 1 m, or for a sinusoid of
  // 2 m and 1.5 Hz, those of displacement and velocity are below 5e4; rounding is far less.
  const double tolerance = 1e-6;
  CHECK(((after.displacement - before.displacement) / (2 * h) - here.velocity).norm() < tolerance);
  CHECK(((after.velocity - before.velocity) / (2 * h) - here.acceleration).norm() < tolerance);
}

}  // namespace

TEST_CASE("a trajectory without a motion rests where it starts") {
  const Trajectory rests;
  CHECK_FALSE(rests.moves());
  for (const double time : {-inf, -1.0, 0.0, 1e9}) {
    CHECK(rests.at(time).displacement == Vector3::Zero());
    CHECK(rests.at(time).velocity == Vector3::Zero());
    CHECK(rests.at(time).acceleration == Vector3::Zero());
    CHECK(rests.next_change(time) == inf);
  }
  CHECK_FALSE(Trajectory(table({0, 1}, {Vector3::Zero(), Vector3::Zero()})).moves());
  CHECK(Trajectory(table({0, 1}, {Vector3::Ones(), Vector3::Ones()})).moves());  // not where it starts
}

TEST_CASE("two entries are joined by 3 s^2 - 2 s^3") {
  const Vector3 from(1, 2, 3), to(5, -2, 3);
  const Trajectory trajectory(table({2, 4}, {from, to}));
  for (const double s : {0.0, 0.1, 0.25, 0.5, 0.9}) {
    CAPTURE(s);
    const auto sample = trajectory.at(2 + 2 * s);
    // Rounding of a few operations on numbers up to 10.
    CHECK((sample.displacement - (from + (3 * s * s - 2 * s * s * s) * (to - from))).norm() < 1e-14);
    CHECK((sample.velocity - (6 * s - 6 * s * s) / 2 * (to - from)).norm() < 1e-14);
    CHECK((sample.acceleration - (6 - 12 * s) / 4 * (to - from)).norm() < 1e-14);
  }
}

TEST_CASE("it is at the entries of its table, and rests before and after") {
  std::mt19937 random(5);
  for (const auto interpolation : {Motion::Interpolation::linear, Motion::Interpolation::smooth}) {
    const Motion motion = random_table(random, interpolation);
    const Trajectory trajectory(motion);
    CHECK(trajectory.moves());
    for (std::size_t k = 0; k < motion.times.size(); ++k) {
      CHECK(trajectory.at(motion.times[k]).displacement == motion.displacements[k]);
    }
    const auto before = trajectory.at(motion.times.front() - 1e-9), after = trajectory.at(motion.times.back());
    CHECK(before.displacement == motion.displacements.front());
    CHECK(after.displacement == motion.displacements.back());
    for (const auto& sample : {before, after, trajectory.at(-inf), trajectory.at(inf)}) {
      CHECK(sample.velocity == Vector3::Zero());
      CHECK(sample.acceleration == Vector3::Zero());
    }
  }
}

TEST_CASE("smooth motion overshoots no entry, turns only at entries and never jumps in velocity") {
  std::mt19937 random(7);
  for (int trial = 0; trial < 50; ++trial) {
    const Motion motion = random_table(random, Motion::Interpolation::smooth);
    const Trajectory trajectory(motion);
    CHECK(trajectory.at(motion.times.front()).velocity == Vector3::Zero());
    for (std::size_t k = 0; k + 1 < motion.times.size(); ++k) {
      const double from = motion.times[k], until = motion.times[k + 1];
      const Vector3 step = motion.displacements[k + 1] - motion.displacements[k];
      Vector3 last = motion.displacements[k];
      constexpr int pieces = 50;
      for (int i = 1; i < pieces; ++i) {
        const auto sample = trajectory.at(from + (until - from) * i / pieces);
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
          // Rounding of numbers up to 10.
          CHECK((sample.displacement[axis] - last[axis]) * (step[axis] < 0 ? -1 : 1) >= -1e-14);
          if (step[axis] == 0) CHECK(std::abs(sample.velocity[axis]) < 1e-14);
        }
        last = sample.displacement;
      }
      const auto at_end = trajectory.at(std::nextafter(until, 0.0)), next = trajectory.at(until);
      // Over the last bit of the time, 1e-14 s, with velocities below 100 m/s and accelerations below 1e4 m/s^2.
      CHECK((at_end.displacement - next.displacement).norm() < 1e-11);
      CHECK((at_end.velocity - next.velocity).norm() < 1e-9);
    }
  }
}

TEST_CASE("velocity and acceleration are derivatives") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(0.05, 0.95);
  for (const auto interpolation : {Motion::Interpolation::linear, Motion::Interpolation::smooth}) {
    for (int trial = 0; trial < 20; ++trial) {
      const Motion motion = random_table(random, interpolation);
      const Trajectory trajectory(motion);
      for (std::size_t k = 0; k + 1 < motion.times.size(); ++k) {
        const double length = motion.times[k + 1] - motion.times[k];
        check_derivatives(trajectory, motion.times[k] + length * place(random));
      }
    }
  }
  Motion sinusoid;
  sinusoid.amplitude = Vector3(0.1, 0, -2);
  sinusoid.frequency = 1.5;
  sinusoid.phase = 0.7;
  for (const double time : {0.1, 0.5, 1.0, 7.3}) check_derivatives(Trajectory(sinusoid), time);
}

TEST_CASE("smooth interpolation approaches a smooth motion") {
  // A rise of 1 m in 1 s that starts and ends at rest.
  const auto rise = [](double t) { return t * t * t * (10 + t * (6 * t - 15)); };
  const auto error = [&](int pieces) {
    std::vector<double> times;
    std::vector<Vector3> displacements;
    for (int k = 0; k <= pieces; ++k) {
      times.push_back(static_cast<double>(k) / pieces);
      displacements.emplace_back(rise(times.back()), -rise(times.back()), 0);
    }
    const Trajectory trajectory(table(times, displacements));
    double greatest = 0;
    for (int i = 0; i <= 1000; ++i) {
      const double t = i / 1000.0;
      greatest = std::max(greatest, (trajectory.at(t).displacement - Vector3(rise(t), -rise(t), 0)).norm());
    }
    return greatest;
  };
  // The slopes of parabolas have an error of second order, so the cubics one of third: 64 for a quarter of the
  // distance, nearly. Slopes of 0, or of the secant on one side, would give 4 to 16.
  CHECK(error(40) / error(160) > 40);
  CHECK(error(40) < 1e-4);
}

TEST_CASE("a straight line stays one, away from where it starts and stops") {
  // Entries at uneven times on y = 2 t: inner slopes are 2 but where a neighbour rests.
  const Trajectory trajectory(table(
      {0, 1, 1.5, 4, 5}, {Vector3(0, 0, 0), Vector3(2, 0, 0), Vector3(3, 0, 0), Vector3(8, 0, 0), Vector3(10, 0, 0)}));
  for (const double t : {1.0, 1.2, 1.5, 2.0, 3.9}) {
    CAPTURE(t);
    CHECK(trajectory.at(t).displacement.x() == doctest::Approx(2 * t).epsilon(1e-14));
    CHECK(trajectory.at(t).velocity.x() == doctest::Approx(2).epsilon(1e-14));
  }
}

TEST_CASE("linear motion is straight between entries, and has the velocity of the side after one") {
  const Trajectory trajectory(
      table({1, 2, 4}, {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 0, -4)}, Motion::Interpolation::linear));
  CHECK(trajectory.at(0.5).velocity == Vector3::Zero());
  CHECK(trajectory.at(1).velocity == Vector3(1, 0, 0));
  CHECK(trajectory.at(1.5).displacement == Vector3(0.5, 0, 0));
  CHECK(trajectory.at(2).velocity == Vector3(0, 0, -2));
  CHECK(trajectory.at(3).displacement == Vector3(1, 0, -2));
  CHECK(trajectory.at(3).acceleration == Vector3::Zero());
  CHECK(trajectory.at(4).velocity == Vector3::Zero());
}

TEST_CASE("a sinusoid starts where it is, and stays where its window ends") {
  Motion motion;
  motion.amplitude = Vector3(0, 0.5, 0);
  motion.frequency = 2;
  motion.phase = 0.3;
  motion.from = 1;
  motion.until = 1.8;
  const Trajectory trajectory(motion);
  CHECK(trajectory.moves());
  CHECK(trajectory.at(0.999).displacement == Vector3::Zero());
  CHECK(trajectory.at(0.999).velocity == Vector3::Zero());
  CHECK(trajectory.at(1).displacement == Vector3::Zero());
  const double rate = 4 * std::numbers::pi;
  for (const double t : {1.0, 1.3, 1.79}) {
    const double angle = rate * (t - 1) + 0.3;
    const auto sample = trajectory.at(t);
    // Rounding of numbers up to 80, the greatest acceleration.
    CHECK(sample.displacement.y() == doctest::Approx(0.5 * (std::sin(angle) - std::sin(0.3))).epsilon(1e-13));
    CHECK(sample.velocity.y() == doctest::Approx(0.5 * rate * std::cos(angle)).epsilon(1e-13));
    CHECK(sample.acceleration.y() == doctest::Approx(-0.5 * rate * rate * std::sin(angle)).epsilon(1e-13));
  }
  const double end = 0.5 * (std::sin(rate * 0.8 + 0.3) - std::sin(0.3));
  for (const double t : {1.8, 5.0}) {
    CHECK(trajectory.at(t).displacement.y() == doctest::Approx(end).epsilon(1e-13));
    CHECK(trajectory.at(t).velocity == Vector3::Zero());
    CHECK(trajectory.at(t).acceleration == Vector3::Zero());
  }
  CHECK(trajectory.next_change(-inf) == 1);
  CHECK(trajectory.next_change(1) == 1.8);
  CHECK(trajectory.next_change(1.8) == inf);
}

TEST_CASE("changes are the entries of a table, each after the one before") {
  const Trajectory trajectory(table({-1, 0, 2.5}, {Vector3::Zero(), Vector3::Ones(), Vector3::Zero()}));
  CHECK(trajectory.next_change(-inf) == -1);
  CHECK(trajectory.next_change(-1) == 0);
  CHECK(trajectory.next_change(0) == 2.5);
  CHECK(trajectory.next_change(1) == 2.5);
  CHECK(trajectory.next_change(2.5) == inf);
}
