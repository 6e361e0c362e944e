// Derivatives of constraints by the complex step: Im f(x + i h) / h is f'(x) without a difference, to rounding. (W.
// Squire, G. Trapp, SIAM Rev. 40 (1998) 110-112.) The functions are the definitions: distances, and their second
// derivatives in time by truncated series.
#include <array>
#include <complex>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "constraints/acceleration_gradients.hpp"
#include "constraints/contact.hpp"
#include "constraints/obstacle.hpp"
#include "dice.hpp"
#include "nets.hpp"

using namespace springnet;
using springnet::testing::Dice;

namespace {

using Complex = std::complex<double>;
constexpr double tiny = 1e-60;

// c[0] + c[1] t + c[2] t^2, of something that changes with time.
struct Series {
  std::array<Complex, 3> c{};

  Series() = default;
  Series(const Complex& a, const Complex& by_time = 0.0, const Complex& half = 0.0)  // NOLINT
      : c{a, by_time, half} {}
  Series(double a) : c{a} {}  // NOLINT(google-explicit-constructor)
  friend Series operator+(const Series& a, const Series& b) {
    return {a.c[0] + b.c[0], a.c[1] + b.c[1], a.c[2] + b.c[2]};
  }
  friend Series operator-(const Series& a, const Series& b) {
    return {a.c[0] - b.c[0], a.c[1] - b.c[1], a.c[2] - b.c[2]};
  }
  friend Series operator*(const Series& a, const Series& b) {
    return {a.c[0] * b.c[0], a.c[0] * b.c[1] + a.c[1] * b.c[0], a.c[0] * b.c[2] + a.c[1] * b.c[1] + a.c[2] * b.c[0]};
  }
};
Series sqrt(const Series& a) {
  const Complex root = std::sqrt(a.c[0]), first = a.c[1] / (2.0 * root);
  return {root, first, (a.c[2] - first * first) / (2.0 * root)};
}
double real(const Series& a) { return a.c[0].real(); }
double real(const Complex& a) { return a.real(); }

template <class Number>
using VectorOf = std::array<Number, 3>;

template <class Number>
Number dot(const VectorOf<Number>& a, const VectorOf<Number>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class Number>
VectorOf<Number> constant(const Vector3& x) {
  return {Number(x[0]), Number(x[1]), Number(x[2])};
}
template <class Number>
VectorOf<Number> difference(const VectorOf<Number>& a, const VectorOf<Number>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class Number>
VectorOf<Number> scaled(const Number& a, const VectorOf<Number>& x) {
  return {a * x[0], a * x[1], a * x[2]};
}
template <class Number>
VectorOf<Number> turned(const Matrix3& m, const VectorOf<Number>& x) {
  VectorOf<Number> result{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      result[static_cast<std::size_t>(i)] =
          result[static_cast<std::size_t>(i)] + Number(m(i, j)) * x[static_cast<std::size_t>(j)];
  return result;
}

// The vector from the obstacle's core (a plane, a segment, a box without its rounding) to a point outside of it, by its
// definition, and how far the surface is from the core. Comparisons are of real parts.
template <class Number>
struct FromCore {
  VectorOf<Number> vector;
  double radius;
};
template <class Number>
FromCore<Number> from_core(const Plane& plane, const VectorOf<Number>& p) {
  const VectorOf<Number> n = constant<Number>(plane.normal.normalized());
  return {scaled(dot(difference(p, constant<Number>(plane.point)), n), n), 0.0};
}
template <class Number>
FromCore<Number> from_core(const Instrument& tool, const VectorOf<Number>& p) {
  const VectorOf<Number> off = difference(p, constant<Number>(tool.first));
  if (!tool.box) {
    const VectorOf<Number> axis = constant<Number>(tool.second - tool.first);
    Number along = Number(1.0 / (tool.second - tool.first).squaredNorm()) * dot(off, axis);
    if (real(along) < 0.0) along = Number(0.0);
    if (real(along) > 1.0) along = Number(1.0);
    return {difference(off, scaled(along, axis)), tool.radius};
  }
  const BoxShape& box = *tool.box;
  VectorOf<Number> q = turned<Number>(box.axes.transpose(), off);
  for (std::size_t a = 0; a < 3; ++a) {
    const double half = 0.5 * box.size[static_cast<Eigen::Index>(a)] - box.radius;
    if (real(q[a]) > half)
      q[a] = q[a] - Number(half);
    else if (real(q[a]) < -half)
      q[a] = q[a] + Number(half);
    else
      q[a] = Number(0.0);
  }
  return {turned<Number>(box.axes, q), box.radius};
}
template <class Shape, class Number>
Number gap_of(const Shape& shape, const VectorOf<Number>& p) {
  using std::sqrt;
  const FromCore<Number> from = from_core(shape, p);
  return sqrt(dot(from.vector, from.vector)) - Number(from.radius);
}
template <class Shape>
VectorOf<Complex> normal_of(const Shape& shape, const VectorOf<Complex>& p) {
  const VectorOf<Complex> vector = from_core(shape, p).vector;
  return scaled(1.0 / std::sqrt(dot(vector, vector)), vector);
}

// Calls check(shape) for planes, capsules, a ball and boxes at rest.
template <class Check>
void for_each_shape(Dice& dice, const Check& check) {
  Plane plane;
  plane.normal = Vector3(0.36, 0.48, 0.8);
  plane.point = Vector3(0.1, 0.2, -0.3);
  check(plane);
  Instrument capsule;
  capsule.first = {-0.2, 0.1, 0.0};
  capsule.second = {0.4, 0.1, 0.2};
  capsule.radius = 0.3;
  check(capsule);
  Instrument ball = capsule;
  ball.second = ball.first + Vector3(1e-3, 0, 0);
  check(ball);
  for (const double radius : {0.05, 0.1}) {
    Instrument box;
    box.first = {0.1, 0.2, 0};
    box.box = BoxShape{{0.6, 0.4, 0.3}, dice.rotation(), radius};
    check(box);
  }
}

bool is_outside(const Plane& plane, const Vector3& x) {  // its vector from the core has the normal's direction
  return plane.normal.dot(x - plane.point) > 0.01;
}
bool is_outside(const Instrument& tool, const Vector3& x) { return gap_of(tool, constant<Complex>(x)).real() > 0.01; }

// A point with imaginary part `tiny` in coordinate c.
VectorOf<Complex> stepped(const Vector3& x, int c) {
  VectorOf<Complex> p = constant<Complex>(x);
  p[static_cast<std::size_t>(c)] += Complex(0.0, tiny);
  return p;
}
Vector3 imaginary(const VectorOf<Complex>& x) { return Vector3(x[0].imag(), x[1].imag(), x[2].imag()) / tiny; }

// Motion and turn at once.
template <class Shape>
Shape moving(Shape shape) {
  shape.motion.emplace();
  shape.motion->amplitude = {0.1, -0.2, 0.15};
  shape.motion->frequency = 0.7;
  shape.turn.emplace();
  shape.turn->axis = Vector3(0.6, 0.0, 0.8);
  shape.turn->through = Vector3(0.3, -0.2, 0.4);
  shape.turn->times = {0.0, 1.0, 2.5};
  shape.turn->angles = {0.0, 2.0, -1.0};
  return shape;
}

Matrix3 cross(const Vector3& w) {
  Matrix3 m;
  m << 0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0;
  return m;
}

// d^2 gap/dt^2 of a point at p with velocity v and acceleration a, from an obstacle that moves as its pose says: the
// distance of its place in the obstacle's frame, R^T (p(t) - pivot(t)), which turns by dR/dt = spin x R.
template <class Shape>
Complex gap_acceleration(const Shape& shape, const Pose& pose, const VectorOf<Complex>& p, const VectorOf<Complex>& v,
                         const VectorOf<Complex>& a) {
  const Matrix3 spin = cross(pose.spin);
  // R^T(t) = R^T (1 - t [w] + t^2 / 2 ([w]^2 - [w'])).
  const Matrix3 turning[] = {pose.rotation.transpose(), -pose.rotation.transpose() * spin,
                             0.5 * pose.rotation.transpose() * (spin * spin - cross(pose.spin_acceleration))};
  const Vector3 pivot = pose.pivot + pose.displacement;
  VectorOf<Series> place;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    place[i] = Series(Complex(pose.pivot[at]));
    for (std::size_t j = 0; j < 3; ++j) {
      const auto by = static_cast<Eigen::Index>(j);
      const Series off(p[j] - pivot[by], v[j] - pose.velocity[by], 0.5 * (a[j] - pose.acceleration[by]));
      place[i] = place[i] + Series(Complex(turning[0](at, by)), turning[1](at, by), turning[2](at, by)) * off;
    }
  }
  return 2.0 * gap_of(shape, place).c[2];
}

// A network with the obstacle alone and one node.
struct Surroundings {
  template <class Shape>
  explicit Surroundings(const Shape& shape) {
    net.add_node({});
    if constexpr (std::is_same_v<Shape, Plane>)
      net.add_plane(shape);
    else
      net.add_instrument(shape);
  }
  Network net;
};

}  // namespace

TEST_CASE("normals are the complex step of the distance by its definition, curvatures that of the normal") {
  Dice dice;
  for_each_shape(dice, [&](const auto& shape) {
    const Obstacle obstacle(shape);
    int checked = 0;
    for (int k = 0; k < 300; ++k) {
      const Vector3 x = dice.vector(1.5);
      if (!is_outside(shape, x)) continue;
      ++checked;
      CHECK(std::abs(gap_of(shape, constant<Complex>(x)).real() - obstacle.gap(Pose{}, x)) <= 2e-15);
      const Matrix3 curvature = obstacle.curvature(Pose{}, x);
      Vector3 normal;
      double worst = 0.0;
      for (int c = 0; c < 3; ++c) {
        normal[c] = gap_of(shape, stepped(x, c)).imag() / tiny;
        worst = std::max(worst, (curvature.col(c) - imaginary(normal_of(shape, stepped(x, c)))).norm());
      }
      // Roundings of a direction of length 1, of points some tenths from the core and down to some hundredths; those of
      // its derivative are up to 1 / 0.05 times as great.
      CHECK((obstacle.normal(Pose{}, x) - normal).norm() <= 5e-14);
      CHECK(worst <= 1e-12);
    }
    CHECK(checked > 50);
  });
}

TEST_CASE("gradients of gap accelerations, and of directions of slip, are those by the complex step") {
  Dice dice;
  for_each_shape(dice, [&](const auto& at_start) {
    const auto shape = moving(at_start);
    const Surroundings around(shape);
    const Contact contact(around.net, {0}, {0}, {1.0});
    const Obstacle obstacle(shape);
    int checked = 0;
    for (int k = 0; k < 100; ++k) {
      Placement placement;
      placement.poses = {obstacle.at(just_after(dice.number(0.1, 0.9)))};
      const Pose& pose = placement.poses[0];
      const Vector3 start = dice.vector(1.5), v = dice.vector(1.0), a = dice.vector(1.0);
      if (!is_outside(shape, start)) continue;
      ++checked;
      const Vector3 p = pose.from_start(start);
      const AccelerationGradient gradient = gap_acceleration_gradient(contact, placement, 0, p, v, a);
      Vector3 by_position, by_velocity;
      for (int c = 0; c < 3; ++c) {
        const auto derivative = [&](const VectorOf<Complex>& of_p, const VectorOf<Complex>& of_v) {
          return gap_acceleration(shape, pose, of_p, of_v, constant<Complex>(a)).imag() / tiny;
        };
        by_position[c] = derivative(stepped(p, c), constant<Complex>(v));
        by_velocity[c] = derivative(constant<Complex>(p), stepped(v, c));
      }
      // Speeds to 5 m/s at curvatures to 1 / 0.06 m: second derivatives to 1e4 1/s^2.
      CHECK((gradient.by_position - by_position).norm() <= 1e-14 * (1e2 + by_position.norm()) * 10.0);
      CHECK((gradient.by_velocity - by_velocity).norm() <= 1e-13 * (1.0 + by_velocity.norm()));

      // The direction of slip: of the relative velocity along the surface.
      const Vector3 n = obstacle.normal(pose, p), relative = v - pose.velocity_at(p);
      const Matrix3 direction =
          direction_by_position(n, obstacle.curvature(pose, p), relative, -velocity_by_position(pose));
      Matrix3 expected;
      for (int c = 0; c < 3; ++c) {
        const VectorOf<Complex> at = stepped(p, c);
        const auto in_frame = difference(at, constant<Complex>(pose.pivot + pose.displacement));
        VectorOf<Complex> place = turned<Complex>(pose.rotation.transpose(), in_frame);
        for (std::size_t i = 0; i < 3; ++i) place[i] += pose.pivot[static_cast<Eigen::Index>(i)];
        const VectorOf<Complex> normal = turned<Complex>(pose.rotation, normal_of(shape, place));
        const VectorOf<Complex> speed = difference(difference(constant<Complex>(v), constant<Complex>(pose.velocity)),
                                                   turned<Complex>(cross(pose.spin), in_frame));
        const VectorOf<Complex> along = difference(speed, scaled(dot(speed, normal), normal));
        expected.col(c) = imaginary(scaled(1.0 / std::sqrt(dot(along, along)), along));
      }
      CHECK((direction - expected).norm() <= 1e-12 * (1.0 + expected.norm()));
    }
    CHECK(checked > 15);
  });
}

TEST_CASE("gradients of the acceleration of a rigid connection's length are those by the complex step") {
  Dice dice;
  const auto acceleration = [](const VectorOf<Complex>& p, const VectorOf<Complex>& v, const Vector3& a) {
    VectorOf<Series> path;
    for (std::size_t i = 0; i < 3; ++i) path[i] = Series(p[i], v[i], 0.5 * a[static_cast<Eigen::Index>(i)]);
    return 2.0 * sqrt(dot(path, path)).c[2];
  };
  for (int k = 0; k < 100; ++k) {
    const Vector3 p = dice.vector(1.0), v = dice.vector(1.0), a = dice.vector(1.0);
    if (p.norm() < 0.2) continue;
    const AccelerationGradient gradient = length_acceleration_gradient(p, v, a);
    Vector3 by_position, by_velocity;
    for (int c = 0; c < 3; ++c) {
      by_position[c] = acceleration(stepped(p, c), constant<Complex>(v), a).imag() / tiny;
      by_velocity[c] = acceleration(constant<Complex>(p), stepped(v, c), a).imag() / tiny;
    }
    CHECK((gradient.by_position - by_position).norm() <= 1e-14 * (1.0 + by_position.norm()) * 10.0);
    CHECK((gradient.by_velocity - by_velocity).norm() <= 1e-14 * (1.0 + by_velocity.norm()) * 10.0);
  }
}
