// The springs of a single node: forces on it, derivative blocks, energy.

#include <algorithm>
#include <cmath>
#include <limits>

#include "layers/node_sums.hpp"
#include "layers/springs/blocks.hpp"
#include "layers/springs/node_sum.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

// Geometry of springs of one node; the same formulas as the kernels'.
struct NodeGeometry {
  double length[node_chunk], rate[node_chunk], nx[node_chunk], ny[node_chunk], nz[node_chunk];
  double speed[node_chunk], sx[node_chunk], sy[node_chunk], sz[node_chunk];
  double vx[node_chunk], vy[node_chunk], vz[node_chunk];  // relative velocity, m/s
  std::uint32_t rows[node_chunk];
  std::uint32_t places[node_chunk];  // of internal states; written if there are any
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
      g.vx[i] = dv[0];
      g.vy[i] = dv[1];
      g.vz[i] = dv[2];
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

// The sum of SpringBlocks for laws that are axial, in components: with a = T / l,
//   K = sum n ((T' - a) n + T_u (dv - u n) / l)^T + a I,   D = sum T_u n n^T
void add_axial_blocks(const NodeGeometry& g, std::size_t count, const Group& group,
                      const PairAnswers<node_chunk>& answers, Block& stiffness, Block& damping) {
  double k[9] = {}, d[6] = {}, along = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = g.nx[i], y = g.ny[i], z = g.nz[i];
    const double inverse = g.length[i] > 0.0 ? 1.0 / g.length[i] : 0.0;
    const SpringForces forces = spring_forces(group, answers, i);
    const double by_rate = forces.by_rate, turn = by_rate * inverse, a = forces.tension * inverse;
    const double axial = forces.by_length - a - turn * g.rate[i];
    const double w[3] = {axial * x + turn * g.vx[i], axial * y + turn * g.vy[i], axial * z + turn * g.vz[i]};
    for (int c = 0; c < 3; ++c) {
      k[c] += x * w[c];
      k[3 + c] += y * w[c];
      k[6 + c] += z * w[c];
    }
    along += a;
    d[0] += by_rate * x * x;
    d[1] += by_rate * x * y;
    d[2] += by_rate * x * z;
    d[3] += by_rate * y * y;
    d[4] += by_rate * y * z;
    d[5] += by_rate * z * z;
  }
  stiffness += Eigen::Map<const Block>(k) + along * Block::Identity();
  Block sum;
  sum << d[0], d[1], d[2], d[1], d[3], d[4], d[2], d[4], d[5];
  damping += sum;
}

}  // namespace

springnet_status Evaluator::add_springs_of(std::uint32_t node, double time, const NodeArrays& nodes, NodeSums& sums,
                                           springnet_message& message) const {
  const profile::Part part("springs");
  const bool blocks = sums.stiffness != nullptr;
  NodeGeometry geometry;
  PairAnswers<node_chunk> answers;
  const PairOutputs out = answers.outputs(blocks, sums.energy != nullptr);
  const Incident* end = layout_.incident_end(node);
  for (const Incident* begin = layout_.incident_begin(node); begin != end;) {
    const Incident* stop = begin + 1;
    while (stop != end && stop->group == begin->group && static_cast<std::size_t>(stop - begin) < node_chunk) ++stop;
    const auto count = static_cast<std::size_t>(stop - begin);
    const Group& group = layout_.laws().groups[begin->group];
    const bool relative = group.spring.relative || group.viscosity.relative;
    const bool axial = (group.spring && !group.spring.relative) || (group.viscosity && !group.viscosity.relative);
    read(begin, count, node, nodes, axial || blocks, relative, geometry);
    const bool one_row = std::all_of(begin, stop, [&](const Incident& i) { return i.row == begin->row; });
    const RowSelection rows = one_row ? RowSelection{nullptr, begin->row} : RowSelection{geometry.rows, 0};
    if (layout_.internal().has(begin->group))
      for (std::size_t i = 0; i < count; ++i) geometry.places[i] = layout_.internal().of_spring(begin[i].spring);
    const LawBatch batch{group,
                         count,
                         rows,
                         geometry.length,
                         geometry.rate,
                         geometry.speed,
                         {layout_.internal(), begin->group, nodes, geometry.places},
                         nullptr,
                         {CalledMembers::Are::springs, static_cast<std::uint32_t>(count),
                          sizeof(Incident) / sizeof(std::uint32_t), &begin->spring}};
    const springnet_status status = evaluate_laws(batch, set_, time, out, message);
    if (status != SPRINGNET_OK) return status;
    const std::array<const Law*, 2> laws = group.laws();
    const NodeGeometry& g = geometry;
    const auto subtract = [&](const double* tension, const double* x, const double* y, const double* z) {
      subtract_springs(0, count, tension, x, y, z, sums.force[0], sums.force[1], sums.force[2]);
    };
    alignas(64) double tension[node_chunk];
    if (group.spring) std::copy_n(answers.force[0], count, tension);
    if (const double* const forces = sum_of_laws(group, false, tension, answers.force[1], count))
      subtract(forces, g.nx, g.ny, g.nz);
    if (const double* const forces = sum_of_laws(group, true, tension, answers.force[1], count))
      subtract(forces, g.sx, g.sy, g.sz);
    for (std::size_t k = 0; k < laws.size() && sums.energy != nullptr; ++k) {
      if (!*laws[k]) continue;
      for (std::size_t i = 0; i < count; ++i)
        *sums.energy += laws[k]->has_potential() ? answers.energy[k][i] : std::numeric_limits<double>::quiet_NaN();
    }
    if (blocks) {
      if (!relative) add_axial_blocks(geometry, count, group, answers, *sums.stiffness, *sums.damping);
      for (std::size_t i = 0; i < count && relative; ++i) {
        const SpringBlocks spring(spring_forces(group, answers, i), g.length[i], {g.nx[i], g.ny[i], g.nz[i]}, g.rate[i],
                                  g.speed[i], {g.sx[i], g.sy[i], g.sz[i]});
        *sums.stiffness += spring.stiffness;
        *sums.damping += spring.damping;
      }
    }
    begin = stop;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
