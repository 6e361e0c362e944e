// Viscous laws: what they dissipate, and that they do not resist rotation; all laws conserve momentum.
#include <cmath>

#include <doctest/doctest.h>

#include "../layers/random_net.hpp"
#include "laws.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

template <std::size_t N>
void set_affine(EvaluatorFixture& fixture, const SimplexMesh<N>& mesh, const Matrix3& f, const Matrix3& rate) {
  for (std::size_t k = 0; k < mesh.points.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      fixture.p[c][k] = (f * mesh.points[k])[static_cast<Eigen::Index>(c)];
      fixture.v[c][k] = (rate * mesh.points[k])[static_cast<Eigen::Index>(c)];
    }
  fixture.evaluate();
}
Vector3 at(const std::vector<double> (&arrays)[3], std::size_t k) { return {arrays[0][k], arrays[1][k], arrays[2][k]}; }

// Power that the forces take from the motion, W.
double lost(const EvaluatorFixture& fixture) {
  double sum = 0.0;
  for (std::size_t k = 0; k < fixture.mass.size(); ++k) sum -= at(fixture.f, k).dot(at(fixture.v, k));
  return sum;
}
template <std::size_t N>
double greatest_error(const EvaluatorFixture& fixture, const SimplexMesh<N>& mesh, const Matrix3& stress) {
  const std::vector<Vector3> areas = mesh.boundary_areas();
  double error = 0.0, greatest = 0.0;
  for (std::size_t k = 0; k < mesh.points.size(); ++k) {
    const Vector3 expected = mesh.inside[k] ? Vector3(Vector3::Zero()) : Vector3(-stress * areas[k]);
    error = std::max(error, (at(fixture.f, k) - expected).norm());
    greatest = std::max(greatest, expected.norm());
  }
  return error / greatest;
}

// Some rounding errors of the sums over a mesh.
constexpr double rounding_of_sums = 2e-13;

}  // namespace

TEST_CASE("a viscous solid has the stress F S, S = 2 eta E' + (zeta - 2/3 eta) tr E', and dissipates S : E'") {
  const SimplexMesh<4> mesh = solid_mesh(3, {1.0, 1.2, 0.8}, 1);
  std::mt19937 random(1);
  for (const auto& [shear, bulk] : {std::pair(2.0, 0.0), std::pair(0.0, 1.5), std::pair(0.7, 3.0)}) {
    EvaluatorFixture fixture(element_net(mesh, {std::nullopt, viscous_solid_law(shear, bulk)}, Vector3::Zero(),
                                         random_rotation(random), random_vector(random)),
                             InstructionSet::best, 1, false);
    fixture.external.gravity.setZero();
    for (int i = 0; i < 20; ++i) {
      const Matrix3 f = random_matrix(random), rate = random_matrix(random);
      const Matrix3 strain_rate = 0.5 * (rate.transpose() * f + f.transpose() * rate);
      const Matrix3 stress =
          2.0 * shear * strain_rate + (bulk - 2.0 / 3.0 * shear) * strain_rate.trace() * Matrix3::Identity();
      set_affine(fixture, mesh, f, rate);
      CHECK(greatest_error(fixture, mesh, f * stress) < rounding_of_sums);
      const double power = (stress.transpose() * strain_rate).trace() * mesh.size();
      CHECK(lost(fixture) == doctest::Approx(power).epsilon(1e-12));
      CHECK(lost(fixture) >= 0.0);
    }
  }
}

TEST_CASE("a viscous membrane has the tensions F S, S = 2 eta E' + (zeta - eta) tr E', and dissipates S : E'") {
  const SimplexMesh<3> mesh = sheet_mesh(4, 1.0, 1.3, 1);
  std::mt19937 random(2);
  for (const auto& [shear, area] : {std::pair(2.0, 0.0), std::pair(0.0, 1.5), std::pair(0.7, 3.0)}) {
    EvaluatorFixture fixture(element_net(mesh, {std::nullopt, viscous_membrane_law(shear, area)}, Vector3::Zero(),
                                         random_rotation(random), random_vector(random)),
                             InstructionSet::best, 1, false);
    fixture.external.gravity.setZero();
    for (int i = 0; i < 20; ++i) {
      const Matrix3 f = random_matrix(random), rate = random_matrix(random);
      const Eigen::Matrix2d strain_rate = 0.5 * (rate.transpose() * f + f.transpose() * rate).topLeftCorner<2, 2>();
      const Eigen::Matrix2d stress =
          2.0 * shear * strain_rate + (area - shear) * strain_rate.trace() * Eigen::Matrix2d::Identity();
      Matrix3 piola = Matrix3::Zero();
      piola.leftCols<2>() = f.leftCols<2>() * stress;
      set_affine(fixture, mesh, f, rate);
      CHECK(greatest_error(fixture, mesh, piola) < rounding_of_sums);
      const double power = (stress * strain_rate).trace() * mesh.size();
      CHECK(lost(fixture) == doctest::Approx(power).epsilon(1e-12));
      CHECK(lost(fixture) >= 0.0);
    }
  }
}

TEST_CASE("viscous laws do not resist a rigid motion") {
  const SimplexMesh<4> solid = solid_mesh(2, {1.0, 1.2, 0.8}, 1);
  const SimplexMesh<3> sheet = sheet_mesh(3, 1.0, 1.3, 1);
  std::mt19937 random(3);
  const auto check = [&](const auto& mesh, const LawUse& law) {
    EvaluatorFixture fixture(element_net(mesh, {std::nullopt, law}), InstructionSet::best, 1, false);
    fixture.external.gravity.setZero();
    for (int i = 0; i < 10; ++i) {
      const Matrix3 f = random_matrix(random);
      const Vector3 turning = random_vector(random), moving = random_vector(random);
      set_affine(fixture, mesh, f, Matrix3::Zero());
      for (std::size_t k = 0; k < mesh.points.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c)
          fixture.v[c][k] = (turning.cross(at(fixture.p, k)) + moving)[static_cast<Eigen::Index>(c)];
      fixture.evaluate();
      // Viscosities, speeds and lengths of order 1.
      for (std::size_t k = 0; k < mesh.points.size(); ++k) CHECK(at(fixture.f, k).norm() < 1e-13);
    }
  };
  check(solid, viscous_solid_law(1.0, 0.5));
  check(sheet, viscous_membrane_law(1.0, 0.5));
}

TEST_CASE("all laws conserve momentum and angular momentum, in any motion") {
  std::mt19937 random(4);
  const NeoHookean matrix{2.0, 0.4};
  const std::vector<Material> solids{
      {solid_law(2.0, 0.4), viscous_solid_law(0.5, 0.2)},
      {fibre_solid_law(matrix, {3.0, 0.1, true, Vector3::UnitX()}), viscous_solid_law(0.5, 0.2)}};
  const std::vector<Material> sheets{{membrane_law(2.0, 0.4, 0.5), viscous_membrane_law(0.5, 0.2)},
                                     {membrane_law(2.0, 0.4, 0.5, false), std::nullopt}};
  const auto check = [&](const Network& net) {
    EvaluatorFixture fixture(net, InstructionSet::best, 1, false);
    fixture.external.gravity.setZero();
    for (int i = 0; i < 5; ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < fixture.mass.size(); ++k) {
          fixture.p[c][k] = random_unit(random);
          fixture.v[c][k] = random_unit(random);
        }
      fixture.evaluate();
      Vector3 force = Vector3::Zero(), torque = Vector3::Zero();
      double greatest = 0.0;
      for (std::size_t k = 0; k < fixture.mass.size(); ++k) {
        force += at(fixture.f, k);
        torque += at(fixture.p, k).cross(at(fixture.f, k));
        greatest += at(fixture.f, k).norm();
      }
      CHECK(greatest > 0.0);
      CHECK(force.norm() < 1e-13 * greatest);
      CHECK(torque.norm() < 1e-13 * greatest);
    }
  };
  for (const Material& material : solids)
    check(element_net(solid_mesh(2, Vector3::Ones(), 1), material, Vector3(1.0, 2.0, 3.0)));
  const SimplexMesh<3> sheet = sheet_mesh(3, 1.0, 1.0, 1);
  for (const Material& material : sheets) {
    Network net = element_net(sheet, material);
    const MaterialIndex shell = net.add_material({shell_law(2.0, 0.4, 0.5), std::nullopt});
    for (const auto& hinge : hinges_of(sheet)) net.add_element(Invariant::hinge, {hinge.begin(), hinge.end()}, shell);
    check(net);
  }
}
