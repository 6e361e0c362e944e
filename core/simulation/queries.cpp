// What a host asks of a simulation: maps of all springs and nodes, what is where, limits of the time step.
#include <springnet/simulation.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "constraints/vectors.hpp"
#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"
#include "simulation/implementation.hpp"
#include "simulation/limit_survey.hpp"

namespace springnet {
namespace {

void check_point(const Vector3& point, const char* what) {
  if (!point.allFinite())
    throw Error(ErrorKind::input,
                fmt::format("{}: the point ({}, {}, {}) is not finite", what, point[0], point[1], point[2]));
}

// Whether all spring functions of what is left have an energy.
bool have_energies(const layers::Layout& layout, bool of_elements) {
  const std::vector<layers::Group>& groups = layout.laws().groups;
  const auto lacks = [&](std::size_t group) {
    return groups[group].spring && !groups[group].spring.can(SPRINGNET_HAS_ENERGY);
  };
  if (of_elements) {
    for (std::uint32_t e = 0; e < layout.elements().count(); ++e)
      if (layout.elements().alive(e) && lacks(layout.elements().group(e))) return false;
    return true;
  }
  for (std::size_t g = 0; g < groups.size(); ++g)
    if (lacks(g) && !layout.springs_of(g).empty()) return false;
  return true;
}

}  // namespace

ConstNodeMap Simulation::reactions() const {
  const std::uint32_t n = impl_->engine.model().node_count();
  const std::size_t pitch = pitch_of(n);
  KeptNumbers& kept = impl_->kept_reactions;
  if (kept.version != impl_->state_version) {
    const std::vector<Vector3>& reactions = impl_->engine.reactions().node;
    kept.numbers.assign(3 * pitch, 0.0);
    for (std::uint32_t k = 0; k < n; ++k)
      for (std::size_t c = 0; c < 3; ++c) kept.numbers[c * pitch + k] = reactions[k][static_cast<Eigen::Index>(c)];
    kept.version = impl_->state_version;
  }
  return {kept.numbers.data(), 3, static_cast<Eigen::Index>(n), Eigen::OuterStride<>(static_cast<Eigen::Index>(pitch))};
}

ConstValueMap Simulation::tensions() const {
  KeptNumbers& kept = impl_->kept_tensions;
  if (kept.version != impl_->state_version) {
    tensions(kept.numbers);
    kept.version = impl_->state_version;
  }
  return {kept.numbers.data(), static_cast<Eigen::Index>(kept.numbers.size())};
}

ConstValueMap Simulation::spring_energies() const {
  KeptNumbers& kept = impl_->kept_energies;
  if (kept.version != impl_->state_version) {
    spring_energies(kept.numbers);
    kept.version = impl_->state_version;
  }
  return {kept.numbers.data(), static_cast<Eigen::Index>(kept.numbers.size())};
}

Eigen::Matrix3Xd Simulation::in_user_order(const ConstNodeMap& map) const {
  const std::vector<std::uint32_t>& columns = this->columns();
  const auto n = static_cast<Eigen::Index>(columns.size());
  if (map.cols() != n)
    throw Error(ErrorKind::input,
                fmt::format("in_user_order: the map has {} columns, the network {} nodes", map.cols(), n));
  Eigen::Matrix3Xd result(3, n);
  for (Eigen::Index k = 0; k < n; ++k) result.col(k) = map.col(columns[static_cast<std::size_t>(k)]);
  return result;
}

Energies Simulation::energies() const {
  const Model& model = impl_->engine.model();
  const layers::NodeArrays nodes = model.state.nodes();
  const InstructionSet set = model.evaluator.instruction_set();
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  Energies result;
  result.kinetic = kinetic_energy();
  result.springs =
      have_energies(model.layout, false) ? layers::spring_energy(model.layout, set, model.time, nodes) : unknown;
  result.elements =
      have_energies(model.layout, true) ? layers::element_energy(model.layout, set, model.time, nodes) : unknown;
  for (std::uint32_t k = 0; k < model.node_count(); ++k)
    result.gravity -= model.mass[k] * model.loads.gravity().dot(vector_at(model.state.view.position, k));
  return result;
}

std::vector<SpringIndex> Simulation::springs_of(NodeIndex node) const {
  const std::uint32_t k = impl_->engine_node(node);
  const layers::Layout& layout = impl_->engine.model().layout;
  std::vector<SpringIndex> springs;
  for (const layers::Incident* each = layout.incident_begin(k); each != layout.incident_end(k); ++each)
    springs.push_back(each->spring);
  std::sort(springs.begin(), springs.end());
  return springs;
}

std::vector<ElementIndex> Simulation::elements_of(NodeIndex node) const {
  const std::uint32_t k = impl_->engine_node(node);
  std::vector<ElementIndex> elements;
  for (const layers::ElementShare& each : impl_->engine.model().layout.elements().shares(k))
    elements.push_back(each.element);
  std::sort(elements.begin(), elements.end());
  elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
  return elements;
}

std::optional<NodeIndex> Simulation::nearest_node(const Vector3& point) const {
  check_point(point, "nearest_node");
  const springnet_vectors& p = impl_->engine.model().state.view.position;
  const std::vector<std::uint32_t>& user = impl_->engine.model().layout.ordering().user;
  double least = std::numeric_limits<double>::infinity();
  NodeIndex nearest = std::numeric_limits<NodeIndex>::max();
  for (std::size_t k = 0; k < user.size(); ++k) {
    const double x = p.x[k] - point[0], y = p.y[k] - point[1], z = p.z[k] - point[2];
    const double square = x * x + y * y + z * z;
    if (square > least || (square == least && user[k] > nearest)) continue;
    least = square;
    nearest = user[k];
  }
  return user.empty() ? std::nullopt : std::optional<NodeIndex>(nearest);
}

std::optional<NearestSpring> Simulation::nearest_spring(const Vector3& point) const {
  check_point(point, "nearest_spring");
  const layers::Layout& layout = impl_->engine.model().layout;
  const springnet_vectors& p = impl_->engine.model().state.view.position;
  std::optional<NearestSpring> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t s = 0; s < layout.spring_count(); ++s) {
    if (!layout.alive(s)) continue;
    const Vector3 a = vector_at(p, layout.first(s)), ab = vector_at(p, layout.second(s)) - a;
    const double square = ab.squaredNorm();
    const double along = square > 0.0 ? std::clamp((point - a).dot(ab) / square, 0.0, 1.0) : 0.0;
    const Vector3 at = a + along * ab;
    const double distance = (point - at).squaredNorm();
    if (nearest && !(distance < least)) continue;
    least = distance;
    nearest = {s, 0.0, along, at};
  }
  if (nearest) nearest->distance = (point - nearest->point).norm();
  return nearest;
}

std::vector<TimeStepLimit> Simulation::time_step_limits() const {
  const Impl& impl = *impl_;
  // Integrators look at the committed state of an engine in which they begin an interval. The run's own engine would
  // take that for a change, so a second one takes up its state.
  SimulationOptions options = impl.options;
  options.profiler.reset();
  LimitSurvey survey(*impl.network, *impl.plugins, options);
  std::string state;
  Archive keep(&state);
  impl.engine.archive(keep);
  Archive take{std::string_view(state)};
  survey.engine().archive(take);
  std::vector<TimeStepLimit> limits;
  for (ReportedLimit& each : survey.ask(*impl.component, impl.options.integrator.parameters)) {
    TimeStepLimit limit{std::move(each.rule), std::numeric_limits<double>::quiet_NaN(), each.node,
                        std::move(each.reason)};
    if (each.kind == SPRINGNET_LIMIT_KNOWN || each.kind == SPRINGNET_LIMIT_ESTIMATE) limit.time_step = each.time_step;
    if (each.kind == SPRINGNET_LIMIT_NONE) limit.time_step = std::numeric_limits<double>::infinity();
    limits.push_back(std::move(limit));
  }
  return limits;
}

}  // namespace springnet
