// Evaluation of a single node, for update rules that read the newest outputs of its neighbours.

#include <limits>

#include "layers/node_sums.hpp"

namespace springnet::layers {
namespace {

Vector3 external_force(std::uint32_t node, double mass, const NodeArrays& nodes, const LoadedFaces& faces,
                       const ExternalForces& external) {
  Vector3 force = mass * external.gravity;
  if (external.loads.x != nullptr)
    force += Vector3(external.loads.x[node], external.loads.y[node], external.loads.z[node]);
  if (external.pressure != nullptr) force += faces.force(node, nodes, external.pressure);
  return force;
}

}  // namespace

void Evaluator::copy(std::span<const std::uint32_t> list, const NodeArrays& nodes, ListedNodes& out) const noexcept {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::uint32_t k = list[i];
    out.p[0][i] = nodes.px[k];
    out.p[1][i] = nodes.py[k];
    out.p[2][i] = nodes.pz[k];
    out.v[0][i] = nodes.vx[k];
    out.v[1][i] = nodes.vy[k];
    out.v[2][i] = nodes.vz[k];
    out.mass[i] = mass_[k];
  }
}

springnet_status Evaluator::evaluate_together(const NodeList& list, const ListedNodes& own, double time,
                                              const NodeArrays& nodes, const ExternalForces& external,
                                              const EnclosureVolumes* volumes, double* const force[3],
                                              springnet_message& message) const {
  const bool elements = layout_.elements().live_count() > 0;
  if (!elements && external.loads.x == nullptr && external.pressure == nullptr) {
    for (Eigen::Index c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < list.nodes.size(); ++i) force[c][i] = own.mass[i] * external.gravity[c];
    return add_springs_of(list, own, time, nodes, force, message);
  }
  for (std::size_t i = 0; i < list.nodes.size(); ++i) {
    const std::uint32_t k = list.nodes[i];
    Vector3 sum = external_force(k, own.mass[i], nodes, layout_.loaded_faces(), external);
    if (elements) {
      NodeSums sums{sum};
      const springnet_status status = add_elements_of(k, time, nodes, volumes, sums, message);
      if (status != SPRINGNET_OK) return status;
    }
    for (Eigen::Index c = 0; c < 3; ++c) force[c][i] = sum[c];
  }
  return add_springs_of(list, own, time, nodes, force, message);
}

springnet_status Evaluator::evaluate_node(std::uint32_t node, double time, const NodeArrays& nodes,
                                          const ExternalForces& external, const EnclosureVolumes* volumes,
                                          Vector3& force, springnet_message& message) const {
  ListedNodes own;  // not initialised: written before it is read
  copy({&node, 1}, nodes, own);
  double* const component[3] = {&force[0], &force[1], &force[2]};
  return evaluate_together({{&node, 1}}, own, time, nodes, external, volumes, component, message);
}

springnet_status Evaluator::evaluate_node(std::uint32_t node, double time, const NodeArrays& nodes,
                                          const ExternalForces& external, const EnclosureVolumes* volumes,
                                          Vector3& force, Vector3& acceleration, NodeDerivatives* derivatives,
                                          double* energy, springnet_message& message) const {
  if (derivatives == nullptr && energy == nullptr) {
    const springnet_status status = evaluate_node(node, time, nodes, external, volumes, force, message);
    double* const answer[3] = {&acceleration[0], &acceleration[1], &acceleration[2]};
    const double* const net[3] = {&force[0], &force[1], &force[2]};
    if (status != SPRINGNET_OK) return status;
    return accelerations(node, 1, time, nodes, net, answer, nullptr, nullptr, nullptr, message);
  }
  const NeuronKind& neuron = layout_.laws().neurons[layout_.neuron_kind()[node]];
  const bool differentiable = (neuron.component->description->capabilities & SPRINGNET_HAS_DERIVATIVES) != 0;
  if (derivatives != nullptr && require_derivatives(*neuron.component, message) != SPRINGNET_OK)
    return SPRINGNET_FAILED;
  const LoadedFaces& faces = layout_.loaded_faces();
  force = external_force(node, mass_[node], nodes, faces, external);
  if (energy != nullptr) {
    // Surrounded by faces under one pressure, the force does not depend on the node's position; at their rim it has no
    // potential.
    const bool potential = external.pressure == nullptr || faces.is_surrounded(node);
    *energy = potential ? -force.dot(Vector3(nodes.px[node], nodes.py[node], nodes.pz[node]))
                        : std::numeric_limits<double>::quiet_NaN();
  }
  Block stiffness = Block::Zero(), damping = Block::Zero();
  if (derivatives != nullptr && external.pressure != nullptr)
    stiffness = faces.stiffness(node, nodes, external.pressure);
  NodeSums sums{force, derivatives != nullptr ? &stiffness : nullptr, derivatives != nullptr ? &damping : nullptr,
                energy};
  springnet_status status = add_elements_of(node, time, nodes, volumes, sums, message);
  if (status == SPRINGNET_OK) status = add_springs_of(node, time, nodes, sums, message);
  if (status != SPRINGNET_OK) return status;

  Block by_force = Block::Zero(), by_position = Block::Zero(), by_velocity = Block::Zero();
  const bool blocks = differentiable && (derivatives != nullptr || energy != nullptr);
  const double* f[3] = {&force[0], &force[1], &force[2]};
  double* const a[3] = {&acceleration[0], &acceleration[1], &acceleration[2]};
  status = accelerations(node, 1, time, nodes, f, a, blocks ? by_force.data() : nullptr,
                         blocks ? by_position.data() : nullptr, blocks ? by_velocity.data() : nullptr, message);
  if (status != SPRINGNET_OK) return status;
  if (derivatives != nullptr) {
    Eigen::Map<Block>(derivatives->by_velocity) = by_velocity - by_force * damping;
    Eigen::Map<Block>(derivatives->by_position) = by_position - by_force * stiffness;
  }
  if (energy != nullptr) {
    const bool point_mass = differentiable && by_position.isZero(0.0) && by_velocity.isZero(0.0) &&
                            (mass_[node] * by_force).isIdentity(point_mass_rounding);
    if (!point_mass) *energy = std::numeric_limits<double>::quiet_NaN();
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
