// Rules in which each node reads the newest outputs of the others, one node after another or one colour after another.
#pragma once

#include <cstdint>
#include <span>

#include "block_update.hpp"
#include "colouring.hpp"
#include "rule.hpp"
#include "wavefront.hpp"

namespace springnet::recurrent {

// What both have in common: outputs are changed in place, forces are compared with those of the start.
class Ordered : public Rule {
 public:
  void begin(Step& step) override;

 protected:
  explicit Ordered(Workspace& workspace) noexcept : work_(workspace) {}
  // Sweeps with a call that has its order; update(batch) returns whether the new outputs are finite.
  template <class Update>
  void sweep_with(Step& step, const springnet_sweep& call, Update&& update) {
    ForceRecord& record = work_.record;
    record.begin_sweep();
    work_.host.sweep(call, [&](const springnet_node_batch& batch) {
      record.take_finite(batch, update(batch));
      record.take(step.network, batch);
    });
    ++step.sweeps;
    step.evaluated = false;
    step.differences = record.differences(step.network);
    step.finite = record.finite();
  }

  Workspace& work_;
};

// The paper's order: breadth first from the node with the greatest force, then from that with the greatest force
// difference. Each node goes where its force takes it, or (block) to its own equilibrium.
class WavefrontRule final : public Ordered {
 public:
  WavefrontRule(Workspace& workspace, bool block) noexcept : Ordered(workspace), block_(block) {}
  void attach(const springnet_network& network) override;
  void begin(Step& step) override;
  [[nodiscard]] bool relaxes() const noexcept override { return !block_; }
  [[nodiscard]] bool changes_order() const noexcept override { return true; }
  void sweep(Step& step) override;
  void begin_linear(const Step& step) override;
  void linear_sweep(Step& step) override;

 private:
  // A call in an order, with the update that belongs to the rule: go(call, update).
  template <class Go>
  void with_update(Step& step, std::span<const std::uint32_t> order, const Go& go);

  // [node_count][3][3] kg, effective masses of a relaxed update.
  const double* relaxed_inertia(const Step& step);

  bool block_;
  Wavefront order_;
  std::span<const std::uint32_t> sweep_order_, linear_order_;
  BlockMemory memory_;
};

// Nodes to their own equilibria, those of one colour at once.
class Coloured final : public Ordered {
 public:
  explicit Coloured(Workspace& workspace) noexcept : Ordered(workspace) {}
  void attach(const springnet_network& network) override;
  void sweep(Step& step) override;
  void linear_sweep(Step& step) override;

 private:
  [[nodiscard]] springnet_sweep call_in_order(const Step& step);

  Colouring colours_;
  BlockMemory memory_;
};

}  // namespace springnet::recurrent
