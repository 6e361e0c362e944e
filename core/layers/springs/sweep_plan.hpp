// A sweep in an order, prepared: nodes that can be evaluated together, with their springs and parameters side by side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "layers/springs/node_springs.hpp"

namespace springnet::layers {

// Each node reads the newest outputs of its neighbours, so it depends on those before it in the order. A stage has
// nodes that depend on none of their stage or a later one: stage by stage, the outputs are those of the order itself.
class SweepPlan {
 public:
  struct Stage {
    std::span<const std::uint32_t> nodes;
    std::span<const NodeSprings> springs;  // none for a single node
    bool is_single;                        // a node that depends on more than its neighbours
  };
  // Whether a node depends on its neighbours alone. One that does not is a stage, after those of all nodes before it
  // and before those of all nodes after it.
  using IsLocal = std::function<bool(std::uint32_t node)>;

  // What plans of any order take at most.
  struct Sizes {
    std::size_t nodes = 0, springs = 0, pieces = 0, values = 0, columns = 0;
    explicit Sizes(const Layout& layout);
    [[nodiscard]] std::size_t bytes() const noexcept;  // about
  };

  explicit SweepPlan(const Sizes& sizes);
  SweepPlan(const SweepPlan&) = delete;
  SweepPlan& operator=(const SweepPlan&) = delete;

  // Allocates nothing if the sizes were those of the layout. The layout must outlive the plan; removals make it
  // invalid.
  void make(const Layout& layout, std::span<const std::uint32_t> order, const IsLocal& is_local);

  [[nodiscard]] std::span<const std::uint32_t> order() const noexcept { return order_; }
  [[nodiscard]] std::span<const Stage> stages() const noexcept { return stages_; }

 private:
  // Where the parts of a stage and of a batch begin; spans would not survive that the arrays grow.
  struct Range {
    std::size_t nodes, batches;
    bool is_single;
  };
  struct Batch {
    std::uint32_t group, row;
    std::size_t springs, pieces, columns;
    bool is_mixed, has_states;
  };

  void add_stretch(const Layout& layout, std::span<const std::uint32_t> nodes);
  void add_stage(const Layout& layout, std::span<const std::uint32_t> nodes);
  void add_batch(const Group& group, const NodeSprings& springs);
  void take_spans();

  std::vector<std::uint32_t> order_, nodes_;
  std::vector<Stage> stages_;
  std::vector<NodeSprings> springs_;
  std::vector<std::uint32_t> other_, internal_;  // [spring] the other end; place in the internal state
  std::vector<NodeSprings::Piece> pieces_;
  std::vector<double> values_;          // of parameters, [column][spring] of each batch
  std::vector<std::size_t> value_of_;   // [batch][column] where they begin, or none
  std::vector<const double*> columns_;  // the same as pointers
  std::vector<Range> ranges_;
  std::vector<Batch> batches_;
  // Of a stretch of the order between single nodes.
  std::vector<std::uint32_t> level_, stretch_, place_;  // [node] the stretch that it was last in, its place in it
  std::vector<std::uint32_t> sorted_;
  std::vector<std::size_t> level_begin_, level_next_;  // [level] in sorted_
  std::uint32_t stretches_ = 0;
};

}  // namespace springnet::layers
