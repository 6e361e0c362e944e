// A sweep in an order, prepared: nodes that can be evaluated together, with their springs and parameters side by side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "layers/springs/node_springs.hpp"

namespace springnet::layers {

// Each node reads the newest outputs of its neighbours, so it depends on those before it in the order. Nodes that
// depend on no node of their stage or a later one are a stage: the outputs are those of the order itself.
class SweepPlan {
 public:
  struct Stage {
    std::span<const std::uint32_t> nodes;
    std::span<const NodeSprings> springs;  // none for a node by itself
    bool by_itself;                        // a node that must not be evaluated with others
  };

  // is_lone(node): whether a node depends on its neighbours alone. One that does not has a stage of its own, between
  // those of the nodes before and after it in the order. The layout must outlive the plan; removals make it invalid.
  SweepPlan(const Layout& layout, std::span<const std::uint32_t> order,
            const std::function<bool(std::uint32_t)>& is_lone);
  SweepPlan(const SweepPlan&) = delete;
  SweepPlan& operator=(const SweepPlan&) = delete;

  [[nodiscard]] std::span<const std::uint32_t> order() const noexcept { return order_; }
  [[nodiscard]] std::span<const Stage> stages() const noexcept { return stages_; }
  // Memory that it takes, about, bytes.
  [[nodiscard]] std::size_t size() const noexcept;

 private:
  // Where the parts of a stage and of a batch begin; spans would not survive that the arrays grow.
  struct Range {
    std::size_t nodes, batches;
    bool by_itself;
  };
  struct Batch {
    std::uint32_t group, row;
    std::size_t other, pieces, rows, columns;  // where they begin
    bool is_mixed;
  };

  void add_stretch(const Layout& layout, std::span<const std::uint32_t> nodes);
  void add_stage(const Layout& layout, std::span<const std::uint32_t> nodes);
  void add_batch(const Group& group, const NodeSprings& springs);
  void finish();

  std::vector<std::uint32_t> order_, nodes_;
  std::vector<Stage> stages_;
  std::vector<NodeSprings> springs_;
  std::vector<std::uint32_t> other_, rows_;
  std::vector<NodeSprings::Piece> pieces_;
  std::vector<double> values_;          // of parameters, [column][spring] of each batch
  std::vector<std::size_t> value_of_;   // [batch][column] where they begin, or none
  std::vector<const double*> columns_;  // the same as pointers
  std::vector<Range> ranges_;
  std::vector<Batch> batches_;
  std::vector<std::uint32_t> level_, stretch_;  // [node] within the stretch of the order that it was last in
  std::uint32_t stretches_ = 0;
};

}  // namespace springnet::layers
