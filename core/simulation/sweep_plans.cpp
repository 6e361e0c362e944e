#include "simulation/sweep_plans.hpp"

#include <algorithm>

namespace springnet {
namespace {

constexpr std::size_t max_plans = 64;
// Of several plans, which share the cache with the net; and of a single one: a large net is swept without.
constexpr std::size_t max_bytes = std::size_t{1} << 21, max_plan_bytes = std::size_t{1} << 24;

}  // namespace

const layers::SweepPlan* SweepPlans::find(const layers::Layout& layout, std::span<const std::uint32_t> order) {
  if (revision_ != layout.revision() + layout.value_revision()) {
    revision_ = layout.revision() + layout.value_revision();
    // Rows may differ in more columns, for which plans have made no room.
    if (value_revision_ != layout.value_revision()) plans_.clear();
    value_revision_ = layout.value_revision();
    made_ = 0;
    is_too_large_ = false;
  }
  const auto end = plans_.begin() + static_cast<std::ptrdiff_t>(made_);
  const auto found = std::find_if(plans_.begin(), end, [&](const auto& plan) {
    return std::equal(order.begin(), order.end(), plan->order().begin(), plan->order().end());
  });
  if (found == end) return nullptr;
  std::rotate(plans_.begin(), found, found + 1);
  return plans_.front().get();
}

const layers::SweepPlan* SweepPlans::make(const layers::Layout& layout, std::span<const std::uint32_t> order,
                                          const layers::SweepPlan::IsLocal& is_local) {
  if (is_too_large_) return nullptr;
  if (plans_.empty()) {
    const layers::SweepPlan::Sizes sizes(layout);
    is_too_large_ = sizes.bytes() > max_plan_bytes;
    if (is_too_large_) return nullptr;
    const std::size_t count = std::clamp<std::size_t>(max_bytes / sizes.bytes(), 1, max_plans);
    for (std::size_t i = 0; i < count; ++i) plans_.push_back(std::make_unique<layers::SweepPlan>(sizes));
  }
  made_ = std::min(made_ + 1, plans_.size());
  const auto end = plans_.begin() + static_cast<std::ptrdiff_t>(made_);
  std::rotate(plans_.begin(), end - 1, end);
  plans_.front()->make(layout, order, is_local);
  return plans_.front().get();
}

}  // namespace springnet
