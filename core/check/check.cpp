#include "check/check.hpp"

#include <algorithm>
#include <functional>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include <springnet/printable.hpp>

#include "check/integrator_checks.hpp"
#include "check/law_checks.hpp"
#include "check/neuron_checks.hpp"
#include "check/texts.hpp"

namespace springnet::check {
namespace {

// A check with the earlier ones whose failure leaves it without meaning, and the threads that it uses at a time.
template <class Run>
struct Check {
  std::string_view name;
  Run* run;
  std::vector<std::string_view> needs;
  unsigned threads = 1;
};

using LawCheck = Check<Outcome(const LawSubject&)>;
const std::vector<LawCheck>& law_checks() {
  static const std::vector<LawCheck> checks{
      {"call", check_call, {"load"}},
      {"arrays", check_arrays, {"call"}},
      {"batches", check_batches, {"arrays"}, 4},
      {"finite", check_finite, {"batches"}},
      {"rest", check_rest, {"finite"}},
      {"energy", check_energy, {"finite"}},
      {"derivatives", check_derivatives, {"finite"}},
      {"dissipation", check_dissipation, {"energy"}},
      {"states", check_states, {"finite", "batches"}},
      {"promises", check_promises, {"finite"}},
      {"order", check_order, {"finite", "derivatives", "batches", "states"}},
      {"leaks", check_leaks, {"arrays"}},
      {"speed", check_speed, {"arrays"}},
  };
  return checks;
}

using NeuronCheck = Check<Outcome(const Component&, std::uint64_t)>;
const std::vector<NeuronCheck>& neuron_checks() {
  static const std::vector<NeuronCheck> checks{
      {"call", check_neuron_call, {"load"}},         {"arrays", check_neuron_arrays, {"call"}},
      {"finite", check_neuron_finite, {"arrays"}},   {"derivatives", check_neuron_derivatives, {"finite"}},
      {"batches", check_neuron_batches, {"arrays"}}, {"leaks", check_neuron_leaks, {"arrays"}}};
  return checks;
}

using IntegratorCheck = Check<Outcome(const Component&, const PluginHost&)>;
const std::vector<IntegratorCheck>& integrator_checks() {
  static const std::vector<IntegratorCheck> checks{
      {"call", check_integrator_call, {"load"}},         {"order", check_integrator_order, {"call"}},
      {"momentum", check_integrator_momentum, {"call"}}, {"states", check_integrator_states, {"order"}},
      {"events", check_integrator_events, {"order"}},    {"contact", check_integrator_contact, {"order"}},
      {"rigid", check_integrator_rigid, {"order"}},      {"refusals", check_integrator_refusals, {"call"}},
      {"options", check_integrator_options, {"call"}},   {"repeats", check_integrator_repeats, {"call"}, 4},
      {"memory", check_integrator_memory, {"repeats"}},  {"leaks", check_integrator_leaks, {"call"}}};
  return checks;
}

// Runs the checks of one component, in their order: those that are wanted, and what these need.
class Judge {
 public:
  Judge(const Component& component, const Options& options, const Listener& listener)
      : component_(component), options_(options), listener_(listener) {}

  // body: calls a check's function.
  template <class Run, class Body>
  void run(const std::vector<Check<Run>>& checks, const char* subject, const Body& body) {
    std::set<std::string_view> needed{options_.only};
    for (auto check = checks.rbegin(); check != checks.rend(); ++check)
      if (needed.contains(check->name)) needed.insert(check->needs.begin(), check->needs.end());
    const bool all = options_.only.empty();
    if (all || needed.contains("load")) note("load", check_texts(component_));
    for (const Check<Run>& check : checks)
      if (all || needed.contains(check.name)) note(check.name, outcome_of(check, subject, body));
  }

 private:
  template <class Run, class Body>
  [[nodiscard]] Outcome outcome_of(const Check<Run>& check, const char* subject, const Body& body) const {
    for (const std::string_view need : check.needs)
      if (bad_.contains(need)) return {Result::skipped, fmt::format("needs '{}'", need)};
    Limits limits = options_.limits;
    limits.threads = check.threads;
    now_doing(fmt::format("check '{}' runs", check.name).c_str());
    Outcome outcome = run_in_child([&] { return body(*check.run); }, limits, subject);
    outcome.why = printable_message(outcome.why);
    return outcome;
  }
  // What is only needed is told if it is wrong.
  void note(std::string_view check, const Outcome& outcome) {
    if (is_bad(outcome.result) || outcome.result == Result::skipped) bad_.insert(check);
    if (options_.only.empty() || options_.only == check || is_bad(outcome.result))
      listener_({std::string(component_.id()), std::string(name_of(component_.kind())), std::string(check), outcome});
  }

  const Component& component_;
  const Options& options_;
  const Listener& listener_;
  std::set<std::string_view> bad_;  // failed or skipped
};

// scene: of a law that a scene uses; null: none.
void check_one(const std::shared_ptr<const Component>& component, const SceneLaw* scene, const Options& options,
               const Listener& listener) {
  Judge judge(*component, options, listener);
  switch (component->kind()) {
    case ComponentKind::neuron:
      return judge.run(neuron_checks(), "the neuron", [&](auto& run) { return run(*component, options.seed); });
    case ComponentKind::integrator:
      return judge.run(integrator_checks(), "the integrator",
                       [&](auto& run) { return run(*component, *options.host); });
    default: {
      const LawSubject subject{component, options.host, scene, options.seed};
      return judge.run(law_checks(), "the law", [&](auto& run) { return run(subject); });
    }
  }
}

}  // namespace

const char* name_of(Result result) noexcept {
  switch (result) {
    case Result::passed:
      return "pass";
    case Result::warned:
      return "warn";
    case Result::failed:
      return "fail";
    case Result::crashed:
      return "crash";
    case Result::timed_out:
      return "timeout";
    case Result::skipped:
      return "skipped";
  }
  return "";
}

bool Report::passed() const noexcept {
  return std::none_of(findings.begin(), findings.end(), [](const Finding& f) { return is_bad(f.outcome.result); });
}

const std::vector<std::string_view>& check_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all{"load"};
    for (const LawCheck& check : law_checks()) all.push_back(check.name);
    for (const IntegratorCheck& check : integrator_checks())
      if (std::find(all.begin(), all.end(), check.name) == all.end()) all.push_back(check.name);
    return all;
  }();
  return names;
}

void check_components(const std::vector<std::shared_ptr<const Component>>& components, const Options& options,
                      const Listener& listener) {
  for (const auto& component : components) check_one(component, nullptr, options, listener);
}

void check_laws_of(const Network& network, const Options& options, const Listener& listener) {
  for (const SceneLaw& law : laws_of(network, *options.host)) {
    const LawUse& use = law.use;
    check_one(use.component != nullptr ? use.component : options.host->require(law.kind, use.id), &law, options,
              listener);
  }
}

Report check_components(const std::vector<std::shared_ptr<const Component>>& components, const Options& options) {
  Report report{options.seed, true, {}};
  check_components(components, options, [&](const Finding& finding) { report.findings.push_back(finding); });
  return report;
}

Report check_laws_of(const Network& network, const Options& options) {
  Report report{options.seed, true, {}};
  check_laws_of(network, options, [&](const Finding& finding) { report.findings.push_back(finding); });
  return report;
}

}  // namespace springnet::check
