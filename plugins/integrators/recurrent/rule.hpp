// Update rules: what a sweep of the recurrent network does. They share the fixed point where it is unique.
#pragma once

#include <memory>

#include "workspace.hpp"

namespace springnet::recurrent {

// As the option `update` numbers them.
enum class Update : int { synchronous, wavefront, block, coloured, newton, automatic };
[[nodiscard]] const char* name_of(Update update) noexcept;

class Rule {
 public:
  Rule() = default;
  Rule(const Rule&) = delete;
  Rule& operator=(const Rule&) = delete;
  virtual ~Rule() = default;

  // After every change of network.revision.
  virtual void attach(const springnet_network& network) = 0;
  // Drops all that is kept from step to step and influences results; attach() follows.
  virtual void forget() noexcept {}
  // Before the first sweep of a step, or of a stage of it: step.outputs are where the propagation starts.
  virtual void begin(Step& step) = 0;
  // Whether sweeps heed step.relaxation.
  [[nodiscard]] virtual bool relaxes() const noexcept { return false; }
  // Whether each sweep takes another order, unless step.keeps_order.
  [[nodiscard]] virtual bool changes_order() const noexcept { return false; }
  // One sweep: sets step.outputs, differences, finite; and counts itself.
  virtual void sweep(Step& step) = 0;

  // The same on the network that Host::linearise left, for limits. Outputs are small changes, in arrays of 3n numbers
  // (x of all nodes first), with positions that belong to the velocities; step.start has the forces that the first
  // sweep of a run would see. A rule that solves the linear system has no such sweep: has_linear_sweep().
  [[nodiscard]] virtual bool has_linear_sweep() const noexcept { return true; }
  virtual void begin_linear(const Step&) {}
  virtual void linear_sweep(Step&) {}
};

[[nodiscard]] std::unique_ptr<Rule> make_rule(Update update, Workspace& workspace);

}  // namespace springnet::recurrent
