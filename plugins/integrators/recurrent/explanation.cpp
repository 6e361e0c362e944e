#include "explanation.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace springnet::recurrent {
namespace {

// Up to these multiples of the critical time constant, wavefront certainly settles (its limit is 1.4 to 2), and
// accelerated synchronous and block sweeps settle within some tens.
constexpr double wavefront_settles = 1.2, accelerated_settles = 8.0, block_settles = 20.0;

bool is_explicit(Update update) { return update == Update::synchronous || update == Update::wavefront; }

// Rules that would settle the step, as a setting: update = "newton" or "automatic". Empty: there is no better one.
std::string better_rules(const Attempt& attempt, const Circumstances& circumstances) {
  if (!circumstances.chosen_by_user || circumstances.exact_sweeps || attempt.update == Update::newton) return {};
  std::string more;
  if (is_explicit(attempt.update) && circumstances.over_critical < block_settles) more += ", \"block\"";
  if (attempt.update == Update::synchronous && circumstances.over_critical < wavefront_settles)
    more += ", \"wavefront\"";
  if (more.empty()) return "update = \"newton\" or \"automatic\"";
  const std::size_t last = more.rfind(", ");
  return "update = \"newton\", \"automatic\"" + more.substr(0, last) + " or " + more.substr(last + 2);
}

// All remedies in one clause: "use a, b, or c".
std::string remedy_for(const Step& step, const Attempt& attempt, const Circumstances& circumstances) {
  std::vector<std::string> remedies;
  if (const std::string rules = better_rules(attempt, circumstances); !rules.empty()) remedies.push_back(rules);
  if (attempt.update == Update::synchronous && !circumstances.accelerated && !circumstances.exact_sweeps &&
      circumstances.over_critical < accelerated_settles)
    remedies.emplace_back("acceleration = 5");
  // theta = 1 damps motion that the step cannot resolve, but makes explicit sweeps harder to settle.
  if (step.theta < 1.0 && !circumstances.exact_sweeps && !is_explicit(attempt.update))
    remedies.emplace_back("theta = 1");
  if (!circumstances.divided) remedies.emplace_back("a smaller time_step");
  remedies.emplace_back("less stiffness and damping");
  std::string text = "use ";
  for (std::size_t i = 0; i < remedies.size(); ++i)
    text += (i == 0 ? "" : i + 1 == remedies.size() ? ", or " : ", ") + remedies[i];
  return text;
}

const char* remedy_for_start(const Circumstances& circumstances) {
  return circumstances.starts_untested
             ? "this happens already at the start of the step: use a smaller time_step from the beginning if the steps "
               "before were too long, else change that law or neuron, or the initial state"
             : "this happens already at the start of the step, so no time_step helps: change that law or neuron, or "
               "the "
               "initial state";
}

// Messages of rigid connections and contacts contain their own advice.
bool has_remedy(const std::string& message) { return message.find("smaller time") != std::string::npos; }

std::string short_number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

}  // namespace

std::string explain(const Step& step, const Attempt& attempt, const Circumstances& circumstances) {
  const std::string node =
      std::to_string(step.network.user_number[step.differences.node == no_node ? 0 : step.differences.node]);
  const std::string after = " after " + std::to_string(step.sweeps) + (step.sweeps == 1 ? " sweep: " : " sweeps: ");
  const std::string remedy = remedy_for(step, attempt, circumstances);
  if (!attempt.law_message.empty()) {
    const std::string text = "the step diverges" + after + attempt.law_message;
    if (circumstances.fails_at_start) return text + "; " + remedy_for_start(circumstances);
    if (!has_remedy(attempt.law_message)) return text + "; " + remedy;
    const bool is_told = attempt.law_message.find("unsettled") != std::string::npos;
    return is_told ? text : text + ", or unsettled = \"adapt\", which divides such steps";
  }
  if (!step.finite) {
    const std::string text = "the step diverges" + after + "numbers are no longer finite, first at node " + node + "; ";
    return text + (circumstances.fails_at_start ? std::string(remedy_for_start(circumstances))
                                                : remedy + ", or unsettled = \"adapt\"");
  }
  std::string outcome = "diverges", more_advice;
  if (attempt.verdict == Verdict::oscillating) {
    outcome = "oscillates";
    if (!(step.rounding > 0.0))
      more_advice = ", or raise force_tolerance if it is near the rounding error of the forces";
  } else if (attempt.verdict == Verdict::out_of_sweeps) {
    outcome = "ran out of sweeps";
    more_advice = ", or raise max_sweeps";
  }
  const bool forces_settled = step.differences.greatest <= step.tolerance;
  const std::string what =
      forces_settled
          ? "the forces have settled, but the equation of motion is off by " + short_number(step.residual) + " N"
          : "the forces still change by " + short_number(step.differences.greatest) + " N at node " + node;
  const std::string limit = step.tolerance > step.rounding ? "force_tolerance " : "their rounding error, ";
  return "the step " + outcome + after + what + ", more than " + limit + short_number(step.tolerance) + " N; " +
         remedy + more_advice + "; unsettled = \"adapt\" divides such steps, \"accept\" takes them as they are";
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
