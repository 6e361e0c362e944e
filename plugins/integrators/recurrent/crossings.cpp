#include "crossings.hpp"

#include <algorithm>

#include <springnet/sdk/integrator.hpp>

namespace springnet::recurrent {
namespace {

// Every fourth evaluation bisects the interval instead of interpolating.
constexpr int evaluations_per_halving = 4;

}  // namespace

void Crossings::begin(const sdk::Host& host, double time, const springnet_state& state) {
  const std::size_t count = host.network().event_count;
  for (auto* values : {&first_, &values_}) values->assign(count, 0.0);
  for (auto* marks : {&directions_, &fired_}) marks->assign(count, 0);
  is_due_ = false;
  if (count > 0) {
    kinds_.resize(count);
    host.event_values(sdk::evaluation_at(time, state), first_.data(), directions_.data(),
                      {kinds_.data(), nullptr, nullptr});
    for (std::size_t e = 0; e < count; ++e) {
      const bool is_by_force = kinds_[e] == SPRINGNET_EVENT_RELEASE || kinds_[e] == SPRINGNET_EVENT_SLIP;
      is_due_ = is_due_ || (is_by_force && directions_[e] * first_[e] > 0.0);
    }
  }
  low_values_ = high_values_ = first_;
  high_fired_ = fired_;
  low_ = high_ = time;
  low_weight_ = high_weight_ = 1.0;
  side_ = evaluations_ = 0;
  any_ = false;
}

bool Crossings::evaluate(const sdk::Host& host, double time, const springnet_state& state) {
  if (first_.empty()) return false;
  auto internal = sdk::sized<springnet_internal>();
  internal.values = state.internal;
  springnet_evaluation evaluation = sdk::evaluation_at(time, state);
  if (state.internal != nullptr) evaluation.internal = &internal;
  host.event_values(evaluation, values_.data(), directions_.data());
  bool any = false;
  for (std::size_t e = 0; e < values_.size(); ++e) {
    const double before = directions_[e] * first_[e], now = directions_[e] * values_[e];
    fired_[e] = before < 0.0 && now >= 0.0 ? 1 : 0;
    any = any || fired_[e] != 0;
  }
  const int side = any ? 1 : -1;
  if (side == side_) (any ? low_weight_ : high_weight_) *= 0.5;
  if (side != side_) low_weight_ = high_weight_ = 1.0;
  if (any) {
    high_ = time;
    high_values_ = values_;
    high_fired_ = fired_;
  } else if (evaluations_ > 0) {
    low_ = time;
    low_values_ = values_;
  }
  side_ = evaluations_ == 0 ? 0 : side;
  any_ = any_ || any;
  ++evaluations_;
  return any;
}

double Crossings::next_time() noexcept {
  double share = 1.0;
  for (std::size_t e = 0; e < high_values_.size(); ++e) {
    if (high_fired_[e] == 0) continue;
    const double low = low_weight_ * low_values_[e], high = high_weight_ * high_values_[e];
    // Zero of the linear interpolation.
    if (low != high) share = std::min(share, low / (low - high));
  }
  if (evaluations_ % evaluations_per_halving == 0) share = 0.5;
  return low_ + std::clamp(share, 1e-3, 0.999) * (high_ - low_);
}

}  // namespace springnet::recurrent
