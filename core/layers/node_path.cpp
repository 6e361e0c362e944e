// One node at a time: the wavefront reads the newest outputs of its neighbours.

#include <algorithm>
#include <cmath>
#include <limits>

#include "layers/node_sums.hpp"
#include "layers/spring_blocks.hpp"

namespace springnet::layers {
namespace {

constexpr std::size_t chunk = 64;
constexpr double rounding = 1e-12;  // of m times the derivative 1/m

Vector3 external_force(std::uint32_t node, double mass, const NodeArrays& nodes, const LoadedFaces& faces,
                       const ExternalForces& external) {
  Vector3 force = mass * external.gravity;
  if (external.loads.x != nullptr)
    force += Vector3(external.loads.x[node], external.loads.y[node], external.loads.z[node]);
  if (external.pressure != nullptr) force += faces.force(node, nodes, external.pressure);
  return force;
}

// Geometry of `count` springs of one node, as the kernels define it.
struct NodeGeometry {
  double length[chunk], rate[chunk], nx[chunk], ny[chunk], nz[chunk];
  double speed[chunk], sx[chunk], sy[chunk], sz[chunk];
  std::uint32_t rows[chunk];
};

void read(const Incident* springs, std::size_t count, std::uint32_t k, const NodeArrays& n, bool axial, bool relative,
          NodeGeometry& g) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t other = springs[i].other;
    g.rows[i] = springs[i].row;
    const Vector3 dv(n.vx[k] - n.vx[other], n.vy[k] - n.vy[other], n.vz[k] - n.vz[other]);
    if (axial) {
      const Vector3 dp(n.px[k] - n.px[other], n.py[k] - n.py[other], n.pz[k] - n.pz[other]);
      const double length = std::sqrt(dp[0] * dp[0] + dp[1] * dp[1] + dp[2] * dp[2]);
      const double inverse = 1.0 / (length > 0.0 ? length : 1.0);
      g.length[i] = length;
      g.nx[i] = dp[0] * inverse;
      g.ny[i] = dp[1] * inverse;
      g.nz[i] = dp[2] * inverse;
      g.rate[i] = g.nx[i] * dv[0] + g.ny[i] * dv[1] + g.nz[i] * dv[2];
    }
    if (relative) {
      const double speed = std::sqrt(dv[0] * dv[0] + dv[1] * dv[1] + dv[2] * dv[2]);
      const double inverse = 1.0 / (speed > 0.0 ? speed : 1.0);
      g.speed[i] = speed;
      g.sx[i] = dv[0] * inverse;
      g.sy[i] = dv[1] * inverse;
      g.sz[i] = dv[2] * inverse;
    }
  }
}

}  // namespace

springnet_status Evaluator::add_springs(std::uint32_t node, double time, const NodeArrays& nodes, NodeSums& sums,
                                        springnet_message& message) const {
  const bool blocks = sums.stiffness != nullptr;
  NodeGeometry geometry;
  SpringForces forces[chunk];  // not initialised: written before it is read
  double value[chunk], by_q[chunk], by_rate[chunk], energy[chunk];
  const Incident* end = layout_.incident_end(node);
  for (const Incident* begin = layout_.incident_begin(node); begin != end;) {
    const Incident* stop = begin + 1;
    while (stop != end && stop->group == begin->group && static_cast<std::size_t>(stop - begin) < chunk) ++stop;
    const auto count = static_cast<std::size_t>(stop - begin);
    const Group& group = layout_.laws().groups[begin->group];
    const bool relative = group.spring.relative || group.viscosity.relative;
    const bool axial = (group.spring && !group.spring.relative) || (group.viscosity && !group.viscosity.relative);
    read(begin, count, node, nodes, axial || blocks, relative || blocks, geometry);
    const bool one_row = std::all_of(begin, stop, [&](const Incident& i) { return i.row == begin->row; });
    const RowSelection rows = one_row ? RowSelection{nullptr, begin->row} : RowSelection{geometry.rows, 0};
    if (blocks) std::fill_n(forces, count, SpringForces{});
    for (const Law* law : {&group.spring, &group.viscosity}) {
      if (!*law) continue;
      LawOutputs out;
      out.force = value;
      if (blocks) {
        if (require_derivatives(*law->component, message) != SPRINGNET_OK) return SPRINGNET_FAILED;
        out.force_by_q = by_q;
        if (law->reads_rate) out.force_by_rate = by_rate;
      }
      const bool potential = law->can(SPRINGNET_HAS_ENERGY) && !law->reads_rate && !law->relative;
      if (sums.energy != nullptr && potential) out.energy = energy;
      const springnet_status status =
          call_law(group, *law, abi_number(set_), time, count, rows, law->relative ? geometry.speed : geometry.length,
                   geometry.rate, out, &message);
      if (status != SPRINGNET_OK) return status;
      const double* x = law->relative ? geometry.sx : geometry.nx;
      const double* y = law->relative ? geometry.sy : geometry.ny;
      const double* z = law->relative ? geometry.sz : geometry.nz;
      for (std::size_t i = 0; i < count; ++i) sums.force -= value[i] * Vector3(x[i], y[i], z[i]);
      if (blocks) {
        for (std::size_t i = 0; i < count; ++i) forces[i].add(*law, value[i], by_q[i], &by_rate[i]);
      }
      if (sums.energy != nullptr) {
        for (std::size_t i = 0; i < count; ++i)
          *sums.energy += potential ? energy[i] : std::numeric_limits<double>::quiet_NaN();
      }
    }
    if (blocks) {
      for (std::size_t i = 0; i < count; ++i) {
        const NodeGeometry& g = geometry;
        const SpringBlocks spring(forces[i], g.length[i], {g.nx[i], g.ny[i], g.nz[i]}, g.rate[i], g.speed[i],
                                  {g.sx[i], g.sy[i], g.sz[i]});
        *sums.stiffness += spring.stiffness;
        *sums.damping += spring.damping;
      }
    }
    begin = stop;
  }
  return SPRINGNET_OK;
}

springnet_status Evaluator::evaluate_node(std::uint32_t node, double time, const NodeArrays& nodes,
                                          const ExternalForces& external, const SurfaceVolumes* volumes, Vector3& force,
                                          springnet_message& message) const {
  force = external_force(node, mass_[node], nodes, layout_.loaded_faces(), external);
  NodeSums sums{force};
  if (const springnet_status status = add_elements_of(node, time, nodes, volumes, sums, message);
      status != SPRINGNET_OK)
    return status;
  return add_springs(node, time, nodes, sums, message);
}

springnet_status Evaluator::evaluate_node(std::uint32_t node, double time, const NodeArrays& nodes,
                                          const ExternalForces& external, const SurfaceVolumes* volumes, Vector3& force,
                                          Vector3& acceleration, NodeDerivatives* derivatives, double* energy,
                                          springnet_message& message) const {
  const NeuronKind& neuron = layout_.laws().neurons[layout_.neuron_kind()[node]];
  const bool differentiable = (neuron.component->description->capabilities & SPRINGNET_HAS_DERIVATIVES) != 0;
  if (derivatives != nullptr && require_derivatives(*neuron.component, message) != SPRINGNET_OK)
    return SPRINGNET_FAILED;
  const LoadedFaces& faces = layout_.loaded_faces();
  force = external_force(node, mass_[node], nodes, faces, external);
  if (energy != nullptr) {
    // Amid faces under one pressure the force does not depend on where the node is; at their edge it has no potential.
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
  if (status == SPRINGNET_OK) status = add_springs(node, time, nodes, sums, message);
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
                            (mass_[node] * by_force).isIdentity(rounding);
    if (!point_mass) *energy = std::numeric_limits<double>::quiet_NaN();
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
