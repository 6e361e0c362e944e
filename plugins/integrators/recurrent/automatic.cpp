#include "automatic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "critical_time.hpp"

namespace springnet::recurrent {
namespace {

// Shares of the critical weight: up to the first, plain synchronous sweeps settle within some tens; up to the second,
// accelerated ones within a dozen, in a half to a quarter of the time that Newton's method takes.
constexpr double plain_share = 0.75, synchronous_share = 1.2;
// Steps between estimates at least, unless a step failed.
constexpr std::uint64_t min_steps = 32;
constexpr std::uint64_t max_patience = 1024;  // steps

}  // namespace

std::optional<Update> Automatic::after(Update update) noexcept {
  // Newton's method uses the friction of the last sweep, which may not converge if friction depends strongly on the
  // force that it opposes; `block` solves for it node by node.
  if (update == Update::block) return std::nullopt;
  return update == Update::newton ? Update::block : Update::newton;
}

Update Automatic::choose(const Workspace& workspace, const Step& step) {
  ++steps_;
  if (kept_ > 0) {
    --kept_;
    return kept_rule_;
  }
  const bool changed = step.network.revision != revision_ && steps_ >= min_steps;
  // Steps of equal length differ by the rounding of their ends.
  const bool same_step = std::abs(step.time_constant - time_constant_) <= 1e-6 * time_constant_;
  if (!chosen_ || changed || !same_step) estimate(workspace, step);
  return *chosen_;
}

void Automatic::estimate(const Workspace& workspace, const Step& step) {
  steps_ = 0;
  revision_ = step.network.revision;
  time_constant_ = step.time_constant;
  std::array<char, 256> text{};
  try {
    weight_ = critical_weight(workspace.host, step);
  } catch (const sdk::Failure& failure) {
    if (failure.recoverable()) throw;
    chosen_ = Update::wavefront;
    accelerates_ = false;
    std::snprintf(text.data(), text.size(), "update rule wavefront: %s", failure.what());
    workspace.host.note(text.data(), name_of(*chosen_));
    return;
  }
  chosen_ = step.weight() <= synchronous_share * weight_ ? Update::synchronous : Update::newton;
  accelerates_ = step.weight() > plain_share * weight_;
  // The critical time constant changes from step to step: a rule is noted when it is first chosen.
  if (std::isinf(weight_)) {
    // Masses without springs, for example: a ratio and a limit would be meaningless.
    workspace.host.note("update rule synchronous: no stiffness and no damping limits the time step", name_of(*chosen_));
    return;
  }
  // Two digits, but large ratios as whole numbers: 2098, not 2.1e+03.
  const double exact = step.weight() / weight_;
  const double ratio = exact < 99.5 ? exact : std::round(std::min(exact, 1e12));
  const int digits = exact < 99.5 ? 2 : 1 + static_cast<int>(std::log10(ratio));
  std::snprintf(text.data(), text.size(),
                "update rule %s%s: the time step is about %.*g times the critical time constant of synchronous "
                "propagation, %.2g s",
                name_of(*chosen_), accelerates_ && chosen_ == Update::synchronous ? ", accelerated" : "", digits, ratio,
                weight_ / step.theta);
  workspace.host.note(text.data(), name_of(*chosen_));
}

void Automatic::escalated(const Workspace& workspace, Update chosen, Update needed) {
  workspace.host.count("escalated_steps");
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "a step did not settle with update rule %s, but did with %s", name_of(chosen),
                name_of(needed));
  workspace.host.note(text.data(), "escalated step");
  chosen_.reset();
  kept_rule_ = needed;
  kept_ = patience_;
  patience_ = std::min(2 * patience_, max_patience);
}

}  // namespace springnet::recurrent
