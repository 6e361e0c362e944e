// refusals, options: what an integrator cannot do ends by a status and a reason.
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "check/child.hpp"
#include "check/integrator_checks.hpp"
#include "check/trial.hpp"

namespace springnet::check {
namespace {

// Whether a step, or steps, must not end well.
enum class Expected { failure, either };

// Empty if the steps end as they should: committed, or with an error that is no broken rule; always with finite states.
std::string ending(const std::function<Simulation()>& make, const std::function<void(Simulation&)>& steps,
                   Expected expected) {
  std::optional<Simulation> simulation;
  bool failed = false;
  try {
    simulation.emplace(make());
    steps(*simulation);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::plugin) return fmt::format("it breaks a rule: {}", error.what());
    failed = true;
  }
  if (!failed && expected == Expected::failure)
    return "it reports success: pass on what the host's functions return, and commit nothing then";
  if (simulation && !is_finite(*simulation)) return "the state is not finite";
  if (!failed || !simulation) return {};
  // Another step after a failure: as it likes, but it comes back.
  try {
    simulation->step();
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::plugin)
      return fmt::format("the step after one that failed breaks a rule: {}", error.what());
  }
  return is_finite(*simulation) ? "" : "the state is not finite after a step that failed";
}

struct Hardship {
  const char* what;
  LawUse law;
  oscillator::State start;
  double step;  // s
  std::function<void(Simulation&)> steps;
  Expected expected = Expected::either;
};

std::vector<Hardship> hardships() {
  const auto ten = [](Simulation& simulation) {
    for (int k = 0; k < 10; ++k) simulation.step();
  };
  // No number beyond a strain of 0.3, which the mass reaches for certain.
  const LawUse bounded =
      law_by_formula("k*e*(1 + small*sqrt(limit - strain))", {{"k", 4.0}, {"small", 1e-9}, {"limit", 0.3}});
  const LawUse never = law_by_formula("k*e*sqrt(limit - 2)", {{"k", 4.0}, {"limit", 0.3}});
  const auto one = [](Simulation& simulation) { simulation.step(); };
  return {
      {"a law without a finite answer", never, {0.2, 0.0}, 0.01, ten, Expected::failure},
      {"a motion that leaves the domain of its law",
       bounded,
       {0.0, 5.0},
       0.01,
       [](Simulation& simulation) { simulation.advance_to(1.0); },
       Expected::failure},
      {"a step of 1e6 s", oscillator::hooke(), {0.2, 0.0}, 1e6, one},
      {"steps of 1e-12 s", oscillator::hooke(), {0.2, 0.0}, 1e-12, ten},
      {"a stiffness of 1e12 N/m", oscillator::hooke(1e12), {0.2, 0.0}, 0.01, ten},
      {"a stiffness of -1e6 N/m", oscillator::hooke(-1e6), {0.2, 0.0}, 0.01, ten},
      {"a speed of 1e150 m/s", oscillator::hooke(), {0.2, 1e150}, 0.01, ten},
      {"a deadline of 0 s",
       oscillator::hooke(),
       {0.2, 0.0},
       0.01,
       [](Simulation& simulation) { simulation.step_within(0.0); }},
      {"being asked to stop",
       oscillator::hooke(),
       {0.2, 0.0},
       0.01,
       [](Simulation& simulation) {
         simulation.ask_to_stop();
         simulation.step();
       }},
  };
}

// Values at which an option is tried: its bounds, or all choices.
std::vector<double> bounds_of(const springnet_parameter& option) {
  std::vector<double> values;
  if (option.type == SPRINGNET_BOOLEAN) return {0.0, 1.0};
  if (option.type == SPRINGNET_CHOICE) {
    for (std::uint32_t k = 0; k < option.choice_count; ++k) values.push_back(k);
    return values;
  }
  // What excludes its bound: as close as a scene may have it.
  const bool open = (option.flags & SPRINGNET_EXCLUDES_SMALLEST) != 0;
  if (std::isfinite(option.smallest)) {
    const double off =
        option.type == SPRINGNET_INTEGER ? 1.0 : 1e-12 * std::max(std::abs(option.smallest), option.scale);
    values.push_back(open ? option.smallest + off : option.smallest);
  }
  // A count may ask for any amount of work, which is no hang.
  constexpr double most_work = 1000.0;
  const double largest = option.type == SPRINGNET_INTEGER ? std::min(option.largest, most_work) : option.largest;
  if (std::isfinite(largest) && largest > option.smallest) values.push_back(largest);
  if (!std::isfinite(option.largest) && option.type == SPRINGNET_NUMBER) values.push_back(1e9 * option.scale);
  return values;
}

}  // namespace

Outcome check_integrator_refusals(const Component& component, const PluginHost& host) {
  const Trial trial(component, host);
  for (const Hardship& each : hardships()) {
    now_doing(fmt::format("simulating {}", each.what).c_str());
    const std::string wrong =
        ending([&] { return trial.run(pair(each.law, each.start), each.step); }, each.steps, each.expected);
    if (!wrong.empty()) return {Result::failed, fmt::format("given {}, {}", each.what, wrong)};
  }
  return {};
}

Outcome check_integrator_options(const Component& component, const PluginHost& host) {
  const Trial trial(component, host);
  const springnet_component& description = *component.description;
  std::size_t tried = 0;
  const Network net = pair(oscillator::hooke(), {0.2, 0.0});
  for (std::uint32_t i = 0; i < description.parameter_count; ++i) {
    const springnet_parameter& option = *description.parameters[i];
    for (const double value : bounds_of(option)) {
      const std::string name = option.type == SPRINGNET_CHOICE
                                   ? fmt::format("{} = \"{}\"", option.name, option.choices[static_cast<int>(value)])
                                   : fmt::format("{} = {:g}", option.name, value);
      now_doing(fmt::format("making steps with the option {}", name).c_str());
      const std::string wrong = ending(
          [&] {
            return trial.run(net, 0.01, 1, {{option.name, value}});
          },
          [](Simulation& simulation) {
            for (int k = 0; k < 3; ++k) simulation.step();
          },
          Expected::either);
      ++tried;
      if (!wrong.empty())
        return {Result::failed,
                fmt::format("with the option {}, {}: refuse it with a reason, or bound it", name, wrong)};
    }
  }
  return {Result::passed, fmt::format("{} values", tried)};
}

}  // namespace springnet::check
