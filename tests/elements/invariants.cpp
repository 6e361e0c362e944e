// Values and gradients of the invariants against the complex step of other formulas, Hessians against sixth-order
// differences of gradients.
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "bodies.hpp"
#include "layers/elements/blocks.hpp"
#include "layers/elements/enclosure.hpp"
#include "layers/elements/invariant.hpp"

using namespace springnet;
using namespace springnet::testing;
using layers::Corners;
using layers::FirstOrder;

namespace {

constexpr double step = 2e-3;

// Sixth order: error step^6 (about 1e-16) times a seventh derivative, and rounding 1e-16 / step.
template <class Function>
auto derivative(const Function& f) {
  const auto odd = [&](double h) { return decltype(f(0.0))(f(h) - f(-h)); };
  return decltype(f(0.0))((45.0 * odd(step) - 9.0 * odd(2 * step) + odd(3 * step)) / (60.0 * step));
}
// Rounding of gradients of order 1, and seventh derivatives of these of some 10^6.
constexpr double second_tolerance = 2e-10;

constexpr std::array four{Invariant::angle, Invariant::dihedral, Invariant::area, Invariant::volume};

// A shape far from those where an invariant has no gradient.
Corners shape(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto some = [&] { return Vector3(unit(random), unit(random), unit(random)); };
  Corners corners;
  const Vector3 places[] = {{0, 0, 0}, {2, 0, 0}, {0.7, 1.6, 0}, {1.2, -1.5, 0.5}};
  for (int i = 0; i < 4; ++i) {
    corners.position[i] = places[i] + 0.25 * some();
    corners.velocity[i] = some();
  }
  return corners;
}

double plain(Invariant invariant, const Corners& corners) {
  return plain_invariant(invariant, {std::begin(corners.position), std::end(corners.position)});
}

using Complex = std::complex<double>;
struct ComplexVector {
  Complex x, y, z;
  friend ComplexVector operator-(const ComplexVector& a, const ComplexVector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend ComplexVector operator*(const Complex& s, const ComplexVector& a) { return {s * a.x, s * a.y, s * a.z}; }
};
// Without conjugates.
Complex dot(const ComplexVector& a, const ComplexVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
ComplexVector cross(const ComplexVector& a, const ComplexVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
ComplexVector unit(const ComplexVector& a) { return 1.0 / std::sqrt(dot(a, a)) * a; }

// dq/d(coordinate) to rounding: Im q(p + i h) / h, with no difference of nearly equal numbers.
double complex_step(Invariant invariant, const Corners& corners, std::size_t corner, Eigen::Index coordinate) {
  constexpr double tiny = 1e-60;
  std::array<ComplexVector, 4> p;
  for (std::size_t i = 0; i < 4; ++i)
    p[i] = {corners.position[i].x(), corners.position[i].y(), corners.position[i].z()};
  (coordinate == 0 ? p[corner].x : coordinate == 1 ? p[corner].y : p[corner].z) += Complex(0.0, tiny);
  Complex q;
  switch (invariant) {
    case Invariant::angle: {
      const ComplexVector u = unit(p[0] - p[1]), w = unit(p[2] - p[1]), n = cross(u, w);
      q = std::atan(std::sqrt(dot(n, n)) / dot(u, w));
      break;
    }
    case Invariant::dihedral: {
      const ComplexVector edge = unit(p[1] - p[0]);
      const auto tip = [&](std::size_t k) {
        const ComplexVector t = p[k] - p[0];
        return unit(t - dot(edge, t) * edge);
      };
      const ComplexVector c = tip(2), d = tip(3);
      q = std::atan(dot(edge, cross(c, d)) / dot(c, d));
      break;
    }
    case Invariant::area: {  // Heron's formula
      const auto side = [&](std::size_t i, std::size_t j) { return std::sqrt(dot(p[i] - p[j], p[i] - p[j])); };
      const Complex a = side(1, 2), b = side(2, 0), c = side(0, 1), s = 0.5 * (a + b + c);
      q = std::sqrt(s * (s - a) * (s - b) * (s - c));
      break;
    }
    default:
      q = dot(p[3] - p[2], cross(p[1] - p[2], p[0] - p[2])) / -6.0;
  }
  return q.imag() / tiny;
}

}  // namespace

TEST_CASE("values, rates and gradients are those of plain formulas") {
  constexpr double rounding = 2e-14;  // of gradients of order 1 and their products, some ten operations
  for (const Invariant invariant : four) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      CAPTURE(name_of(invariant));
      CAPTURE(seed);
      const Corners corners = shape(seed);
      FirstOrder found;
      layers::first_order(invariant, corners, found);
      CHECK(found.value == doctest::Approx(plain(invariant, corners)).epsilon(1e-13));  // some roundings
      Vector3 sum = Vector3::Zero(), torque = Vector3::Zero();
      double rate = 0.0;
      for (std::size_t i = 0; i < corners_of(invariant); ++i) {
        for (Eigen::Index c = 0; c < 3; ++c) {
          const double expected = complex_step(invariant, corners, i, c);
          CHECK(std::abs(found.gradient[i][c] - expected) < rounding);
          rate += expected * corners.velocity[i][c];
        }
        sum += found.gradient[i];
        torque += corners.position[i].cross(found.gradient[i]);
      }
      CHECK(std::abs(found.rate - rate) < 10 * rounding);
      // Rigid motions change nothing: rounding.
      CHECK(sum.norm() < 1e-14);
      CHECK(torque.norm() < 1e-14);
    }
  }
}

TEST_CASE("Hessians are the derivatives of the gradients, and give those of the rates") {
  for (const Invariant invariant : four) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      CAPTURE(name_of(invariant));
      const Corners corners = shape(seed);
      layers::SecondOrder found;
      layers::second_order(invariant, corners, found);
      const std::size_t count = corners_of(invariant);
      for (std::size_t j = 0; j < count; ++j) {
        for (Eigen::Index c = 0; c < 3; ++c) {
          using Gradients = Eigen::Matrix<double, 12, 1>;
          const Gradients expected = derivative([&](double h) {
            Corners moved = corners;
            moved.position[j][c] += h;
            FirstOrder there;
            layers::first_order(invariant, moved, there);
            Gradients all = Gradients::Zero();
            for (std::size_t i = 0; i < count; ++i)
              all.segment<3>(3 * static_cast<Eigen::Index>(i)) = there.gradient[i];
            return all;
          });
          for (std::size_t i = 0; i < count; ++i)
            CHECK((found.hessian[i][j].col(c) - expected.segment<3>(3 * static_cast<Eigen::Index>(i))).norm() <
                  second_tolerance);
        }
        const layers::OwnSecondOrder own = layers::own_second_order(invariant, corners, j);
        // The same formulas with other variables: rounding.
        CHECK((own.hessian - found.hessian[j][j]).norm() < 1e-13);
        CHECK((own.rate_gradient - found.rate_gradient[j]).norm() < 1e-13);
        Vector3 expected = Vector3::Zero();
        for (std::size_t k = 0; k < count; ++k) expected += found.hessian[j][k] * corners.velocity[k];
        CHECK((found.rate_gradient[j] - expected).norm() < 1e-14);
      }
    }
  }
}

TEST_CASE("a dihedral angle is signed, and smooth through flat") {
  for (const double angle : {-2.5, -0.7, -1e-9, 0.0, 1e-9, 0.7, 2.5}) {
    CAPTURE(angle);
    Corners corners;
    corners.position[0] = {0, 0, 0};
    corners.position[1] = {2, 0, 0};
    corners.position[2] = {0.6, 1, 0};
    // The second wing turned down, away from the normals, which point up.
    corners.position[3] = {1.3, -1.5 * std::cos(angle), -1.5 * std::sin(angle)};
    FirstOrder found;
    layers::first_order(Invariant::dihedral, corners, found);
    CHECK(std::abs(found.value - angle) < 1e-15);             // rounding of coordinates of order 1
    CHECK(found.gradient[2].norm() == doctest::Approx(1.0));  // 1 / the height of the tip over the edge
    CHECK(found.gradient[3].norm() == doctest::Approx(1.0 / 1.5));
  }
}

TEST_CASE("a law reads the turn of a dihedral angle that is nearest to its reference") {
  CHECK(layers::nearest_turn(Invariant::dihedral, -3.1, 3.0) == doctest::Approx(2.0 * std::numbers::pi - 3.1));
  CHECK(layers::nearest_turn(Invariant::dihedral, 0.5, 0.4) == 0.5);
  CHECK(layers::nearest_turn(Invariant::dihedral, 2.0, -3.0) == doctest::Approx(2.0 - 2.0 * std::numbers::pi));
  CHECK(layers::nearest_turn(Invariant::volume, 20.0, 1.0) == 20.0);
}

TEST_CASE("an invariant without a gradient exerts no force") {
  Corners corners;
  for (auto& p : corners.position) p = {0.3, 0.2, 0.1};
  for (auto& v : corners.velocity) v = {1, 2, 3};
  const auto has_gradient = [&](Invariant invariant) {
    FirstOrder found;
    layers::first_order(invariant, corners, found);
    REQUIRE(std::isfinite(found.value));
    REQUIRE(found.rate == 0.0);
    layers::ElementBlocks blocks;
    layers::linearise(invariant, corners, found, {1.0, 2.0, 3.0}, blocks);
    double size = 0.0;
    for (std::size_t i = 0; i < corners_of(invariant); ++i) {
      size += found.gradient[i].norm();
      for (std::size_t j = 0; j < corners_of(invariant); ++j) {
        REQUIRE(blocks.stiffness[i][j].allFinite());
        REQUIRE(blocks.damping_block(i, j).allFinite());
      }
    }
    return size > 0.0;
  };
  for (const Invariant invariant : four) CHECK_FALSE(has_gradient(invariant));  // all in one place
  for (int i = 0; i < 4; ++i) corners.position[i] = {i == 1 ? 0.0 : i == 0 ? -1.0 : 2.0 + i, 0, 0};
  CHECK_FALSE(has_gradient(Invariant::angle));  // straight
  CHECK_FALSE(has_gradient(Invariant::area));
  CHECK_FALSE(has_gradient(Invariant::dihedral));
}

TEST_CASE("a straight angle has the stiffness of angles that are nearly straight") {
  // With a law that rests at pi the stiffness is a smooth function of the shape.
  const auto stiffness_at = [](double bend, double side) {
    Corners corners;
    corners.position[0] = {-side * 0.8, 0, 0};
    corners.position[1] = {0, 0, 0};
    corners.position[2] = {1.4, 1.4 * bend, 0};
    for (auto& v : corners.velocity) v.setZero();
    FirstOrder geometry;
    layers::first_order(Invariant::angle, corners, geometry);
    const double rest = side > 0.0 ? std::numbers::pi : 0.0, k = 3.0;
    layers::ElementBlocks blocks;
    layers::linearise(Invariant::angle, corners, geometry, {k * (geometry.value - rest), k, 0.7}, blocks);
    Eigen::Matrix<double, 9, 9> all;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        all.block<3, 3>(3 * i, 3 * j) = blocks.stiffness[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    return all;
  };
  for (const double side : {1.0, -1.0}) {  // straight, and folded
    const Eigen::Matrix<double, 9, 9> straight = stiffness_at(0.0, side);
    CHECK(straight.norm() > 3.0);
    // What lies across turns with the bend; the Hessian's rounding is 1e-16 / bend.
    CHECK((stiffness_at(1e-5, side) - straight).norm() < 4e-5 * straight.norm());
    CHECK((stiffness_at(1e-9, side) - straight).norm() < 4e-9 * straight.norm());
  }
}

TEST_CASE("a straight angle that bends has the gradient and the rate of the shape right after") {
  for (const double side : {1.0, -1.0}) {  // straight, and folded
    Corners corners;
    corners.position[0] = {-side * 0.8, 0, 0};
    corners.position[1] = {0, 0, 0};
    corners.position[2] = {1.4, 0, 0};
    corners.velocity[0] = {0.3, 0.2, -0.4};
    corners.velocity[1] = {-0.1, 0.5, 0.7};
    corners.velocity[2] = {0.2, -0.6, 0.1};
    FirstOrder now, next;
    layers::first_order(Invariant::angle, corners, now);
    CHECK(std::abs(now.rate) > 1.0);
    // What changes in 1e-7 s is of that order; the gradient's rounding is 1e-16 / 1e-7.
    for (std::size_t i = 0; i < 3; ++i) corners.position[i] += 1e-7 * corners.velocity[i];
    layers::first_order(Invariant::angle, corners, next);
    CHECK(now.rate == doctest::Approx(next.rate).epsilon(1e-6));
    for (std::size_t i = 0; i < 3; ++i) CHECK((now.gradient[i] - next.gradient[i]).norm() < 1e-6);
  }
}

TEST_CASE("an enclosed volume: value and gradients, linear in each node's position") {
  TriangleMesh mesh = icosphere(1, 1.0);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-0.1, 0.1);
  const auto n = mesh.points.size();
  std::vector<double> p[3], v[3];
  for (std::size_t k = 0; k < n; ++k) {
    mesh.points[k] += Vector3(unit(random), unit(random), unit(random)) + Vector3(3, -2, 1);
    for (std::size_t c = 0; c < 3; ++c) {
      p[c].push_back(mesh.points[k][static_cast<Eigen::Index>(c)]);
      v[c].push_back(10 * unit(random));
    }
  }
  const layers::NodeArrays nodes{p[0].data(), p[1].data(), p[2].data(), v[0].data(), v[1].data(), v[2].data()};
  const layers::Enclosure enclosure(mesh.triangles);
  REQUIRE(enclosure.size() == n);
  const auto plain_volume = [&] {
    std::vector<Vector3> corners;
    for (const NodeIndex k : mesh.triangles) corners.emplace_back(p[0][k], p[1][k], p[2][k]);
    return plain_invariant(Invariant::enclosed_volume, corners);
  };
  const layers::Enclosure::Values values = enclosure.values(nodes);
  CHECK(values.volume == doctest::Approx(plain_volume()).epsilon(1e-13));
  double rate = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const Vector3 gradient = enclosure.gradient(k, nodes), rate_gradient = enclosure.rate_gradient(k, nodes);
    for (std::size_t c = 0; c < 3; ++c) {
      double& coordinate = p[c][enclosure.nodes()[k]];
      const double value = coordinate;
      const auto moved = [&](const auto& what) {
        return derivative([&](double h) {
          coordinate = value + h;
          const double there = what();
          coordinate = value;
          return there;
        });
      };
      const double by_p = moved(plain_volume);
      const double rate_by_p = moved([&] { return enclosure.values(nodes).rate; });
      const auto row = static_cast<Eigen::Index>(c);
      CHECK(std::abs(gradient[row] - by_p) < 1e-11);  // a polynomial: rounding over the step
      CHECK(std::abs(rate_gradient[row] - rate_by_p) < 1e-11);
      rate += by_p * v[c][enclosure.nodes()[k]];
      // Linear in the node's own position, however far it moves.
      coordinate = value + 0.7;
      CHECK(std::abs(enclosure.values(nodes).volume - values.volume - 0.7 * gradient[row]) < 1e-13);
      CHECK((enclosure.gradient(k, nodes) - gradient).norm() == 0.0);
      coordinate = value;
    }
    for (const layers::Enclosure::Spoke& spoke : enclosure.spokes(k)) {
      const Vector3 across = layers::Enclosure::across(spoke, nodes);
      for (Eigen::Index c = 0; c < 3; ++c) {
        double& coordinate = p[static_cast<std::size_t>(c)][spoke.other];
        const double value = coordinate;
        coordinate = value + 1.0;
        const Vector3 there = enclosure.gradient(k, nodes);
        coordinate = value;
        CHECK((there - gradient - across.cross(Vector3(Vector3::Unit(c)))).norm() < 1e-13);  // linear: exact
      }
    }
  }
  CHECK(std::abs(values.rate - rate) < 1e-10);
}
