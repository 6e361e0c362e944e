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

// A check with the earlier ones whose failure leaves it without meaning.
struct LawCheck {
  std::string_view name;
  Outcome (*run)(const LawSubject&);
  std::vector<std::string_view> needs;
};
const std::vector<LawCheck>& law_checks() {
  static const std::vector<LawCheck> checks{
      {"call", check_call, {"load"}},
      {"arrays", check_arrays, {"call"}},
      {"batches", check_batches, {"arrays"}},
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

struct NeuronCheck {
  std::string_view name;
  Outcome (*run)(const Component&, std::uint64_t);
  std::vector<std::string_view> needs;
};
const std::vector<NeuronCheck>& neuron_checks() {
  static const std::vector<NeuronCheck> checks{
      {"call", check_neuron_call, {"load"}},         {"arrays", check_neuron_arrays, {"call"}},
      {"finite", check_neuron_finite, {"arrays"}},   {"derivatives", check_neuron_derivatives, {"finite"}},
      {"batches", check_neuron_batches, {"arrays"}}, {"leaks", check_neuron_leaks, {"arrays"}}};
  return checks;
}

struct IntegratorCheck {
  std::string_view name;
  Outcome (*run)(const Component&, const PluginHost&);
  std::vector<std::string_view> needs;
};
const std::vector<IntegratorCheck>& integrator_checks() {
  static const std::vector<IntegratorCheck> checks{
      {"call", check_integrator_call, {"load"}},         {"order", check_integrator_order, {"call"}},
      {"momentum", check_integrator_momentum, {"call"}}, {"states", check_integrator_states, {"order"}},
      {"events", check_integrator_events, {"order"}},    {"contact", check_integrator_contact, {"order"}},
      {"rigid", check_integrator_rigid, {"order"}},      {"refusals", check_integrator_refusals, {"call"}},
      {"options", check_integrator_options, {"call"}},   {"repeats", check_integrator_repeats, {"call"}},
      {"memory", check_integrator_memory, {"repeats"}},  {"leaks", check_integrator_leaks, {"call"}}};
  return checks;
}

// Findings of one component, in the order of the checks.
class Judge {
 public:
  Judge(const Component& component, const Options& options, Report& report)
      : id_(component.id()), kind_(name_of(component.kind())), options_(options), report_(report) {}

  [[nodiscard]] bool wanted(std::string_view check) const { return options_.only.empty() || options_.only == check; }

  void note(std::string_view check, const Outcome& outcome) {
    if (is_bad(outcome.result) || outcome.result == Result::skipped) bad_.insert(check);
    report_.findings.push_back({id_, kind_, std::string(check), outcome});
  }
  void run(std::string_view check, const std::vector<std::string_view>& needs, const char* subject,
           const std::function<Outcome()>& body) {
    if (!wanted(check)) return;
    for (const std::string_view need : needs)
      if (bad_.contains(need)) return note(check, {Result::skipped, fmt::format("needs '{}'", need)});
    Outcome outcome = run_in_child(body, options_.limits, subject);
    outcome.why = printable_message(outcome.why);
    note(check, outcome);
  }

 private:
  std::string id_, kind_;
  const Options& options_;
  Report& report_;
  std::set<std::string_view> bad_;  // failed or skipped
};

// scene: of a law that a scene uses; null: none.
void check_one(const std::shared_ptr<const Component>& component, const SceneLaw* scene, const Options& options,
               Report& report) {
  Judge judge(*component, options, report);
  if (judge.wanted("load")) judge.note("load", check_texts(*component));
  switch (component->kind()) {
    case ComponentKind::neuron:
      for (const NeuronCheck& check : neuron_checks())
        judge.run(check.name, check.needs, "the neuron", [&] { return check.run(*component, options.seed); });
      break;
    case ComponentKind::integrator:
      for (const IntegratorCheck& check : integrator_checks())
        judge.run(check.name, check.needs, "the integrator", [&] { return check.run(*component, *options.host); });
      break;
    default: {
      const LawSubject subject{component, options.host, scene, options.seed};
      for (const LawCheck& check : law_checks())
        judge.run(check.name, check.needs, "the law", [&] { return check.run(subject); });
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

Report check_components(const std::vector<std::shared_ptr<const Component>>& components, const Options& options) {
  Report report{options.seed, true, {}};
  for (const auto& component : components) check_one(component, nullptr, options, report);
  return report;
}

Report check_file(const std::filesystem::path& file, const Options& options) {
  // A constructor of the library may do what it likes: first where it does no harm. The destructors run there, too.
  const auto load = [&file]() -> Outcome {
    now_doing("loading the file");
    PluginHost host;
    static_cast<void>(host.load(file));
    if (!host.refusals().empty()) return {Result::failed, host.refusals().front().reason};
    return {};
  };
  Report report{options.seed, true, {}};
  const Outcome outcome = run_in_child(load, options.limits, "the plugin");
  if (outcome.result == Result::passed) {
    PluginHost host;
    if (host.load(file)) {
      report = check_components(host.components(), options);
      return report;
    }
  }
  report.loaded = false;
  report.findings.push_back({printable(file.filename().string()), "plugin", "load", outcome});
  return report;
}

Report check_laws_of(const Network& network, const Options& options) {
  Report report{options.seed, true, {}};
  for (const SceneLaw& law : laws_of(network, *options.host)) {
    const LawUse& use = law.use;
    check_one(use.component != nullptr ? use.component : options.host->require(law.kind, use.id), &law, options,
              report);
  }
  return report;
}

}  // namespace springnet::check
