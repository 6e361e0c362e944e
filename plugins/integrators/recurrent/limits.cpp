#include "limits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace springnet::recurrent {
namespace {

constexpr std::array all_rules{Update::synchronous, Update::wavefront, Update::block, Update::coloured, Update::newton};
// Times the first guess: no limit is looked for beyond. Motions that nothing resists have a factor of 1 in a sweep of
// blocks, but for rounding, which grows with the step.
constexpr double reach = 1e5, reach_of_blocks = 1e3;

bool solves_blocks(Update update) { return update == Update::block || update == Update::coloured; }

// Sweeps of a rule as a map of x = sqrt(m) u.
class RuleMap {
 public:
  // force: N, at the committed state.
  RuleMap(const springnet_network& network, Rule& rule, const sdk::LinearisedNetwork& linearised,
          const springnet_vectors& force)
      : rule_(rule),
        root_(linearised.root_mass()),
        zero_(root_.size(), 0.0),
        position_(root_.size()),
        velocity_(root_.size()),
        start_(state_of(zero_, zero_, force)),
        outputs_(state_of(position_, velocity_, force)),
        step_{0.0, 1.0, 1.0, 1.0, 0.0, start_, network, false} {
    step_.is_linear = true;
    step_.free_position = sdk::view(start_.position);
    step_.free_velocity = sdk::view(start_.velocity);
    step_.outputs = &outputs_;
    rule_.begin_linear(step_);
  }
  RuleMap(const RuleMap&) = delete;
  RuleMap& operator=(const RuleMap&) = delete;

  void set_step(double weight) noexcept { step_.time_constant = weight; }
  void apply(double* x) {
    for (std::size_t i = 0; i < root_.size(); ++i) {
      velocity_[i] = x[i] / root_[i];
      position_[i] = step_.weight() * velocity_[i];
    }
    rule_.linear_sweep(step_);
    for (std::size_t i = 0; i < root_.size(); ++i) x[i] = root_[i] * velocity_[i];
  }

 private:
  static springnet_vectors vectors_of(std::vector<double>& values) {
    const std::size_t n = values.size() / 3;
    return {values.data(), values.data() + n, values.data() + 2 * n};
  }
  static springnet_state state_of(std::vector<double>& position, std::vector<double>& velocity,
                                  const springnet_vectors& force) {
    auto state = sdk::sized<springnet_state>();
    state.position = vectors_of(position);
    state.velocity = vectors_of(velocity);
    state.force = force;
    return state;
  }

  Rule& rule_;
  const std::vector<double>& root_;
  std::vector<double> zero_, position_, velocity_;
  springnet_state start_, outputs_;
  Step step_;
};

sdk::Limit limit_of(const sdk::Host& host, Update update, RuleMap& map, const sdk::LinearisedNetwork& network,
                    double guess, double theta) {
  using Search = sdk::StepSearch<RuleMap>;
  const springnet_network& known = host.network();
  Search::Settings settings;
  settings.may_be_none = solves_blocks(update);
  settings.reach = solves_blocks(update) ? reach_of_blocks : reach;
  settings.vectors = network.max_vectors();
  // Seconds for a network of 100,000 nodes.
  const double work = 2.0 * static_cast<double>(known.spring_count) + known.node_count + 1.0;
  settings.applications = static_cast<std::uint64_t>(std::clamp(2e8 / work, 60.0, 20000.0));
  Search search(host, map, network.start(), settings);
  const std::optional<double> weight = search.run(guess);
  if (!weight) return {};
  return {search.is_accurate() ? std::uint32_t{SPRINGNET_LIMIT_KNOWN} : std::uint32_t{SPRINGNET_LIMIT_ESTIMATE},
          *weight / theta,
          *weight,
          network.node_of(search.mode()),
          {}};
}

}  // namespace

void report_limits(Workspace& workspace, double theta, const std::function<Rule&(Update)>& rule,
                   const sdk::LimitSink& sink) {
  const sdk::Host& host = workspace.host;
  const auto [time, state] = host.committed();
  if (host.network().node_count == 0) {
    for (const Update update : all_rules) sink.none(name_of(update));
    return;
  }
  try {
    host.linearise(sdk::evaluation_at(time, state));
  } catch (const sdk::Failure& failure) {
    for (const Update update : all_rules) {
      if (rule(update).has_linear_sweep())
        sink.unknown(name_of(update), failure.what());
      else
        sink.none(name_of(update));
    }
    return;
  }
  sdk::LinearisedNetwork network(host);
  const std::optional<double> guess = network.first_guess();
  Columns force;
  force.resize(host.network().node_count);
  springnet_evaluation evaluation = sdk::evaluation_at(time, state);
  evaluation.force = force.view();
  host.evaluate(evaluation);
  // Where A is symmetric and I + A positive definite, node by node (Gauss and Seidel) converges in every order
  // (Ostrowski, Reich). Where it is not definite any more, a step has several solutions, and a rule that goes downhill,
  // as these do, ends at one of them.
  const bool symmetric = !guess || network.is_symmetric(*guess);
  for (const Update update : all_rules) {
    Rule& each = rule(update);
    if (!guess || !each.has_linear_sweep() || (symmetric && solves_blocks(update))) {
      sink.none(name_of(update));
      continue;
    }
    RuleMap map(host.network(), each, network, force.view());
    sink.report(name_of(update), limit_of(host, update, map, network, *guess, theta));
  }
}

}  // namespace springnet::recurrent
