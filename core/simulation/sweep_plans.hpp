// Plans of the orders that sweeps came in last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "layers/springs/sweep_plan.hpp"

namespace springnet {

class SweepPlans {
 public:
  // The plan of an order; null if there is none. `revision`: of the network's connections; another one drops all plans.
  [[nodiscard]] const layers::SweepPlan* find(std::span<const std::uint32_t> order, std::uint64_t revision);
  // Makes one, in place of those used least recently if plans would take too much memory.
  const layers::SweepPlan& make(const layers::Layout& layout, std::span<const std::uint32_t> order,
                                const std::function<bool(std::uint32_t)>& is_lone);

 private:
  std::vector<std::unique_ptr<const layers::SweepPlan>> plans_;  // used last first
  std::uint64_t revision_ = 0;
};

}  // namespace springnet
