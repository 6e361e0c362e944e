// Forces of tetrahedra, triangles and hinges by the deformation gradient F of continuum mechanics: on node i of a
// simplex -V0 P grad N_i, with the Piola-Kirchhoff stress P of F.
#pragma once

#include <array>
#include <stdexcept>
#include <vector>

#include <Eigen/Dense>
#include <springnet/network.hpp>

#include "../continuum/materials.hpp"

namespace springnet::testing {

inline double parameter_of(const LawUse& law, const char* name) {
  const auto found = law.parameters.find(name);
  return found == law.parameters.end() ? 0.0 : found->second;
}

// P of a tetrahedron, Pa; direction: of the material at rest.
inline Matrix3 plain_solid_stress(const Material& material, const Vector3& direction, const Matrix3& f,
                                  const Matrix3& rate) {
  Matrix3 stress = Matrix3::Zero();
  if (material.spring) {
    const LawUse& law = *material.spring;
    stress += NeoHookean{parameter_of(law, "youngs_modulus"), parameter_of(law, "poisson_ratio")}.stress(f);
    if (law.id == "fibre_solid") {
      const bool push = parameter_of(law, "fibres_push") != 0.0;
      stress +=
          Fibres{parameter_of(law, "fibre_modulus"), parameter_of(law, "fibre_stiffening"), push, direction}.stress(f);
    } else if (law.id != "solid") {
      throw std::logic_error("no formula for " + law.id);
    }
  }
  if (material.viscosity) {
    const LawUse& law = *material.viscosity;
    const double eta = parameter_of(law, "shear_viscosity"), zeta = parameter_of(law, "bulk_viscosity");
    const Matrix3 strain_rate = 0.5 * (f.transpose() * rate + rate.transpose() * f);
    stress += f * (2.0 * eta * strain_rate + (zeta - 2.0 / 3.0 * eta) * strain_rate.trace() * Matrix3::Identity());
  }
  return stress;
}

// Of a triangle, N/m; F in the axes of its plane at rest, the third column is not read.
inline Matrix3 plain_membrane_stress(const Material& material, const Matrix3& f, const Matrix3& rate) {
  Matrix3 stress = Matrix3::Zero();
  if (material.spring) {
    const LawUse& law = *material.spring;
    if (law.id != "membrane") throw std::logic_error("no formula for " + law.id);
    stress += PlaneStress{parameter_of(law, "youngs_modulus"), parameter_of(law, "poisson_ratio"),
                          parameter_of(law, "thickness"), parameter_of(law, "model") == 0.0}
                  .stress(f);
  }
  if (material.viscosity) {
    const LawUse& law = *material.viscosity;
    const double eta = parameter_of(law, "shear_viscosity"), zeta = parameter_of(law, "area_viscosity");
    const Eigen::Matrix<double, 3, 2> g = f.leftCols<2>(), of_time = rate.leftCols<2>();
    const Eigen::Matrix2d strain_rate = 0.5 * (g.transpose() * of_time + of_time.transpose() * g);
    stress.leftCols<2>() +=
        g * (2.0 * eta * strain_rate + (zeta - eta) * strain_rate.trace() * Eigen::Matrix2d::Identity());
  }
  return stress;
}

// A simplex at rest: the inverse of its edges from node 0 in the axes of the material, and its size.
struct PlainRest {
  Matrix3 inverse = Matrix3::Zero();  // of a triangle: the upper left 2x2
  Matrix3 axes = Matrix3::Identity();
  double size = 0.0;  // m^3, m^2

  explicit PlainRest(const std::vector<Vector3>& rest) {
    const Vector3 u = rest[1] - rest[0], v = rest[2] - rest[0];
    if (rest.size() == 4) {
      Matrix3 edges;
      edges << u, v, rest[3] - rest[0];
      inverse = edges.inverse();
      size = edges.determinant() / 6.0;
      return;
    }
    axes.col(0) = u.normalized();
    axes.col(2) = u.cross(v).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    Eigen::Matrix2d edges;
    edges << (axes.transpose() * u).head<2>(), (axes.transpose() * v).head<2>();
    inverse.topLeftCorner<2, 2>() = edges.inverse();
    size = 0.5 * edges.determinant();
  }
  // Gradient of a field with these values at the nodes; of a triangle, its third column is 0.
  [[nodiscard]] Matrix3 gradient(const std::vector<Vector3>& values) const {
    Matrix3 edges = Matrix3::Zero();
    for (std::size_t i = 1; i < values.size(); ++i) edges.col(static_cast<Eigen::Index>(i) - 1) = values[i] - values[0];
    return edges * inverse;
  }
};

// N, on each node.
inline std::vector<Vector3> plain_simplex_forces(const Material& material, const Element& element,
                                                 const std::vector<Vector3>& position,
                                                 const std::vector<Vector3>& velocity) {
  const PlainRest rest(element.rest);
  const Matrix3 f = rest.gradient(position), rate = rest.gradient(velocity);
  const Matrix3 stress = element.invariant == Invariant::tetrahedron
                             ? plain_solid_stress(material, element.direction, f, rate)
                             : plain_membrane_stress(material, f, rate);
  const Matrix3 by_node = -rest.size * stress * rest.inverse.transpose();
  std::vector<Vector3> forces(position.size(), Vector3::Zero());
  for (std::size_t i = 1; i < forces.size(); ++i) {
    forces[i] = by_node.col(static_cast<Eigen::Index>(i) - 1);
    forces[0] -= forces[i];
  }
  return forces;
}

// Torque per angle of a hinge, N m/rad: D l^2 / (A1 + A2).
inline double plain_hinge_stiffness(const LawUse& law, const std::vector<Vector3>& rest) {
  if (law.id != "shell") throw std::logic_error("no formula for " + law.id);
  const double t = parameter_of(law, "thickness"), nu = parameter_of(law, "poisson_ratio");
  const double rigidity = parameter_of(law, "youngs_modulus") * t * t * t / (12.0 * (1.0 - nu * nu));
  const Vector3 edge = rest[1] - rest[0];
  const double areas = 0.5 * (edge.cross(rest[2] - rest[0]).norm() + edge.cross(rest[3] - rest[0]).norm());
  return rigidity * edge.squaredNorm() / areas;
}

}  // namespace springnet::testing
