#include "explanation.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace springnet::recurrent {
namespace {

const char* calmer(Update update, bool chosen_by_user, bool exact_sweeps) {
  const bool weak = update == Update::synchronous || update == Update::wavefront;
  if (chosen_by_user && !exact_sweeps && update == Update::synchronous)
    return "use a smaller time_step or update = \"wavefront\", \"block\" or \"newton\"";
  if (chosen_by_user && !exact_sweeps && weak)
    return "use a smaller time_step, less stiffness and damping, or update = \"block\" or \"newton\"";
  if (chosen_by_user && !exact_sweeps && update != Update::newton)
    return "use a smaller time_step, less stiffness and damping, or update = \"newton\"";
  return "use a smaller time_step, or less stiffness and damping";
}

}  // namespace

std::string explain(const Step& step, const Attempt& attempt, bool chosen_by_user, bool exact_sweeps) {
  const std::uint32_t node = step.network.user_number[step.differences.node == no_node ? 0 : step.differences.node];
  const auto sweeps = static_cast<unsigned long long>(step.sweeps);
  const char* remedy = calmer(attempt.update, chosen_by_user, exact_sweeps);
  std::array<char, 512> text{};
  if (!attempt.law_message.empty()) {
    std::snprintf(text.data(), text.size(), "the step diverges after %llu sweeps: %s; %s", sweeps,
                  attempt.law_message.c_str(), remedy);
    return text.data();
  }
  if (!step.finite) {
    std::snprintf(
        text.data(), text.size(),
        "the step diverges after %llu sweeps: numbers are no longer finite, first at node %u; %s, or unsettled = "
        "\"adapt\"",
        sweeps, node, remedy);
    return text.data();
  }
  const char* outcome = "diverges";
  const char* besides = "";
  if (attempt.verdict == Verdict::oscillating) {
    outcome = "oscillates";
    besides = ", or raise force_tolerance if it is near the rounding of the forces";
  } else if (attempt.verdict == Verdict::out_of_sweeps) {
    outcome = "ran out of sweeps";
    besides = ", or raise max_sweeps";
  }
  const bool forces_settled = step.differences.greatest <= step.tolerance;
  std::array<char, 128> what{};
  if (forces_settled)
    std::snprintf(what.data(), what.size(), "the forces have settled, but the equation of motion is off by %.3g N",
                  step.residual);
  else
    std::snprintf(what.data(), what.size(), "the forces still change by %.3g N at node %u", step.differences.greatest,
                  node);
  std::snprintf(
      text.data(), text.size(),
      "the step %s after %llu sweeps: %s, more than force_tolerance %.3g N; %s%s; unsettled = \"adapt\" divides "
      "such steps, \"accept\" takes them as they are",
      outcome, sweeps, what.data(), step.tolerance, remedy, besides);
  return text.data();
}

std::uint32_t non_finite_node(const Step& step) {
  const springnet_vectors& p = step.newest().position;
  std::uint32_t first = no_node;
  for (std::uint32_t k = 0; k < step.network.node_count; ++k) {
    if (std::isfinite(p.x[k]) && std::isfinite(p.y[k]) && std::isfinite(p.z[k])) continue;
    if (first == no_node || step.network.user_number[k] < step.network.user_number[first]) first = k;
  }
  return first == no_node ? step.differences.node : first;
}

}  // namespace springnet::recurrent
