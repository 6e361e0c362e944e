// Forces of a network and steps of its internal states by the formulas of the laws, spring by spring and element by
// element, without any of the library's evaluation.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include <Eigen/Dense>
#include <springnet/network.hpp>
#include <springnet/sdk/dual.hpp>

#include "plain_continuum.hpp"
#include "plain_memory.hpp"

namespace springnet::testing {

struct PlainState {
  std::vector<Vector3> position;  // m
  std::vector<Vector3> velocity;  // m/s
  // Internal state of each spring's and element's spring function, 0 where it has none; empty: all are 0.
  std::vector<double> spring_memory{}, element_memory{};
};

inline double plain_tension(const LawUse& law, double length, double rest_length, double memory = 0.0) {
  const auto p = [&](const char* name) { return law.parameters.at(name); };
  const double x = length - rest_length;
  if (has_memory(law)) return plain_tension_with_memory(law, x, memory);
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

// The invariant of three or four points as a formula of its value alone; its gradient comes from dual numbers.
template <class T>
T plain_value(Invariant invariant, const std::array<std::array<T, 3>, 4>& p) {
  using sdk::atan2, sdk::sqrt;
  using Triple = std::array<T, 3>;
  const auto minus = [](const Triple& a, const Triple& b) { return Triple{a[0] - b[0], a[1] - b[1], a[2] - b[2]}; };
  const auto dot = [](const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const auto cross = [](const Triple& a, const Triple& b) {
    return Triple{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const Triple u = minus(p[1], p[0]), w = minus(p[2], p[0]);
  if (invariant == Invariant::angle) {
    const Triple back = minus(p[2], p[1]), n = cross(u, back);
    return atan2(sqrt(dot(n, n)), -dot(u, back));
  }
  const Triple normal = cross(u, w);
  if (invariant == Invariant::area) return 0.5 * sqrt(dot(normal, normal));
  const Triple d = minus(p[3], p[0]);
  if (invariant == Invariant::volume) return dot(normal, d) / 6.0;
  // The second tip relative to the plane of the first triangle (positive below it), and its distance beyond the edge.
  const T below = -dot(normal, d) / sqrt(dot(normal, normal));
  const Triple inward = cross(normal, u);
  return atan2(below, -dot(inward, d) / sqrt(dot(inward, inward)));
}

// q, q' and dq/dp for each node of an element, in its order.
struct PlainInvariant {
  double value = 0.0, rate = 0.0;
  std::vector<Vector3> gradient;
};
inline PlainInvariant plain_invariant_of(const Element& element, const PlainState& at) {
  PlainInvariant found;
  found.gradient.assign(element.nodes.size(), Vector3::Zero());
  if (element.invariant == Invariant::enclosed_volume) {
    // Triangle by triangle: a . (b x c) / 6 from one of the nodes.
    const Vector3 origin = at.position[element.nodes[0]];
    for (std::size_t t = 0; t < element.nodes.size(); t += 3)
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3 a = at.position[element.nodes[t + k]] - origin;
        const Vector3 b = at.position[element.nodes[t + (k + 1) % 3]] - origin;
        const Vector3 c = at.position[element.nodes[t + (k + 2) % 3]] - origin;
        found.gradient[t + k] = b.cross(c) / 6.0;
        found.value += a.dot(found.gradient[t + k]) / 3.0;
      }
  } else {
    std::array<std::array<sdk::Dual<12>, 3>, 4> p;
    for (std::size_t i = 0; i < element.nodes.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        p[i][c] = sdk::Dual<12>::variable(at.position[element.nodes[i]][static_cast<Eigen::Index>(c)], 3 * i + c);
    const sdk::Dual<12> q = plain_value(element.invariant, p);
    found.value = q.value;
    // The branch nearest to the reference.
    if (element.invariant == Invariant::dihedral)
      found.value = element.reference + std::remainder(q.value - element.reference, 2.0 * std::numbers::pi);
    for (std::size_t i = 0; i < element.nodes.size(); ++i)
      found.gradient[i] = {q.derivatives[3 * i], q.derivatives[3 * i + 1], q.derivatives[3 * i + 2]};
  }
  for (std::size_t i = 0; i < element.nodes.size(); ++i)
    found.rate += found.gradient[i].dot(at.velocity[element.nodes[i]]);
  return found;
}

// Of an element whose laws read several scalars.
inline void add_continuum_forces(const Network& network, const Element& element, const PlainState& at,
                                 std::vector<Vector3>& forces) {
  const Material& material = network.materials()[element.material];
  if (element.invariant == Invariant::hinge) {
    // The angle of the nodes at rest, and its branch that is nearest to it.
    Element dihedral{Invariant::dihedral, {0, 1, 2, 3}, element.material, 0.0};
    dihedral.reference = plain_invariant_of(dihedral, {element.rest, std::vector<Vector3>(4, Vector3::Zero())}).value;
    dihedral.nodes = element.nodes;
    const PlainInvariant angle = plain_invariant_of(dihedral, at);
    const double torque = plain_hinge_stiffness(*material.spring, element.rest) * (angle.value - dihedral.reference);
    for (std::size_t i = 0; i < 4; ++i) forces[element.nodes[i]] -= torque * angle.gradient[i];
    return;
  }
  std::vector<Vector3> position, velocity;
  for (const NodeIndex node : element.nodes) {
    position.push_back(at.position[node]);
    velocity.push_back(at.velocity[node]);
  }
  const std::vector<Vector3> own = plain_simplex_forces(material, element, position, velocity);
  for (std::size_t i = 0; i < own.size(); ++i) forces[element.nodes[i]] += own[i];
}

// Internal states at the end of a step of a length h (s) from those of `start`, by positions at both ends: `order` 1 is
// backward Euler, 2 the method for theta below 1 and for integrators of second order.
inline void advance_memory(const Network& network, const PlainState& start, PlainState& end, double h, int order) {
  end.spring_memory.assign(network.springs().size(), 0.0);
  end.element_memory.assign(network.elements().size(), 0.0);
  for (std::size_t s = 0; s < network.springs().size(); ++s) {
    const Spring& spring = network.springs()[s];
    const std::optional<LawUse>& law = network.materials()[spring.material].spring;
    if (!law || !has_memory(*law)) continue;
    const auto stretch = [&](const PlainState& at) {
      return (at.position[spring.first] - at.position[spring.second]).norm() - spring.rest_length;
    };
    end.spring_memory[s] =
        plain_next(*law, order, h, stretch(start), stretch(end), spring.rest_length, start.spring_memory[s]);
  }
  for (std::size_t e = 0; e < network.elements().size(); ++e) {
    const Element& element = network.elements()[e];
    const std::optional<LawUse>& law = network.materials()[element.material].spring;
    if (!law || !has_memory(*law)) continue;
    const double before = plain_invariant_of(element, start).value - element.reference;
    const double after = plain_invariant_of(element, end).value - element.reference;
    end.element_memory[e] = plain_next(*law, order, h, before, after, element.reference, start.element_memory[e]);
  }
}

// Net forces of springs, elements, loads without a time window, gravity and the neurons' drag, N.
inline std::vector<Vector3> plain_forces(const Network& network, const PlainState& at, const std::vector<bool>& alive,
                                         const std::vector<bool>& elements_alive) {
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
    const double memory = at.spring_memory.empty() ? 0.0 : at.spring_memory[s];
    if (material.spring) force -= plain_tension(*material.spring, length, spring.rest_length, memory) * direction;
    if (material.viscosity) {
      force += plain_viscosity(*material.viscosity, direction, at.velocity[spring.first] - at.velocity[spring.second]);
    }
    forces[spring.first] += force;
    forces[spring.second] -= force;
  }
  for (std::size_t e = 0; e < network.elements().size(); ++e) {
    if (!elements_alive[e]) continue;
    const Element& element = network.elements()[e];
    const Material& material = network.materials()[element.material];
    if (reads_several(element.invariant)) {
      add_continuum_forces(network, element, at, forces);
      continue;
    }
    const PlainInvariant found = plain_invariant_of(element, at);
    const double memory = at.element_memory.empty() ? 0.0 : at.element_memory[e];
    double force = 0.0;
    if (material.spring) force += plain_tension(*material.spring, found.value, element.reference, memory);
    if (material.viscosity) {
      // In one dimension: the force along x on the first of two ends that separate at this rate.
      force -= plain_viscosity(*material.viscosity, Vector3::UnitX(), found.rate * Vector3::UnitX()).x();
    }
    for (std::size_t i = 0; i < element.nodes.size(); ++i) forces[element.nodes[i]] -= force * found.gradient[i];
  }
  return forces;
}

// Residuals (forces on nodes, N) less the forces of rigid connections: the smallest sum of squares with one tension per
// connection, at the positions at the end of the step. Nodes that do not count are ignored.
inline std::vector<Vector3> without_tensions(const Network& network, const PlainState& at,
                                             const std::vector<bool>& counts, std::vector<Vector3> residual) {
  const auto rows = static_cast<Eigen::Index>(3 * residual.size());
  const auto columns = static_cast<Eigen::Index>(network.rigids().size());
  if (columns == 0) return residual;
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(rows, columns);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(rows);
  for (Eigen::Index r = 0; r < columns; ++r) {
    const Rigid& rigid = network.rigids()[static_cast<std::size_t>(r)];
    const Vector3 direction = (at.position[rigid.first] - at.position[rigid.second]).normalized();
    if (counts[rigid.first]) directions.block<3, 1>(3 * static_cast<Eigen::Index>(rigid.first), r) = direction;
    if (counts[rigid.second]) directions.block<3, 1>(3 * static_cast<Eigen::Index>(rigid.second), r) = -direction;
  }
  for (std::size_t k = 0; k < residual.size(); ++k) {
    if (counts[k]) rhs.segment<3>(3 * static_cast<Eigen::Index>(k)) = residual[k];
  }
  rhs -= directions * Eigen::VectorXd(directions.completeOrthogonalDecomposition().solve(rhs));
  for (std::size_t k = 0; k < residual.size(); ++k) {
    if (counts[k]) residual[k] = rhs.segment<3>(3 * static_cast<Eigen::Index>(k));
  }
  return residual;
}

}  // namespace springnet::testing
