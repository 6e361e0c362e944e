// The springs of several nodes that are evaluated at one state: forces on these nodes, with one call of a law for all.

#include <algorithm>

#include "layers/evaluator.hpp"
#include "layers/law_pair.hpp"
#include "layers/springs/node_springs.hpp"
#include "layers/springs/node_sum.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

static_assert(together_springs % node_chunk == 0);

// Rows apart by a power of two would share a few places of the first-level cache.
constexpr std::size_t row_length = together_springs + 8;

// Differences from the other end of each spring to the node: of the first or last components of position and velocity.
// Loads by index cost less than a gather of vectors.
template <std::size_t first, std::size_t last>
void subtract_others(const NodeSprings& springs, const ListedNodes& listed, const NodeArrays& nodes,
                     double (*change)[row_length]) noexcept {
  const double* const values[6] = {nodes.px, nodes.py, nodes.pz, nodes.vx, nodes.vy, nodes.vz};
  const std::uint32_t* other = springs.other.data();
  for (const NodeSprings::Piece& piece : springs.pieces) {
    double own[6];
    for (std::size_t c = first; c < last; ++c) own[c] = c < 3 ? listed.p[c][piece.node] : listed.v[c - 3][piece.node];
    std::size_t i = piece.begin;
    for (; i + 1 < piece.end; i += 2) {
      const std::uint32_t one = other[i], two = other[i + 1];
      for (std::size_t c = first; c < last; ++c)
        store(Pair{own[c], own[c]} - Pair{values[c][one], values[c][two]}, change[c] + i);
    }
    if (i < piece.end)
      for (std::size_t c = first; c < last; ++c) change[c][i] = own[c] - values[c][other[i]];
  }
}

// Forces of springs along directions; no force: none.
struct Directed {
  const double* force = nullptr;
  const double *x, *y, *z;
};

// In the order in which springs of a single node are summed: so many at a time, the axial forces first.
void subtract(const NodeSprings& springs, const Directed& axial, const Directed& relative, double* const force[3]) {
  for (const NodeSprings::Piece& piece : springs.pieces) {
    for (std::size_t begin = piece.begin; begin < piece.end; begin += node_chunk) {
      const std::size_t end = std::min<std::size_t>(piece.end, begin + node_chunk);
      for (const Directed& part : {axial, relative})
        if (part.force != nullptr)
          subtract_springs(begin, end, part.force, part.x, part.y, part.z, force[0][piece.node], force[1][piece.node],
                           force[2][piece.node]);
    }
  }
}

}  // namespace

springnet_status Evaluator::add_springs(const NodeList& list, const NodeSprings& springs, const ListedNodes& own,
                                        double time, const NodeArrays& nodes, double* const force[3],
                                        springnet_message& message) const {
  const Group& group = layout_.laws().groups[springs.group];
  const std::size_t count = springs.other.size();
  // Not initialised: written before they are read.
  SegmentGeometry geometry;
  alignas(64) double change[6][row_length];
  alignas(64) double tension[2][row_length];
  const bool relative = group.spring.relative || group.viscosity.relative;
  const bool axial = (group.spring && !group.spring.relative) || (group.viscosity && !group.viscosity.relative);
  const bool rates = group.spring.reads_rate || group.viscosity.reads_rate;
  if (!rates && !relative)
    subtract_others<0, 3>(springs, own, nodes, change);
  else if (!axial)
    subtract_others<3, 6>(springs, own, nodes, change);
  else
    subtract_others<0, 6>(springs, own, nodes, change);
  const EndChanges changes{change[0], change[1], change[2], change[3], change[4], change[5]};
  if (rates)
    kernels_.lengths_and_rates_of(changes, count, geometry);
  else if (axial)
    kernels_.lengths_of(changes, count, geometry);
  if (relative) kernels_.relative_speeds_of(changes, count, geometry);
  // The springs' own numbers are not at hand.
  const std::uint32_t first = springs.pieces.front().node;
  const CalledMembers members{CalledMembers::Are::springs_of_nodes, springs.pieces.back().node - first + 1, 1,
                              list.nodes.data() + first, layout_.ordering().user.data()};
  const LawBatch batch{group,
                       count,
                       springs.rows,
                       geometry.length,
                       geometry.rate,
                       geometry.speed,
                       {layout_.internal(), springs.group, nodes, springs.places},
                       nullptr,
                       members};
  const springnet_status status =
      evaluate_laws(batch, set_, time, {LawOutputs{tension[0]}, LawOutputs{tension[1]}}, message);
  if (status != SPRINGNET_OK) return status;
  const SegmentGeometry& g = geometry;
  const Directed axial_forces{sum_of_laws(group, false, tension[0], tension[1], count), g.nx, g.ny, g.nz};
  const Directed relative_forces{sum_of_laws(group, true, tension[0], tension[1], count), g.sx, g.sy, g.sz};
  subtract(springs, axial_forces, relative_forces, force);
  return SPRINGNET_OK;
}

springnet_status Evaluator::add_springs_of(const NodeList& list, const ListedNodes& own, double time,
                                           const NodeArrays& nodes, double* const force[3],
                                           springnet_message& message) const {
  const profile::Part part("springs");
  const auto add = [&](const NodeSprings& springs) {
    return add_springs(list, springs, own, time, nodes, force, message);
  };
  if (list.springs.empty()) return for_each_batch(layout_, list.nodes, add);
  for (const NodeSprings& springs : list.springs)
    if (const springnet_status status = add(springs); status != SPRINGNET_OK) return status;
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
