// The springs of several nodes that are evaluated at one state: forces on these nodes, with one call of a law for all.

#include <algorithm>

#include "layers/evaluator.hpp"
#include "layers/law_pair.hpp"
#include "layers/springs/node_sum.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

// Springs of one call: what is touched of their arrays fits the first-level cache.
constexpr std::size_t capacity = 256;
static_assert(capacity % node_chunk == 0);

// Springs of one group seen from nodes of a list, those of a node side by side.
struct Springs {
  struct Piece {
    std::size_t node;  // index in the list
    std::size_t begin, end;
  };
  std::uint32_t first[capacity], second[capacity], row[capacity];
  Piece piece[together_limit];
  std::size_t count = 0, pieces = 0;
  bool mixed = false;

  void clear() noexcept {
    count = pieces = 0;
    mixed = false;
  }
  // The first `size` springs from `from` on, of a node of the list.
  void append(std::size_t index, std::uint32_t node_number, const Incident* from, std::size_t size) noexcept {
    std::uint32_t differs = 0;
    if (count == 0) row[0] = from->row;
    const std::uint32_t row_0 = row[0];
    for (std::size_t i = 0; i < size; ++i) {
      first[count + i] = node_number;
      second[count + i] = from[i].other;
      row[count + i] = from[i].row;
      differs |= from[i].row ^ row_0;
    }
    mixed = mixed || differs != 0;
    piece[pieces++] = {index, count, count + size};
    count += size;
  }
};

void subtract(const Springs& springs, const double* tension, const double* x, const double* y, const double* z,
              double* const force[3]) {
  for (std::size_t p = 0; p < springs.pieces; ++p) {
    const Springs::Piece& piece = springs.piece[p];
    subtract_springs(piece.begin, piece.end, tension, x, y, z, force[0][piece.node], force[1][piece.node],
                     force[2][piece.node]);
  }
}

springnet_status add(const Springs& springs, const Group& group, const Kernels& kernels, InstructionSet set,
                     double time, const NodeArrays& nodes, double* const force[3], springnet_message& message) {
  if (springs.count == 0) return SPRINGNET_OK;
  SegmentGeometry geometry;  // not initialised: written before it is read
  alignas(64) double tension[2][capacity];
  const SegmentSprings ends{nullptr, 0, 0, static_cast<std::uint32_t>(springs.count), springs.first, springs.second};
  const std::array<const Law*, 2> laws = group.laws();
  if (group.spring.reads_rate || group.viscosity.reads_rate)
    kernels.lengths_and_rates(ends, nodes, geometry);
  else if ((group.spring && !group.spring.relative) || (group.viscosity && !group.viscosity.relative))
    kernels.lengths(ends, nodes, geometry);
  if (group.spring.relative || group.viscosity.relative) kernels.relative_speeds(ends, nodes, geometry);
  const RowSelection rows = springs.mixed ? RowSelection{springs.row, 0} : RowSelection{nullptr, springs.row[0]};
  const LawBatch batch{group, springs.count, rows, geometry.length, geometry.rate, geometry.speed};
  const springnet_status status =
      evaluate_laws(batch, set, time, {LawOutputs{tension[0]}, LawOutputs{tension[1]}}, message);
  if (status != SPRINGNET_OK) return status;
  for (std::size_t k = 0; k < laws.size(); ++k) {
    if (!*laws[k]) continue;
    const bool relative = laws[k]->relative;
    subtract(springs, tension[k], relative ? geometry.sx : geometry.nx, relative ? geometry.sy : geometry.ny,
             relative ? geometry.sz : geometry.nz, force);
  }
  return SPRINGNET_OK;
}

}  // namespace

springnet_status Evaluator::add_springs_of(std::span<const std::uint32_t> list, double time, const NodeArrays& nodes,
                                           double* const force[3], springnet_message& message) const {
  const profile::Part part("springs");
  Springs springs;  // arrays not initialised: written before they are read
  const Incident* next[together_limit];
  for (std::size_t i = 0; i < list.size(); ++i) next[i] = layout_.incident_begin(list[i]);
  const std::vector<Group>& groups = layout_.laws().groups;
  for (std::uint32_t g = 0; g < groups.size(); ++g) {
    springs.clear();
    const auto evaluate = [&] {
      const springnet_status status = add(springs, groups[g], kernels_, set_, time, nodes, force, message);
      springs.clear();
      return status;
    };
    for (std::size_t i = 0; i < list.size();) {
      const Incident* end = layout_.incident_end(list[i]);
      if (groups.size() > 1) end = std::find_if(next[i], end, [g](const Incident& s) { return s.group != g; });
      const auto wanted = static_cast<std::size_t>(end - next[i]);
      if (springs.count > 0 && springs.count + wanted > capacity) {
        if (const springnet_status status = evaluate(); status != SPRINGNET_OK) return status;
      }
      // A node's springs are divided only if they do not fit at all.
      const std::size_t size = std::min(wanted, capacity);
      if (size > 0) springs.append(i, list[i], next[i], size);
      next[i] += size;
      if (size == wanted) ++i;
    }
    if (const springnet_status status = evaluate(); status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
