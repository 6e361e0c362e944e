#include "layers/springs/sweep_plan.hpp"

#include <algorithm>
#include <tuple>

namespace springnet::layers {
namespace {

constexpr std::size_t no_value = static_cast<std::size_t>(-1);

bool is_same(const Group& group, std::size_t column) noexcept { return group.is_same(column); }

}  // namespace

SweepPlan::Sizes::Sizes(const Layout& layout) : nodes(layout.node_count()) {
  const std::vector<Group>& groups = layout.laws().groups;
  for (std::uint32_t k = 0; k < layout.node_count(); ++k) {
    for (const Incident* begin = layout.incident_begin(k); begin != layout.incident_end(k);) {
      const Incident* end = begin;
      while (end != layout.incident_end(k) && end->group == begin->group) ++end;
      const Group& group = groups[begin->group];
      const auto count = static_cast<std::size_t>(end - begin);
      std::size_t own = 0;
      for (std::size_t c = 0; c < group.columns.size(); ++c) own += is_same(group, c) ? 0 : 1;
      springs += count;
      pieces += (count + together_springs - 1) / together_springs;
      values += own * count;
      columns = std::max(columns, group.columns.size());
      begin = end;
    }
  }
  columns *= pieces;
}

std::size_t SweepPlan::Sizes::bytes() const noexcept {
  return nodes * (6 * sizeof(std::uint32_t) + 2 * sizeof(std::size_t) + sizeof(Stage) + sizeof(Range)) +
         springs * sizeof(std::uint32_t) + pieces * (sizeof(NodeSprings::Piece) + sizeof(NodeSprings) + sizeof(Batch)) +
         values * sizeof(double) + columns * (sizeof(std::size_t) + sizeof(double*));
}

SweepPlan::SweepPlan(const Sizes& sizes) : level_(sizes.nodes), stretch_(sizes.nodes), place_(sizes.nodes) {
  for (auto* of_nodes : {&order_, &nodes_, &sorted_}) of_nodes->reserve(sizes.nodes);
  for (auto* of_levels : {&level_begin_, &level_next_}) of_levels->reserve(sizes.nodes + 1);
  stages_.reserve(sizes.nodes);
  ranges_.reserve(sizes.nodes);
  other_.reserve(sizes.springs);
  pieces_.reserve(sizes.pieces);
  springs_.reserve(sizes.pieces);
  batches_.reserve(sizes.pieces);
  values_.reserve(sizes.values);
  value_of_.reserve(sizes.columns);
  columns_.reserve(sizes.columns);
}

void SweepPlan::make(const Layout& layout, std::span<const std::uint32_t> order, const IsLocal& is_local) {
  order_.assign(order.begin(), order.end());
  nodes_.clear();
  other_.clear();
  pieces_.clear();
  internal_.clear();
  values_.clear();
  value_of_.clear();
  ranges_.clear();
  batches_.clear();
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    while (end < order.size() && is_local(order[end])) ++end;
    add_stretch(layout, order.subspan(begin, end - begin));
    if (end < order.size()) {
      ranges_.push_back({nodes_.size(), batches_.size(), true});
      nodes_.push_back(order[end++]);
    }
    begin = end;
  }
  take_spans();
}

// A node's level is one more than the highest of the neighbours before it.
void SweepPlan::add_stretch(const Layout& layout, std::span<const std::uint32_t> nodes) {
  if (nodes.empty()) return;
  const std::vector<std::uint32_t>& start = layout.neighbour_start();
  const std::vector<std::uint32_t>& neighbours = layout.neighbours();
  if (++stretches_ == 0) {  // overflow
    std::fill(stretch_.begin(), stretch_.end(), 0u);
    stretches_ = 1;
  }
  std::vector<std::size_t>& begin = level_begin_;
  begin.assign(1, 0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::uint32_t k = nodes[i];
    std::uint32_t level = 0;
    for (std::uint32_t n = start[k]; n < start[k + 1]; ++n) {
      const std::uint32_t other = neighbours[n];
      if (stretch_[other] == stretches_) level = std::max(level, level_[other] + 1);
    }
    stretch_[k] = stretches_;
    level_[k] = level;
    place_[k] = static_cast<std::uint32_t>(i);
    if (level + 2 > begin.size()) begin.resize(level + 2, 0);
    ++begin[level + 1];
  }
  for (std::size_t level = 1; level < begin.size(); ++level) begin[level] += begin[level - 1];
  level_next_.assign(begin.begin(), begin.end());
  sorted_.resize(nodes.size());
  for (const std::uint32_t k : nodes) sorted_[level_next_[level_[k]]++] = k;
  // Nodes with equally many springs side by side: loops over springs of a node then end where the processor expects it.
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const auto key = [&](std::uint32_t k) {
      return std::tuple(layout.incident_end(k) - layout.incident_begin(k), place_[k]);
    };
    return key(a) < key(b);
  };
  for (std::size_t level = 0; level + 1 < begin.size(); ++level) {
    const std::span<std::uint32_t> equal = std::span(sorted_).subspan(begin[level], begin[level + 1] - begin[level]);
    std::sort(equal.begin(), equal.end(), before);
    for (std::size_t at = 0; at < equal.size(); at += together_limit)
      add_stage(layout, equal.subspan(at, std::min(together_limit, equal.size() - at)));
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
  const bool has_states = springs.places != nullptr;
  batches_.push_back(
      {springs.group, springs.rows.row, other_.size(), pieces_.size(), value_of_.size(), is_mixed, has_states});
  if (has_states) {
    internal_.resize(other_.size());  // of batches without
    internal_.insert(internal_.end(), springs.places, springs.places + springs.other.size());
  }
  other_.insert(other_.end(), springs.other.begin(), springs.other.end());
  pieces_.insert(pieces_.end(), springs.pieces.begin(), springs.pieces.end());
  if (!is_mixed) return;
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    value_of_.push_back(is_same(group, c) ? no_value : values_.size());
    for (std::size_t i = 0; i < springs.other.size() && !is_same(group, c); ++i)
      values_.push_back(group.columns[c][springs.rows.rows[i]]);
  }
}

void SweepPlan::take_spans() {
  columns_.clear();
  for (const std::size_t at : value_of_) columns_.push_back(at == no_value ? nullptr : values_.data() + at);
  springs_.clear();
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    const Batch& batch = batches_[b];
    const bool is_last = b + 1 == batches_.size();
    const std::size_t other_end = is_last ? other_.size() : batches_[b + 1].springs;
    const std::size_t pieces_end = is_last ? pieces_.size() : batches_[b + 1].pieces;
    springs_.push_back({batch.group,
                        std::span<const std::uint32_t>(other_).subspan(batch.springs, other_end - batch.springs),
                        std::span<const NodeSprings::Piece>(pieces_).subspan(batch.pieces, pieces_end - batch.pieces),
                        RowSelection{nullptr, batch.row, batch.is_mixed ? columns_.data() + batch.columns : nullptr},
                        batch.has_states ? internal_.data() + batch.springs : nullptr});
  }
  stages_.clear();
  for (std::size_t s = 0; s < ranges_.size(); ++s) {
    const Range& range = ranges_[s];
    const bool is_last = s + 1 == ranges_.size();
    const std::size_t nodes_end = is_last ? nodes_.size() : ranges_[s + 1].nodes;
    const std::size_t batches_end = is_last ? batches_.size() : ranges_[s + 1].batches;
    stages_.push_back({std::span<const std::uint32_t>(nodes_).subspan(range.nodes, nodes_end - range.nodes),
                       std::span<const NodeSprings>(springs_).subspan(range.batches, batches_end - range.batches),
                       range.is_single});
  }
}

}  // namespace springnet::layers
