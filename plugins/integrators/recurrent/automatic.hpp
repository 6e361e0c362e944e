// The update rule that the engine picks where a scene names none.
#pragma once

#include <cstdint>
#include <optional>

#include "rule.hpp"

namespace springnet::recurrent {

class Automatic {
 public:
  // The rule for a step: estimated when first asked, when the time constant changed, after a step that did not settle
  // and, from time to time, after the network changed. Says what it picked, and why.
  [[nodiscard]] Update choose(const Workspace& workspace, const Step& step);
  // What is tried where a rule did not settle a step; nothing if there is nothing left.
  [[nodiscard]] static std::optional<Update> after(Update update) noexcept;
  // A step settled with another rule than the one chosen.
  void escalated(const Workspace& workspace, Update chosen, Update needed);

 private:
  void estimate(const Workspace& workspace, const Step& step);

  std::optional<Update> chosen_;
  double time_constant_ = 0.0;   // s, of the estimate
  double weight_ = 0.0;          // s, critical
  std::uint64_t revision_ = 0;   // of the network at the estimate
  std::uint64_t steps_ = 0;      // since the estimate
  std::optional<Update> noted_;  // the rule that was told last
  std::uint64_t patience_ = 16;  // steps that another rule is kept after a failure
  Update kept_rule_ = Update::newton;
  std::uint64_t kept_ = 0;  // of them left
  double escalations_ = 0.0;
};

}  // namespace springnet::recurrent
