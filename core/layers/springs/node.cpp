// The springs of a single node: forces on it, derivative blocks, energy.

#include <algorithm>
#include <cmath>
#include <limits>

#include "layers/node_sums.hpp"
#include "layers/springs/blocks.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

constexpr std::size_t chunk = 64;

// Geometry of springs of one node; the same formulas as the kernels'.
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

springnet_status Evaluator::add_springs_of(std::uint32_t node, double time, const NodeArrays& nodes, NodeSums& sums,
                                           springnet_message& message) const {
  const profile::Part part("springs");
  const bool blocks = sums.stiffness != nullptr;
  NodeGeometry geometry;
  PairAnswers<chunk> answers;
  const PairOutputs out = answers.outputs(blocks, sums.energy != nullptr);
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
    const LawBatch batch{group, count, rows, geometry.length, geometry.rate, geometry.speed};
    const springnet_status status = evaluate_laws(batch, set_, time, out, message);
    if (status != SPRINGNET_OK) return status;
    const std::array<const Law*, 2> laws = group.laws();
    for (std::size_t k = 0; k < laws.size(); ++k) {
      const Law& law = *laws[k];
      if (!law) continue;
      const double* x = law.relative ? geometry.sx : geometry.nx;
      const double* y = law.relative ? geometry.sy : geometry.ny;
      const double* z = law.relative ? geometry.sz : geometry.nz;
      for (std::size_t i = 0; i < count; ++i) sums.force -= answers.force[k][i] * Vector3(x[i], y[i], z[i]);
      if (sums.energy == nullptr) continue;
      for (std::size_t i = 0; i < count; ++i)
        *sums.energy += law.has_potential() ? answers.energy[k][i] : std::numeric_limits<double>::quiet_NaN();
    }
    if (blocks) {
      for (std::size_t i = 0; i < count; ++i) {
        const NodeGeometry& g = geometry;
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
