#include "inspection/limits.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <springnet/sdk/limits.hpp>

#include "constraints/body_contacts.hpp"

namespace springnet {
namespace {

TimeConstantLimit::Kind kind_of(std::uint32_t kind) {
  switch (kind) {
    case SPRINGNET_LIMIT_KNOWN:
      return TimeConstantLimit::Kind::known;
    case SPRINGNET_LIMIT_ESTIMATE:
      return TimeConstantLimit::Kind::estimate;
    case SPRINGNET_LIMIT_NONE:
      return TimeConstantLimit::Kind::none;
    default:
      return TimeConstantLimit::Kind::unknown;
  }
}

// The spring or element with the greatest share at a node, for the weight w, s.
Bottleneck bottleneck(const StartingNetwork& start, NodeIndex node, double w) {
  constexpr double alike = 1.0 - 1e-3;  // differences below are rounding: the lowest number wins
  Bottleneck result{node, start.network().nodes()[node].mass, std::nullopt, std::nullopt, 0.0, 0.0, 0.0, 0.0};
  double greatest = 0.0;
  const auto offer = [&](double stiffness, double damping, std::optional<SpringIndex> spring,
                         std::optional<ElementIndex> element) {
    const double elastic = w * w * stiffness / result.mass, viscous = w * damping / result.mass;
    const double share = std::abs(elastic) + std::abs(viscous);
    if (!(share * alike > greatest)) return;
    greatest = share;
    result = {node, result.mass, spring, element, stiffness, damping, elastic, viscous};
  };
  const std::uint32_t k = start.engine_node(node);
  std::vector<SpringIndex> springs;
  for (const layers::Incident* i = start.layout().incident_begin(k); i != start.layout().incident_end(k); ++i)
    springs.push_back(i->spring);
  // By the number of the other node, then the spring's.
  std::sort(springs.begin(), springs.end(), [&](SpringIndex a, SpringIndex b) {
    const auto other = [&](SpringIndex s) {
      const Spring& spring = start.network().springs()[s];
      return spring.first == node ? spring.second : spring.first;
    };
    return std::pair(other(a), a) < std::pair(other(b), b);
  });
  for (const SpringIndex s : springs)
    offer(start.springs()[s].stiffness, start.springs()[s].damping(), s, std::nullopt);
  std::vector<layers::ElementShare> shares(start.layout().elements().shares(k).begin(),
                                           start.layout().elements().shares(k).end());
  std::sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.element < b.element; });
  for (const layers::ElementShare& share : shares) {
    const ElementAtStart& element = start.elements()[share.element];
    if (element.own_stiffness.empty()) continue;
    offer(element.own_stiffness[share.place], element.own_damping[share.place], std::nullopt, share.element);
  }
  return result;
}

// Whether springs and elements certainly feed no energy into any motion. Sufficient, not necessary.
bool plainly_definite(const StartingNetwork& start) {
  const Network& network = start.network();
  // Smaller forces, relative to stiffness times size, are rounding.
  constexpr double no_load = 1e-12;
  const auto follows = [](const Load& load) { return load.follow && load.pressure != 0.0; };
  return std::all_of(start.springs().begin(), start.springs().end(),
                     [](const SpringAtStart& s) {
                       const bool pushes = s.length > 0.0 && s.tension < -no_load * s.stiffness * s.length;
                       return !(s.stiffness < 0.0) && !pushes && !(s.axial_damping < 0.0) && !(s.general_damping < 0.0);
                     }) &&
         std::all_of(start.elements().begin(), start.elements().end(),
                     [](const ElementAtStart& e) { return e.definite; }) &&
         std::none_of(network.loads().begin(), network.loads().end(), follows);
}

// The weight w up to which I + A, with A = w^2 M^-1 K + w M^-1 D, is positive definite: there the greatest eigenvalue
// of -A reaches 1.
std::optional<double> unique_weight(const StartingNetwork& start) {
  LimitSurvey& survey = *start.survey();
  const sdk::Host host(survey.table());
  const auto [time, state] = host.committed();
  try {
    host.begin_interval(time, time + 1.0);
    host.linearise(sdk::evaluation_at(time, state));
    if (plainly_definite(start) && survey.engine().linear().matrices().neurons_dissipate()) return std::nullopt;
    sdk::LinearisedNetwork network(host);
    const std::optional<double> guess = network.first_guess();
    if (!guess || !network.is_symmetric(*guess)) return std::nullopt;
    std::vector<double> x = network.start();
    const double w = sdk::critical_step(host, *guess, x, network.max_vectors(),
                                        [&](double h, double* values) { network.times(h * h, h, values); });
    constexpr double max_factor = 1e3;  // of the guess: a limit beyond does not matter
    return w <= max_factor * *guess ? std::optional(w) : std::nullopt;
  } catch (const sdk::Failure&) {  // a law without derivatives
    return std::nullopt;
  }
}

}  // namespace

void find_limits(const StartingNetwork& start, const PluginHost& plugins, Inspection& result) {
  result.unknown_because = start.failure();
  const LawUse& used = result.options.integrator;
  std::vector<std::shared_ptr<const Component>> integrators;
  for (const auto& component : plugins.components())
    if (component->kind() == ComponentKind::integrator) integrators.push_back(component);
  // Others refuse bodies in contact.
  std::uint64_t needed = start.network().contacts().empty() ? 0 : SPRINGNET_KEEPS_BODIES_APART;
  if (are_any_rigid(start.network())) needed |= SPRINGNET_KEEPS_RIGID_BODIES_APART;
  std::erase_if(integrators,
                [&](const auto& component) { return (component->description->capabilities & needed) != needed; });
  // The scene's integrator first.
  std::stable_sort(integrators.begin(), integrators.end(), [&](const auto& a, const auto& b) {
    return std::pair(a->id() != used.id, a->id()) < std::pair(b->id() != used.id, b->id());
  });
  for (const auto& component : integrators) {
    if (start.survey() == nullptr) break;
    const bool is_used = component->id() == used.id;
    for (ReportedLimit& reported : start.survey()->ask(*component, is_used ? used.parameters : ParameterValues{})) {
      TimeConstantLimit limit;
      limit.integrator = component->id();
      limit.rule = std::move(reported.rule);
      limit.kind = kind_of(reported.kind);
      limit.time_constant = reported.time_step;
      limit.reason = std::move(reported.reason);
      if (reported.node) limit.set_by = bottleneck(start, *reported.node, reported.weight);
      if (limit.kind == TimeConstantLimit::Kind::unknown && result.unknown_because.empty())
        result.unknown_because = limit.reason;
      result.limits.push_back(std::move(limit));
    }
  }
  if (start.survey() == nullptr) return;
  if (const std::optional<double> w = unique_weight(start)) result.unique_time_constant = *w / result.options.theta();
}

}  // namespace springnet
