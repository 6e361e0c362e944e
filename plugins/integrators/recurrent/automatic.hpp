// Chooses the update rule if a scene names none.
#pragma once

#include <cstdint>
#include <optional>

#include "rule.hpp"

namespace springnet::recurrent {

class Automatic {
 public:
  // The rule for a step. Estimated at the first call, when the time constant changes, after a step that did not settle
  // and, at intervals, after changes of the network. Notes the choice and its reason.
  [[nodiscard]] Update choose(const Workspace& workspace, const Step& step);
  // Whether the synchronous rule, if it was chosen for the step, settles in less time with acceleration.
  [[nodiscard]] bool accelerates() const noexcept { return accelerates_; }
  // The rule to try when `update` did not settle a step; empty if none is left.
  [[nodiscard]] static std::optional<Update> after(Update update) noexcept;
  // Records that a step settled with a rule other than the chosen one.
  void escalated(const Workspace& workspace, Update chosen, Update needed);

  // Forgets estimates, and failures of steps before.
  void forget() noexcept {
    chosen_.reset();
    accelerates_ = false;
    time_constant_ = weight_ = 0.0;
    revision_ = steps_ = kept_ = 0;
    patience_ = first_patience;
    kept_rule_ = Update::newton;
  }

 private:
  static constexpr std::uint64_t first_patience = 16;
  void estimate(const Workspace& workspace, const Step& step);

  std::optional<Update> chosen_;
  bool accelerates_ = false;
  double time_constant_ = 0.0;               // s, of the estimate
  double weight_ = 0.0;                      // s, critical
  std::uint64_t revision_ = 0;               // of the network at the estimate
  std::uint64_t steps_ = 0;                  // since the estimate
  std::uint64_t patience_ = first_patience;  // steps for which another rule is kept after a failure
  Update kept_rule_ = Update::newton;
  std::uint64_t kept_ = 0;  // steps left of them
};

}  // namespace springnet::recurrent
