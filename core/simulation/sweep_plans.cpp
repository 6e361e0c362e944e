#include "simulation/sweep_plans.hpp"

#include <algorithm>

namespace springnet {
namespace {

constexpr std::size_t max_plans = 64;
constexpr std::size_t max_bytes = std::size_t{1}
                                  << 21;  // of all but the newest plan: they share the cache with the net

}  // namespace

const layers::SweepPlan* SweepPlans::find(std::span<const std::uint32_t> order, std::uint64_t revision) {
  if (revision != revision_) plans_.clear();
  revision_ = revision;
  const auto found = std::find_if(plans_.begin(), plans_.end(), [&](const auto& plan) {
    return std::equal(order.begin(), order.end(), plan->order().begin(), plan->order().end());
  });
  if (found == plans_.end()) return nullptr;
  std::rotate(plans_.begin(), found, found + 1);
  return plans_.front().get();
}

const layers::SweepPlan& SweepPlans::make(const layers::Layout& layout, std::span<const std::uint32_t> order,
                                          const std::function<bool(std::uint32_t)>& is_lone) {
  plans_.insert(plans_.begin(), std::make_unique<const layers::SweepPlan>(layout, order, is_lone));
  std::size_t bytes = 0, kept = 1;
  while (kept < plans_.size() && kept < max_plans && (bytes += plans_[kept]->size()) <= max_bytes) ++kept;
  plans_.resize(kept);
  return *plans_.front();
}

}  // namespace springnet
