// All springs, then all nodes: the paper's frozen network.
#pragma once

#include "rule.hpp"

namespace springnet::recurrent {

class Synchronous final : public Rule {
 public:
  explicit Synchronous(Workspace& workspace) noexcept : work_(workspace) {}
  void attach(const springnet_network&) override {}
  void begin(Step& step) override;
  void sweep(Step& step) override;
  void linear_sweep(Step& step) override;

 private:
  Workspace& work_;
  std::vector<double> acceleration_;  // of a linear sweep
};

}  // namespace springnet::recurrent
