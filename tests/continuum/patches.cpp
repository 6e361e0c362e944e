// Patch tests: under an affine deformation forces inside vanish, those on the boundary are the stress times its areas,
// and the energy is that of the continuum, in irregular meshes.
#include <cmath>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "../layers/random_net.hpp"
#include "laws.hpp"
#include "layers/elements/queries.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr std::array poisson_ratios{-0.9, -0.5, 0.0, 0.3, 0.45, 0.49, 0.499};

// The fixture of a mesh at the affine positions F X.
template <std::size_t N>
struct Patch {
  Patch(const SimplexMesh<N>& of, const Network& net)
      : mesh(of), areas(of.boundary_areas()), size(of.size()), fixture(net, InstructionSet::best, 1, false) {
    fixture.external.gravity.setZero();
  }
  void deform(const Matrix3& f) {
    for (std::size_t k = 0; k < mesh.points.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c) fixture.p[c][k] = (f * mesh.points[k])[static_cast<Eigen::Index>(c)];
    fixture.evaluate();
  }
  [[nodiscard]] Vector3 force(std::size_t k) const { return {fixture.f[0][k], fixture.f[1][k], fixture.f[2][k]}; }
  [[nodiscard]] double energy() const {
    return layers::element_energy(fixture.layout, fixture.evaluator->instruction_set(), 0.0, fixture.nodes());
  }
  // Greatest difference of a node's force from that of the stress, over the greatest of these forces.
  [[nodiscard]] double error(const Matrix3& stress) const {
    double difference = 0.0, greatest = 0.0;
    for (std::size_t k = 0; k < mesh.points.size(); ++k) {
      const Vector3 expected = mesh.inside[k] ? Vector3(Vector3::Zero()) : Vector3(-stress * areas[k]);
      difference = std::max(difference, (force(k) - expected).norm());
      greatest = std::max(greatest, expected.norm());
    }
    return difference / greatest;
  }

  const SimplexMesh<N>& mesh;
  std::vector<Vector3> areas;
  double size;
  EvaluatorFixture fixture;
};

// Hooke's law for a small strain, Pa.
Matrix3 hooke(double modulus, double nu, const Matrix3& strain) {
  return modulus / (1.0 + nu) * (strain + nu / (1.0 - 2.0 * nu) * strain.trace() * Matrix3::Identity());
}

// Stress for a displacement gradient, by the difference of two small ones of opposite sign.
template <std::size_t N>
struct SmallStrain {
  double error;
  SmallStrain(Patch<N>& patch, const Matrix3& gradient, const Matrix3& stress) : error(0.0) {
    constexpr double small = 1e-5;
    std::vector<Vector3> force(patch.mesh.points.size(), Vector3::Zero());
    for (const double sign : {1.0, -1.0}) {
      patch.deform(Matrix3::Identity() + sign * small * gradient);
      for (std::size_t k = 0; k < force.size(); ++k) force[k] += sign * patch.force(k) / (2.0 * small);
    }
    double greatest = 0.0;
    for (std::size_t k = 0; k < force.size(); ++k) {
      const Vector3 expected = patch.mesh.inside[k] ? Vector3(Vector3::Zero()) : Vector3(-stress * patch.areas[k]);
      error = std::max(error, (force[k] - expected).norm());
      greatest = std::max(greatest, expected.norm());
    }
    error /= greatest;
  }
};

constexpr double rounding = 2e-13;

}  // namespace

TEST_CASE("solids pass the patch test, in any state, inside out too") {
  const SimplexMesh<4> mesh = solid_mesh(3, {1.0, 1.2, 0.8}, 1);
  std::mt19937 random(2);
  int inverted = 0;
  for (const double nu : poisson_ratios) {
    CAPTURE(nu);
    const NeoHookean material{3.0, nu};
    // The rest is told in other axes.
    Patch<4> patch(mesh, element_net(mesh, {solid_law(3.0, nu), std::nullopt}, Vector3::Zero(), random_rotation(random),
                                     random_vector(random)));
    for (int i = 0; i < 40; ++i) {
      const Matrix3 f = i % 2 == 0
                            ? Matrix3(random_matrix(random))
                            : Matrix3(random_rotation(random) * (Matrix3::Identity() + 0.3 * random_matrix(random)));
      inverted += f.determinant() < 0.0 ? 1 : 0;
      patch.deform(f);
      CHECK(patch.error(material.stress(f)) < rounding);
      const double scale = material.mu() * (f.squaredNorm() + 3.0) + material.kappa();
      CHECK(std::abs(patch.energy() - material.energy(f) * patch.size) < rounding * scale * patch.size);
    }
  }
  CHECK(inverted > 40);
}

TEST_CASE("solids with fibres pass the patch test") {
  const SimplexMesh<4> mesh = solid_mesh(3, {1.0, 1.2, 0.8}, 5);
  std::mt19937 random(3);
  for (const double nu : poisson_ratios) {
    for (const double stiffening : {0.0, 1e-9, 0.7}) {
      for (const bool push : {false, true}) {
        CAPTURE(nu);
        CAPTURE(stiffening);
        const NeoHookean matrix{3.0, nu};
        const Fibres fibres{5.0, stiffening, push, random_vector(random).normalized()};
        Patch<4> patch(mesh, element_net(mesh, {fibre_solid_law(matrix, fibres), std::nullopt}, 3.0 * fibres.along,
                                         random_rotation(random), random_vector(random)));
        for (int i = 0; i < 10; ++i) {
          const Matrix3 f =
              i % 2 == 0 ? Matrix3(random_matrix(random)) : Matrix3(Matrix3::Identity() + 0.3 * random_matrix(random));
          patch.deform(f);
          CHECK(patch.error(matrix.stress(f) + fibres.stress(f)) < rounding);
          const double expected = matrix.energy(f) + fibres.energy(f);
          const double scale = matrix.mu() * (f.squaredNorm() + 3.0) + matrix.kappa() + fibres.energy(f);
          CHECK(std::abs(patch.energy() - expected * patch.size) < rounding * scale * patch.size);
        }
      }
    }
  }
}

TEST_CASE("membranes pass the patch test, in space") {
  const SimplexMesh<3> mesh = sheet_mesh(4, 1.0, 1.3, 1);
  std::mt19937 random(4);
  for (const bool neo_hookean : {true, false}) {
    for (const double nu : poisson_ratios) {
      CAPTURE(neo_hookean);
      CAPTURE(nu);
      const PlaneStress material{3.0, nu, 0.2, neo_hookean};
      Patch<3> patch(mesh, element_net(mesh, {membrane_law(3.0, nu, 0.2, neo_hookean), std::nullopt}, Vector3::Zero(),
                                       random_rotation(random), random_vector(random)));
      for (int i = 0; i < 20; ++i) {
        Matrix3 f = Matrix3::Identity() + 0.3 * random_matrix(random);
        if (i % 2 == 0) f = random_matrix(random);
        patch.deform(f);
        // The stretch across is found to rounding, which kappa amplifies.
        const double amplified = neo_hookean ? std::max(1.0, 1.0 / (1.0 - 2.0 * nu)) : 1.0;
        CHECK(patch.error(material.stress(f)) < rounding * amplified);
        CHECK(patch.energy() == doctest::Approx(material.energy(f) * patch.size).epsilon(1e-11));
      }
    }
  }
}

TEST_CASE("for small strains solids and membranes are Hooke's, with the E and nu asked for") {
  const SimplexMesh<4> mesh = solid_mesh(2, {1.0, 1.0, 1.0}, 1);
  const SimplexMesh<3> sheet = sheet_mesh(3, 1.0, 1.0, 1);
  std::mt19937 random(6);
  for (const double nu : poisson_ratios) {
    CAPTURE(nu);
    const Matrix3 gradient = random_matrix(random), strain = 0.5 * (gradient + gradient.transpose());
    Patch<4> patch(mesh, element_net(mesh, {solid_law(3.0, nu), std::nullopt}));
    // Of second order in the strain of 1e-5, times (1 - 2 nu)^-1; rounding over it.
    CHECK(SmallStrain<4>(patch, gradient, hooke(3.0, nu, strain)).error < 1e-8);
    Matrix3 plane_stress = Matrix3::Zero();
    plane_stress.topLeftCorner<2, 2>() = 0.2 * 3.0 / (1.0 - nu * nu) *
                                         ((1.0 - nu) * strain.topLeftCorner<2, 2>() +
                                          nu * strain.topLeftCorner<2, 2>().trace() * Eigen::Matrix2d::Identity());
    for (const bool neo_hookean : {true, false}) {
      Patch<3> flat(sheet, element_net(sheet, {membrane_law(3.0, nu, 0.2, neo_hookean), std::nullopt}));
      CHECK(SmallStrain<3>(flat, gradient, plane_stress).error < 1e-8);
    }
  }
}

TEST_CASE("fibres make a solid transversely isotropic: stiffer along them by their modulus, the same about them") {
  const SimplexMesh<4> mesh = solid_mesh(2, {1.0, 1.0, 1.0}, 1);
  std::mt19937 random(7);
  const NeoHookean matrix{3.0, 0.3};
  const Fibres fibres{5.0, 0.8, true, random_vector(random).normalized()};
  Patch<4> patch(mesh, element_net(mesh, {fibre_solid_law(matrix, fibres), std::nullopt}, fibres.along));
  // Uniaxial stress along the fibres: the strain that the matrix would have with a modulus larger by that of the
  // fibres.
  const double modulus = matrix.modulus + fibres.modulus;
  const Matrix3 along = fibres.along * fibres.along.transpose();
  const Matrix3 strain = 1.0 / modulus * (along - matrix.nu * (Matrix3::Identity() - along));
  CHECK(SmallStrain<4>(patch, strain, along).error < 1e-8);
  // Across them the matrix alone resists, hindered by the fibres' own contraction.
  const Matrix3 rotation = Eigen::AngleAxisd(0.7, fibres.along).toRotationMatrix();
  const Matrix3 f = Matrix3::Identity() + 0.3 * random_matrix(random);
  patch.deform(f);
  const double energy = patch.energy();
  patch.deform(f * rotation);
  CHECK(patch.energy() == doctest::Approx(energy).epsilon(1e-13));
  CHECK(patch.error((matrix.stress(f) + fibres.stress(f)) * rotation) < rounding);
  // Fibres that do not push leave a matrix that is shortened along them.
  const Fibres slack{5.0, 0.8, false, fibres.along};
  Patch<4> other(mesh, element_net(mesh, {fibre_solid_law(matrix, slack), std::nullopt}, fibres.along));
  const Matrix3 shorter = Matrix3::Identity() - 0.2 * along;
  other.deform(shorter);
  CHECK(other.error(matrix.stress(shorter)) < rounding);
}

TEST_CASE("forces do not depend on units") {
  std::mt19937 random(8);
  for (const double unit : {1e-3, 1e-6, 1e3}) {
    CAPTURE(unit);
    const SimplexMesh<4> mesh = solid_mesh(2, Vector3(unit, unit, unit), 1);
    const SimplexMesh<3> sheet = sheet_mesh(3, unit, unit, 1);
    const Matrix3 f = random_matrix(random);
    const NeoHookean material{2e4, 0.45};
    Patch<4> patch(mesh, element_net(mesh, {solid_law(2e4, 0.45), std::nullopt}));
    patch.deform(f);
    CHECK(patch.error(material.stress(f)) < rounding);
    CHECK(patch.energy() == doctest::Approx(material.energy(f) * unit * unit * unit).epsilon(1e-12));
    const PlaneStress plane{2e4, 0.45, 0.1 * unit, true};
    Patch<3> flat(sheet, element_net(sheet, {membrane_law(2e4, 0.45, 0.1 * unit, true), std::nullopt}));
    flat.deform(f);
    CHECK(flat.error(plane.stress(f)) < rounding);
    CHECK(flat.energy() == doctest::Approx(plane.energy(f) * unit * unit).epsilon(1e-11));
  }
}

TEST_CASE("a tetrahedron whose nodes are mirrored at rest is refused; a triangle has no sides") {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)})
    net.add_node(point(p));
  const MaterialIndex index = net.add_material({solid_law(1.0, 0.3), std::nullopt});
  const MaterialIndex flat = net.add_material({membrane_law(1.0, 0.3, 0.1, true), std::nullopt});
  net.add_element(Invariant::triangle, {0, 2, 1}, flat);
  net.add_element(Invariant::triangle, {0, 1, 2}, flat);
  CHECK_NOTHROW(EvaluatorFixture fixture(net));
  net.add_element(Invariant::tetrahedron, {0, 2, 1, 3}, index);
  CHECK_THROWS_WITH_AS(EvaluatorFixture fixture(net), doctest::Contains("needs a volume above 0 at rest"), Error);
}
