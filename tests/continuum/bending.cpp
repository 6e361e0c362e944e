// Shells: the energy that hinges store when a flat sheet of equilateral triangles is bent, against that of a plate.
#include <cmath>
#include <functional>
#include <numbers>

#include <doctest/doctest.h>

#include "../layers/random_net.hpp"
#include "laws.hpp"
#include "layers/elements/queries.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double modulus = 3.0, nu = 0.3, thickness = 0.1;

double rigidity() { return modulus * thickness * thickness * thickness / (12.0 * (1.0 - nu * nu)); }
// Nodes of equilateral triangles of side 1 about the origin, in rows along a direction at `angle` to the x axis, and of
// each node in the middle its three hinges: edges of all directions in equal numbers.
struct Triangles {
  std::vector<Vector3> points;
  std::vector<std::array<NodeIndex, 4>> hinges;
  double area = 0.0;  // m^2, of the nodes in the middle

  Triangles(int rows, double angle) {
    const Vector3 u(std::cos(angle), std::sin(angle), 0.0);
    const Vector3 v(std::cos(angle + std::numbers::pi / 3.0), std::sin(angle + std::numbers::pi / 3.0), 0.0);
    const int side = 2 * rows + 1;
    const auto at = [&](int i, int j) { return static_cast<NodeIndex>(i + rows + side * (j + rows)); };
    for (int j = -rows; j <= rows; ++j)
      for (int i = -rows; i <= rows; ++i) points.push_back(i * u + j * v);
    for (int j = 1 - rows; j < rows - 1; ++j)
      for (int i = 2 - rows; i < rows - 1; ++i) {
        hinges.push_back({at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j - 1)});
        hinges.push_back({at(i, j), at(i, j + 1), at(i - 1, j + 1), at(i + 1, j)});
        hinges.push_back({at(i, j), at(i - 1, j + 1), at(i - 1, j), at(i, j + 1)});
        area += 0.5 * std::numbers::sqrt3;
      }
  }
};

// Hinges on a lattice, at rest where its points are, or at rest(point).
struct Plate {
  Plate(const Triangles& of, const std::function<Vector3(const Vector3&)>& rest)
      : lattice(of), fixture(network(of, rest), InstructionSet::best, 1, false) {
    fixture.external.gravity.setZero();
  }
  explicit Plate(const Triangles& of) : Plate(of, [](const Vector3& p) { return p; }) {}
  static Network network(const Triangles& lattice, const std::function<Vector3(const Vector3&)>& rest) {
    Network net;
    for (const Vector3& p : lattice.points) net.add_node(point(p));
    const MaterialIndex index = net.add_material({shell_law(modulus, nu, thickness), std::nullopt});
    for (const auto& hinge : lattice.hinges) {
      std::vector<Vector3> at_rest;
      for (const NodeIndex node : hinge) at_rest.push_back(rest(lattice.points[node]));
      net.add_element(Invariant::hinge, {hinge.begin(), hinge.end()}, index, at_rest);
    }
    return net;
  }
  // J/m^2 at rest, with points moved to shape(point).
  double energy(const std::function<Vector3(const Vector3&)>& shape) {
    for (std::size_t k = 0; k < lattice.points.size(); ++k) {
      const Vector3 p = shape(lattice.points[k]);
      for (std::size_t c = 0; c < 3; ++c) fixture.p[c][k] = p[static_cast<Eigen::Index>(c)];
    }
    fixture.evaluate();
    return layers::element_energy(fixture.layout, fixture.evaluator->instruction_set(), 0.0, fixture.nodes()) /
           lattice.area;
  }
  [[nodiscard]] double greatest_force() const {
    double greatest = 0.0;
    for (std::size_t k = 0; k < lattice.points.size(); ++k)
      greatest = std::max(greatest, Vector3(fixture.f[0][k], fixture.f[1][k], fixture.f[2][k]).norm());
    return greatest;
  }

  const Triangles& lattice;
  EvaluatorFixture fixture;
};

// The plane z = 0 wound onto a cylinder along y.
Vector3 wound(const Vector3& p, double curvature) {
  const double r = 1.0 / curvature;
  return {r * std::sin(curvature * p.x()), p.y(), r * (1.0 - std::cos(curvature * p.x()))};
}

constexpr std::array angles{0.0, 0.1, 0.3, std::numbers::pi / 6.0, 1.0};

}  // namespace

TEST_CASE("a cylinder of equilateral triangles stores D kappa^2 / 2 per area, whatever their orientation") {
  for (const double angle : angles) {
    CAPTURE(angle);
    const Triangles lattice(6, angle);
    Plate plate(lattice);
    const auto error = [&](double curvature) {
      const double expected = 0.5 * rigidity() * curvature * curvature;
      return plate.energy([&](const Vector3& p) { return wound(p, curvature); }) / expected - 1.0;
    };
    const double coarse = error(0.1), fine = error(0.05);
    // Of second order in the side over the radius.
    CHECK(std::abs(coarse) < 0.01);
    CHECK(std::abs(fine) < 0.27 * std::abs(coarse) + 1e-9);
  }
}

TEST_CASE("with two curvatures equilateral triangles store D/2 (k1^2 + k2^2 - 2/3 k1 k2) per area") {
  // As H. S. Seung, D. R. Nelson, Phys. Rev. A 38 (1988) 1005: hinges of one stiffness are a plate with a rigidity of
  // its own for the Gaussian curvature, -4/3 D, that of a plate with a Poisson ratio of -1/3.
  for (const double angle : angles) {
    CAPTURE(angle);
    const Triangles lattice(4, angle);
    Plate plate(lattice);
    for (const auto& [k1, k2] :
         {std::pair(1.0, 0.0), std::pair(1.0, 1.0), std::pair(1.0, -1.0), std::pair(0.4, -1.7)}) {
      constexpr double small = 1e-5;  // 1/m: slopes of 1e-4, whose squares are neglected
      const double energy = plate.energy([k1 = k1, k2 = k2](const Vector3& p) {
        return Vector3(p.x(), p.y(), 0.5 * small * (k1 * p.x() * p.x() + k2 * p.y() * p.y()));
      });
      const double expected = 0.5 * rigidity() * (k1 * k1 + k2 * k2 - 2.0 / 3.0 * k1 * k2) * small * small;
      CHECK(energy == doctest::Approx(expected).epsilon(1e-7));
    }
  }
}

TEST_CASE("a shell at its curved shape at rest has no force, and resists being flattened") {
  const Triangles lattice(4, 0.2);
  const auto shape = [](const Vector3& p) { return wound(p, 0.1); };
  Plate plate(lattice, shape);
  CHECK(plate.energy(shape) == 0.0);
  CHECK(plate.greatest_force() == 0.0);
  // Turned and moved, it has none but of rounding.
  std::mt19937 random(1);
  const Matrix3 rotation = random_rotation(random);
  plate.energy([&](const Vector3& p) { return Vector3(rotation * shape(p) + Vector3(3.0, 1.0, 2.0)); });
  CHECK(plate.greatest_force() < 1e-13 * rigidity());
  const double flat = plate.energy([](const Vector3& p) { return p; });
  CHECK(flat == doctest::Approx(0.5 * rigidity() * 0.01).epsilon(0.01));
}
