#include "layers/springs/sweep_plan.hpp"

#include <algorithm>
#include <utility>

namespace springnet::layers {
namespace {

constexpr std::size_t no_value = static_cast<std::size_t>(-1);

}  // namespace

SweepPlan::SweepPlan(const Layout& layout, std::span<const std::uint32_t> order,
                     const std::function<bool(std::uint32_t)>& is_lone)
    : order_(order.begin(), order.end()), level_(layout.node_count()), stretch_(layout.node_count()) {
  nodes_.reserve(order.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    while (end < order.size() && is_lone(order[end])) ++end;
    add_stretch(layout, order.subspan(begin, end - begin));
    if (end < order.size()) {
      ranges_.push_back({nodes_.size(), batches_.size(), true});
      nodes_.push_back(order[end++]);
    }
    begin = end;
  }
  finish();
}

// A node's level is one more than the highest of the neighbours before it.
void SweepPlan::add_stretch(const Layout& layout, std::span<const std::uint32_t> nodes) {
  if (nodes.empty()) return;
  const std::vector<std::uint32_t>& start = layout.neighbour_start();
  const std::vector<std::uint32_t>& neighbours = layout.neighbours();
  ++stretches_;
  std::vector<std::size_t> place;  // [level] of its first node, among those sorted
  for (const std::uint32_t k : nodes) {
    std::uint32_t level = 0;
    for (std::uint32_t n = start[k]; n < start[k + 1]; ++n) {
      const std::uint32_t other = neighbours[n];
      if (stretch_[other] == stretches_) level = std::max(level, level_[other] + 1);
    }
    stretch_[k] = stretches_;
    level_[k] = level;
    if (level + 2 > place.size()) place.resize(level + 2, 0);
    ++place[level + 1];
  }
  for (std::size_t level = 1; level < place.size(); ++level) place[level] += place[level - 1];
  std::vector<std::size_t> next(place.begin(), place.end() - 1);
  std::vector<std::uint32_t> sorted(nodes.size());
  for (const std::uint32_t k : nodes) sorted[next[level_[k]]++] = k;
  // Nodes with equally many springs side by side: loops over springs of a node then end where the processor expects it.
  const auto springs = [&](std::uint32_t k) { return layout.incident_end(k) - layout.incident_begin(k); };
  for (std::size_t level = 0; level + 1 < place.size(); ++level) {
    const auto begin = sorted.begin();
    std::stable_sort(begin + static_cast<std::ptrdiff_t>(place[level]),
                     begin + static_cast<std::ptrdiff_t>(place[level + 1]),
                     [&](std::uint32_t a, std::uint32_t b) { return springs(a) < springs(b); });
    for (std::size_t at = place[level]; at < place[level + 1]; at += together_limit)
      add_stage(layout, std::span(sorted).subspan(at, std::min(together_limit, place[level + 1] - at)));
  }
}

void SweepPlan::add_stage(const Layout& layout, std::span<const std::uint32_t> nodes) {
  ranges_.push_back({nodes_.size(), batches_.size(), false});
  nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
  const std::vector<Group>& groups = layout.laws().groups;
  static_cast<void>(for_each_batch(layout, nodes, [&](const NodeSprings& springs) {
    add_batch(groups[springs.group], springs);
    return SPRINGNET_OK;
  }));
}

void SweepPlan::add_batch(const Group& group, const NodeSprings& springs) {
  const bool is_mixed = springs.rows.rows != nullptr;
  batches_.push_back(
      {springs.group, springs.rows.row, other_.size(), pieces_.size(), rows_.size(), value_of_.size(), is_mixed});
  other_.insert(other_.end(), springs.other.begin(), springs.other.end());
  pieces_.insert(pieces_.end(), springs.pieces.begin(), springs.pieces.end());
  if (!is_mixed) return;
  const std::span<const std::uint32_t> rows(springs.rows.rows, springs.other.size());
  rows_.insert(rows_.end(), rows.begin(), rows.end());
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    const bool same = c < group.same.size() && group.same[c] != 0;
    value_of_.push_back(same ? no_value : values_.size());
    if (same) continue;
    for (const std::uint32_t row : rows) values_.push_back(group.columns[c][row]);
  }
}

void SweepPlan::finish() {
  columns_.reserve(value_of_.size());
  for (const std::size_t at : value_of_) columns_.push_back(at == no_value ? nullptr : values_.data() + at);
  springs_.reserve(batches_.size());
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    const Batch& batch = batches_[b];
    const bool is_last = b + 1 == batches_.size();
    const std::size_t other_end = is_last ? other_.size() : batches_[b + 1].other;
    const std::size_t pieces_end = is_last ? pieces_.size() : batches_[b + 1].pieces;
    const RowSelection rows = batch.is_mixed
                                  ? RowSelection{rows_.data() + batch.rows, 0, columns_.data() + batch.columns}
                                  : RowSelection{nullptr, batch.row};
    springs_.push_back(
        {batch.group, std::span<const std::uint32_t>(other_).subspan(batch.other, other_end - batch.other),
         std::span<const NodeSprings::Piece>(pieces_).subspan(batch.pieces, pieces_end - batch.pieces), rows});
  }
  stages_.reserve(ranges_.size());
  for (std::size_t s = 0; s < ranges_.size(); ++s) {
    const Range& range = ranges_[s];
    const bool is_last = s + 1 == ranges_.size();
    const std::size_t nodes_end = is_last ? nodes_.size() : ranges_[s + 1].nodes;
    const std::size_t batches_end = is_last ? batches_.size() : ranges_[s + 1].batches;
    stages_.push_back({std::span<const std::uint32_t>(nodes_).subspan(range.nodes, nodes_end - range.nodes),
                       std::span<const NodeSprings>(springs_).subspan(range.batches, batches_end - range.batches),
                       range.by_itself});
  }
  // Needed no more.
  value_of_ = {};
  ranges_ = {};
  batches_ = {};
  level_ = {};
  stretch_ = {};
}

std::size_t SweepPlan::size() const noexcept {
  const auto bytes = [](const auto& values) { return values.size() * sizeof(values[0]); };
  return sizeof *this + bytes(order_) + bytes(nodes_) + bytes(stages_) + bytes(springs_) + bytes(other_) +
         bytes(rows_) + bytes(pieces_) + bytes(values_) + bytes(columns_);
}

}  // namespace springnet::layers
