// Plans of the orders that sweeps came in last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "layers/springs/sweep_plan.hpp"

namespace springnet {

// Memory for all plans is allocated for the first one, and after removals only if they need more.
class SweepPlans {
 public:
  // The plan of an order; null if there is none.
  [[nodiscard]] const layers::SweepPlan* find(const layers::Layout& layout, std::span<const std::uint32_t> order);
  // Makes one, in place of the one used least recently; null if a plan would take too much memory.
  const layers::SweepPlan* make(const layers::Layout& layout, std::span<const std::uint32_t> order,
                                const layers::SweepPlan::IsLocal& is_local);

 private:
  std::vector<std::unique_ptr<layers::SweepPlan>> plans_;  // used last first
  std::size_t made_ = 0;                                   // of them
  bool is_too_large_ = false;
  std::uint64_t revision_ = 0, value_revision_ = 0;  // of the layout: both together, those of its values
};

}  // namespace springnet
