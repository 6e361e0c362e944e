// Derivatives of motions with located events against the reference, which shares no code with them: differences of runs
// of CVODE, which finds the times of events by itself.

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/motion_derivatives.hpp>

#include "motion_loss.hpp"
#include "touching_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// Stiffness N/m, damping N s/m, rest length m, mass kg, velocity m/s, in the order of of_bouncing().
using Values = std::array<double, 7>;
constexpr Values real{6.0, 0.2, 0.5, 0.8, 0.9, 0.3, -0.4};
constexpr double end = 1.2;  // s

// A mass on a spring from a hook above the floor, which bounces on it.
Network bouncing(const Values& of, const Friction& friction) {
  Network net;
  Node hook = point({0, 0, 1.1});
  hook.fixed = true;
  net.add_node(hook);
  net.add_node(point({0.2, -0.1, 0.3}, of[3], {of[4], of[5], of[6]}));
  net.add_spring(0, 1, net.add_material(damped(of[0], of[1])), of[2]);
  net.set_gravity({0, 0, -9.81});
  net.add_plane(floor_with(friction, Vector3::UnitZ(), 0.7));
  return net;
}
std::vector<LearnedValues> of_bouncing() {
  return {{Kind::spring_parameter, false, "stiffness", {0}},
          {Kind::viscosity_parameter, false, "damping", {0}},
          {Kind::rest_length, false, "", {0}},
          {Kind::mass, false, "", {1}},
          {Kind::initial_velocity, false, "", {1}}};
}

struct End {
  Vector3 place;
  std::size_t touches = 0;
};
End reference(const Values& of, const Friction& friction) {
  Simulation motion = simulate(bouncing(of, friction), cvode(1e-12), end);
  motion.advance_to(end);
  End result{motion.position(1)};
  for (const Event& each : motion.events()) result.touches += each.kind == Event::Kind::touched ? 1 : 0;
  return result;
}

// Of the place at the end by all values, [3][value].
Eigen::MatrixXd reference_derivatives(const Friction& friction) {
  Eigen::MatrixXd result(3, static_cast<Eigen::Index>(real.size()));
  for (std::size_t i = 0; i < real.size(); ++i) {
    // Of fourth order: their own error, and that of the runs over h, are some 1e-7.
    constexpr double h = 1e-3;
    const auto at = [&](double way) {
      Values moved = real;
      moved[i] += way;
      return reference(moved, friction).place;
    };
    result.col(static_cast<Eigen::Index>(i)) = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
  }
  return result;
}
Eigen::MatrixXd derivatives(const Friction& friction, double step) {
  MotionDerivatives motion(std::make_shared<const Network>(bouncing(real, friction)), plugins(), located(0.5, step),
                           end, of_bouncing());
  motion.run(motion.values_of_network());
  Eigen::MatrixXd result(3, static_cast<Eigen::Index>(real.size()));
  for (const Eigen::Index axis : {0, 1, 2}) result.row(axis) = gradient_of_end(motion, 1, axis).transpose();
  return result;
}

}  // namespace

TEST_CASE("derivatives of a mass that bounces on a spring go to those of the reference with the second order") {
  for (const Friction& friction : {smooth, rough}) {
    CAPTURE(static_cast<int>(friction.kind));
    REQUIRE(reference(real, friction).touches >= 3);
    const Eigen::MatrixXd right = reference_derivatives(friction);
    constexpr double step = 0.005;
    const double coarse = (derivatives(friction, step) - right).norm() / right.norm(),
                 fine = (derivatives(friction, step / 2) - right).norm() / right.norm();
    MESSAGE("relative difference: ", coarse, ", with half the step ", fine);
    CHECK(coarse < 2e-3);
    CHECK(coarse / fine == doctest::Approx(4.0).epsilon(0.1));
  }
}
