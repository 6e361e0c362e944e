// Forces of a network and residuals of its steps by the formulas of the laws, spring by spring, without any of the
// library's evaluation.
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <Eigen/Dense>
#include <springnet/network.hpp>

namespace springnet::testing {

struct PlainState {
  std::vector<Vector3> position;  // m
  std::vector<Vector3> velocity;  // m/s
};

inline double plain_tension(const LawUse& law, double length, double rest_length) {
  const auto p = [&](const char* name) { return law.parameters.at(name); };
  const double x = length - rest_length;
  if (law.id == "linear" || law.id == "rupturing") return p("stiffness") * x;
  if (law.id == "nonlinear") return p("stiffness") * x + p("cubic") * x * x * x;
  if (law.id == "exponential") {
    return p("stiffness") * rest_length / p("exponent") * std::expm1(p("exponent") * x / rest_length);
  }
  throw std::logic_error("no formula for " + law.id);
}

// Force on the first end, N.
inline Vector3 plain_viscosity(const LawUse& law, const Vector3& direction, const Vector3& relative_velocity) {
  const double d = law.parameters.at("damping");
  const double rate = direction.dot(relative_velocity);
  if (law.id == "linear") return -d * rate * direction;
  if (law.id == "relative") return -d * relative_velocity;
  if (law.id == "power") {
    const double n = law.parameters.at("exponent"), below = law.parameters.at("linear_below");
    const double size = std::abs(rate);
    const double force = n < 1.0 && size < below ? d * std::pow(below, n - 1.0) * size : d * std::pow(size, n);
    return -std::copysign(force, rate) * direction;
  }
  throw std::logic_error("no formula for " + law.id);
}

// Net forces of springs, loads (those that act for ever), gravity and the neurons' drag, N.
inline std::vector<Vector3> plain_forces(const Network& network, const PlainState& at, const std::vector<bool>& alive) {
  std::vector<Vector3> forces(network.nodes().size());
  for (std::size_t k = 0; k < forces.size(); ++k) {
    const Node& node = network.nodes()[k];
    forces[k] = node.mass * network.gravity();
    const LawUse& neuron = network.neurons()[node.neuron];
    if (neuron.id == "dragged") forces[k] -= neuron.parameters.at("drag") * at.velocity[k];
  }
  for (const Load& load : network.loads()) {
    for (const NodeIndex node : load.nodes) forces[node] += load.force;
  }
  for (std::size_t s = 0; s < network.springs().size(); ++s) {
    if (!alive[s]) continue;
    const Spring& spring = network.springs()[s];
    const Vector3 difference = at.position[spring.first] - at.position[spring.second];
    const double length = difference.norm();
    const Vector3 direction = length > 0.0 ? Vector3(difference / length) : Vector3(Vector3::Zero());
    const Material& material = network.materials()[spring.material];
    Vector3 force = Vector3::Zero();
    if (material.spring) force -= plain_tension(*material.spring, length, spring.rest_length) * direction;
    if (material.viscosity) {
      force += plain_viscosity(*material.viscosity, direction, at.velocity[spring.first] - at.velocity[spring.second]);
    }
    forces[spring.first] += force;
    forces[spring.second] -= force;
  }
  return forces;
}

// What is left of residuals (forces on nodes, N) when rigid connections take what they can: the smallest in the sum of
// squares, with one tension a connection at the positions where the step ended. Fixed nodes count for nothing.
inline std::vector<Vector3> without_tensions(const Network& network, const PlainState& at,
                                             const std::vector<bool>& counts, std::vector<Vector3> residual) {
  const auto rows = static_cast<Eigen::Index>(3 * residual.size());
  const auto columns = static_cast<Eigen::Index>(network.rigids().size());
  if (columns == 0) return residual;
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(rows, columns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(rows);
  for (Eigen::Index r = 0; r < columns; ++r) {
    const Rigid& rigid = network.rigids()[static_cast<std::size_t>(r)];
    const Vector3 direction = (at.position[rigid.first] - at.position[rigid.second]).normalized();
    if (counts[rigid.first]) directions.block<3, 1>(3 * static_cast<Eigen::Index>(rigid.first), r) = direction;
    if (counts[rigid.second]) directions.block<3, 1>(3 * static_cast<Eigen::Index>(rigid.second), r) = -direction;
  }
  for (std::size_t k = 0; k < residual.size(); ++k) {
    if (counts[k]) right.segment<3>(3 * static_cast<Eigen::Index>(k)) = residual[k];
  }
  right -= directions * Eigen::VectorXd(directions.completeOrthogonalDecomposition().solve(right));
  for (std::size_t k = 0; k < residual.size(); ++k) {
    if (counts[k]) residual[k] = right.segment<3>(3 * static_cast<Eigen::Index>(k));
  }
  return residual;
}

}  // namespace springnet::testing
