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
  // Before the first sweep of a step, or of a stage of it: step.outputs are where the propagation starts.
  virtual void begin(Step& step) = 0;
  // One sweep: sets step.outputs, differences, finite; and counts itself.
  virtual void sweep(Step& step) = 0;
};

[[nodiscard]] std::unique_ptr<Rule> make_rule(Update update, Workspace& workspace);

}  // namespace springnet::recurrent
