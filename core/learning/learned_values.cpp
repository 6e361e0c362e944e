#include "learning/learned_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/at_scope_end.hpp"
#include "learning/surface_frictions.hpp"

namespace springnet::learning {

namespace {

using Kind = LearnedValues::Kind;

constexpr std::size_t axes = 3;

// nan: it has none.
[[nodiscard]] double learnable_friction(const Friction& friction) {
  return friction.kind == Friction::Kind::coulomb ? friction.coefficient : std::numeric_limits<double>::quiet_NaN();
}

[[nodiscard]] bool is_of_nodes(Kind kind) { return member_name(kind, false) == "node"; }

[[nodiscard]] std::uint32_t host_kind(Kind kind) {
  switch (kind) {
    case Kind::spring_parameter:
      return SPRINGNET_BY_SPRING_PARAMETER;
    case Kind::viscosity_parameter:
      return SPRINGNET_BY_VISCOSITY_PARAMETER;
    case Kind::rest_length:
      return SPRINGNET_BY_REFERENCE;
    case Kind::neuron_parameter:
      return SPRINGNET_BY_NEURON_PARAMETER;
    default:
      return SPRINGNET_BY_MASS;
  }
}

// What a change makes of a value of this kind: the factor of it; none: the change does not concern it.
[[nodiscard]] std::optional<double> factor_of(const Change& change, const LearnedValues& what) {
  const auto sets = [&](const ParameterValues& values) {
    return values.count(what.parameter) != 0 ? std::optional<double>(0.0) : std::nullopt;
  };
  switch (what.kind) {
    case Kind::spring_parameter:
      return sets(change.spring);
    case Kind::viscosity_parameter:
      return sets(change.viscosity);
    case Kind::rest_length:
      return change.reference ? std::optional<double>(0.0) : change.reference_scale;
    case Kind::mass:
      return change.mass ? std::optional<double>(0.0) : std::nullopt;
    case Kind::neuron_parameter:
      return sets(change.neuron);
    default:
      return std::nullopt;
  }
}
[[nodiscard]] const std::vector<std::uint32_t>& members_of(const Change& change, const LearnedValues& what) {
  return is_of_nodes(what.kind) ? change.nodes : what.of_elements ? change.elements : change.springs;
}

}  // namespace

LearnedSets::LearnedSets(const Network& network, std::vector<LearnedValues> learned) : gravity_(network.gravity()) {
  const auto is_empty = [](const LearnedValues& each) { return each.members.empty(); };
  if (std::all_of(learned.begin(), learned.end(), is_empty))
    throw Error(ErrorKind::input, "learning: there is nothing to be learned");
  for_each_surface(network, [this](const std::string&, const Friction& friction) {
    frictions_.push_back(learnable_friction(friction));
  });
  std::map<std::tuple<Kind, bool, std::string>, std::vector<std::uint8_t>> all_listed;
  for (LearnedValues& each : learned) {
    const std::size_t most = each.kind == Kind::load       ? network.loads().size()
                             : each.kind == Kind::gravity  ? axes
                             : each.kind == Kind::friction ? frictions_.size()
                             : is_of_nodes(each.kind)      ? network.nodes().size()
                             : each.of_elements            ? network.elements().size()
                                                           : network.springs().size();
    std::vector<std::uint8_t>& listed = all_listed[{each.kind, each.of_elements, each.parameter}];
    listed.resize(most);
    for (const std::uint32_t member : each.members) {
      if (member >= most)
        throw Error(ErrorKind::input, fmt::format("learning: {} {} does not exist: the network has {}",
                                                  member_name(each.kind, each.of_elements), member, most));
      if (std::exchange(listed[member], std::uint8_t{1}) != 0)
        throw Error(ErrorKind::input,
                    fmt::format("learning: {} {} is listed twice{}{}", member_name(each.kind, each.of_elements), member,
                                each.parameter.empty() ? "" : ", for its parameter ", each.parameter));
      if (each.kind == Kind::initial_velocity && network.nodes()[member].fixed)
        throw Error(ErrorKind::input, fmt::format("learning: node {} is fixed and has no velocity to learn", member));
      if (each.kind == Kind::friction && std::isnan(frictions_[member]))
        throw Error(ErrorKind::input,
                    fmt::format("learning: surface {} has no coefficient of friction to learn", member));
    }
    Set set;
    set.what = std::move(each);
    set.first = count_;
    count_ += set.size();
    sets_.push_back(std::move(set));
  }
}

void LearnedSets::attach(Engine& engine) {
  const layers::Layout& layout = engine.model().layout;
  for (Set& set : sets_) {
    const LearnedValues& what = set.what;
    set.places = what.members;
    if (is_of_nodes(what.kind)) {
      for (std::uint32_t& each : set.places) each = layout.ordering().engine[each];
      set.values.assign(set.is_velocity() ? 0 : layout.node_count(), 0.0);
    } else if (set.is_of_surroundings()) {
      set.values.assign(what.kind == Kind::gravity    ? axes
                        : what.kind == Kind::friction ? frictions_.size()
                                                      : engine.model().loads.count(),
                        0.0);
    } else {
      set.values.assign(what.of_elements ? layout.elements().count() : layout.spring_count(), 0.0);
    }
  }
  static_cast<void>(values_of(engine));  // throws for a law without the parameter
}

void LearnedSets::check(const Eigen::VectorXd& values) const {
  if (static_cast<std::size_t>(values.size()) != count_)
    throw Error(ErrorKind::input, fmt::format("learning: {} values, must be {}", values.size(), count_));
  for (const Set& set : sets_)
    for (std::size_t i = 0; i < set.size(); ++i)
      if (const double value = values[static_cast<Eigen::Index>(set.first + i)]; !std::isfinite(value))
        throw Error(ErrorKind::input,
                    fmt::format("learning: a value of {} {} is {}", member_name(set.what.kind, set.what.of_elements),
                                set.what.members[set.is_velocity() ? i / 3 : i], value));
}

void LearnedSets::set_factor(Set& set, std::size_t member, double factor) {
  set.sums.resize(set.places.size(), 0.0);
  set.sums[member] += set.factor(member) * std::exchange(set.values[set.places[member]], 0.0);
  set.factors.resize(set.places.size(), 1.0);
  set.factors[member] = factor;
}

void LearnedSets::follow_change(const Change& change) {
  for (Set& set : sets_) {
    if (set.is_velocity() || set.is_of_surroundings()) continue;
    std::vector<Set::Factor>& replaced = set.replaced.emplace_back();
    const std::optional<double> factor = factor_of(change, set.what);
    if (!factor) continue;
    if (set.places_of.empty()) {
      for (std::size_t i = 0; i < set.what.members.size(); ++i) set.places_of.emplace_back(set.what.members[i], i);
      std::sort(set.places_of.begin(), set.places_of.end());
    }
    for (const std::uint32_t number : members_of(change, set.what)) {
      const auto found =
          std::lower_bound(set.places_of.begin(), set.places_of.end(), std::pair(number, std::size_t{0}));
      if (found == set.places_of.end() || found->first != number) continue;
      replaced.push_back({found->second, set.factor(found->second)});
      set_factor(set, found->second, *factor * set.factor(found->second));
    }
  }
}

void LearnedSets::undo_change() {
  for (Set& set : sets_) {
    if (set.is_velocity() || set.is_of_surroundings()) continue;
    for (auto each = set.replaced.back().rbegin(); each != set.replaced.back().rend(); ++each)
      set_factor(set, each->member, each->before);
    set.replaced.pop_back();
  }
}

std::vector<sdk::Host::ParameterSet> LearnedSets::host_sets() {
  std::vector<sdk::Host::ParameterSet> result;
  for (Set& set : sets_) {
    if (set.is_velocity() || set.is_of_surroundings()) continue;
    sdk::Host::ParameterSet each{host_kind(set.what.kind), set.values};
    if (!set.what.parameter.empty()) each.parameter = set.what.parameter.c_str();
    each.of_elements = set.what.of_elements;
    result.push_back(each);
  }
  return result;
}

std::vector<springnet_parameter_set> LearnedSets::sets_along(const Eigen::VectorXd& change,
                                                             std::vector<std::vector<double>>& values) const {
  std::vector<springnet_parameter_set> result;
  values.clear();
  for (const Set& set : sets_) {
    if (set.is_velocity() || set.is_of_surroundings()) continue;
    std::vector<double>& own = values.emplace_back(set.values.size(), 0.0);
    bool changes = false;
    for (std::size_t i = 0; i < set.places.size(); ++i) {
      own[set.places[i]] = change[static_cast<Eigen::Index>(set.first + i)];
      changes = changes || own[set.places[i]] != 0.0;
    }
    if (!changes) continue;
    auto each = sdk::sized<springnet_parameter_set>();
    each.kind = host_kind(set.what.kind);
    each.of_elements = set.what.of_elements ? 1 : 0;
    if (!set.what.parameter.empty()) each.parameter = set.what.parameter.c_str();
    each.values = own.data();  // stays, as the numbers of a vector that is moved do
    result.push_back(each);
  }
  return result;
}

// Loads are linear in their factors, and accelerations in forces; in contact with friction only until nodes begin to
// slide or to stick, so that differences are small there, at the cost of four digits.
Eigen::VectorXd LearnedSets::by_surroundings(Engine& engine, const sdk::Host& host, const springnet_evaluation& at,
                                             const Set& set, std::uint32_t place) {
  Loads& loads = engine.model().loads;
  const double part = engine.model().contact.obstacles().empty() ? 0.5 : 0x1p-14;
  const auto n = static_cast<Eigen::Index>(host.network().node_count);
  const auto accelerations = [&] {
    Eigen::VectorXd result(3 * n);
    springnet_evaluation wanted = at;
    wanted.acceleration = {result.data(), result.data() + n, result.data() + 2 * n};
    host.evaluate(wanted);
    return result;
  };
  if (set.is_friction()) {
    Contact& contact = engine.model().contact;
    if (contact.obstacles().empty()) return Eigen::VectorXd::Zero(3 * n);
    const double before = contact.obstacles()[place].friction().coefficient;
    const AtScopeEnd back([&] { contact.set_friction(place, before); });
    const double low = std::max(0.0, before - part);
    contact.set_friction(place, before + part);
    const Eigen::VectorXd more = accelerations();
    contact.set_friction(place, low);
    return (more - accelerations()) / (before + part - low);
  }
  if (set.what.kind == Kind::gravity) {
    const Vector3 before = loads.gravity();
    const AtScopeEnd back([&] { loads.set_gravity(before); });
    const double size = std::max(1.0, before.norm());  // differences of its own size lose no digits
    loads.set_gravity(before + part * size * Vector3::Unit(place));
    const Eigen::VectorXd more = accelerations();
    loads.set_gravity(before - part * size * Vector3::Unit(place));
    return (more - accelerations()) / (2.0 * part * size);
  }
  const double factor = loads.factor(place);
  const AtScopeEnd back([&] { loads.set_factor(place, factor); });
  loads.set_factor(place, factor + part);
  const Eigen::VectorXd more = accelerations();
  loads.set_factor(place, factor - part);
  return (more - accelerations()) / (2.0 * part);
}

void LearnedSets::tangents(Engine& engine, const sdk::Host& host, const springnet_evaluation& at,
                           const Eigen::MatrixXd& changes, Eigen::MatrixXd& accelerations,
                           const std::function<double*(Eigen::Index)>& internal) {
  accelerations.resize(3 * static_cast<Eigen::Index>(host.network().node_count), changes.cols());
  for (Eigen::Index j = 0; j < changes.cols(); ++j) {
    for (Set& set : sets_) {
      if (set.is_velocity()) continue;
      std::fill(set.values.begin(), set.values.end(), 0.0);
      for (std::size_t i = 0; i < set.places.size(); ++i)
        set.values[set.places[i]] = set.factor(i) * changes(static_cast<Eigen::Index>(set.first + i), j);
    }
    double* const of_states = internal ? internal(j) : nullptr;
    if (const std::vector<sdk::Host::ParameterSet> sets = host_sets(); !sets.empty()) {
      host.parameter_tangent(at, sets, {nullptr, accelerations.col(j).data(), of_states});
    } else {
      accelerations.col(j).setZero();
      if (of_states != nullptr) std::fill_n(of_states, host.network().internal_count, 0.0);
    }
  }
  for (const Set& set : sets_)
    for (std::size_t i = 0; set.is_of_surroundings() && i < set.places.size(); ++i)
      if (const auto row = changes.row(static_cast<Eigen::Index>(set.first + i)); !row.isZero(0.0))
        accelerations += by_surroundings(engine, host, at, set, set.places[i]) * row;
}

void LearnedSets::begin_cotangent() {
  for (Set& set : sets_) {
    std::fill(set.values.begin(), set.values.end(), 0.0);
    set.sums.clear();
  }
}

void LearnedSets::add_cotangent(Engine& engine, const sdk::Host& host, const springnet_evaluation& at, double* weights,
                                double* internal_weights) {
  const std::vector<sdk::Host::ParameterSet> sets = host_sets();
  // Of values that accelerations depend on by forces alone these are enough, with the derivatives at hand.
  const bool by_forces = engine.model().contact.obstacles().empty() && !engine.model().rigid.any() &&
                         std::none_of(sets_.begin(), sets_.end(), [](const Set& set) {
                           return set.what.kind == Kind::mass || set.what.kind == Kind::neuron_parameter;
                         });
  if (by_forces && !sets.empty()) {
    force_weights_.resize(3 * std::size_t{host.network().node_count});
    engine.linear().matrices().force_weights(weights, force_weights_.data());
    host.parameter_cotangent(at, sets, {force_weights_.data(), nullptr, internal_weights});
  } else if (!sets.empty()) {
    host.parameter_cotangent(at, sets, {nullptr, weights, internal_weights});
  }
  for (Set& set : sets_)
    for (std::size_t i = 0; set.is_of_surroundings() && i < set.places.size(); ++i)
      set.values[set.places[i]] +=
          Eigen::Map<const Eigen::VectorXd>(weights, 3 * static_cast<Eigen::Index>(host.network().node_count))
              .dot(by_surroundings(engine, host, at, set, set.places[i]));
}

Eigen::VectorXd LearnedSets::event_gradient(const sdk::Host& host, const springnet_evaluation& at, std::uint32_t event,
                                            double* by_position, double* by_velocity, double& by_time) {
  std::vector<std::pair<std::vector<double>, std::vector<double>>> before;
  for (Set& set : sets_) {
    before.emplace_back(set.values, std::exchange(set.sums, {}));
    std::fill(set.values.begin(), set.values.end(), 0.0);
  }
  by_time = host.event_derivative(at, event, by_position, by_velocity, host_sets());
  const Eigen::VectorXd result =
      cotangent(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(host.network().node_count)));
  for (std::size_t i = 0; i < before.size(); ++i) std::tie(sets_[i].values, sets_[i].sums) = std::move(before[i]);
  return result;
}

void LearnedSets::add_gradient(const Eigen::VectorXd& by_values) {
  for (Set& set : sets_) {
    if (set.is_velocity()) continue;
    set.sums.resize(set.places.size(), 0.0);
    for (std::size_t i = 0; i < set.places.size(); ++i)
      set.sums[i] += by_values[static_cast<Eigen::Index>(set.first + i)];
  }
}

Eigen::VectorXd LearnedSets::cotangent(const Eigen::VectorXd& by_velocity) const {
  Eigen::VectorXd result(static_cast<Eigen::Index>(count_));
  const Eigen::Index nodes = by_velocity.size() / 3;
  for (const Set& set : sets_) {
    auto next = static_cast<Eigen::Index>(set.first);
    for (std::size_t i = 0; i < set.places.size(); ++i) {
      const std::uint32_t place = set.places[i];
      if (set.is_velocity())
        for (Eigen::Index axis = 0; axis < 3; ++axis) result[next++] = by_velocity[axis * nodes + place];
      else
        result[next++] = set.sum(i);
    }
  }
  return result;
}

bool LearnedSets::has_friction() const noexcept {
  return std::any_of(sets_.begin(), sets_.end(), [](const Set& set) { return set.is_friction(); });
}

bool LearnedSets::has_friction_of(std::int32_t surface) const noexcept {
  return std::any_of(sets_.begin(), sets_.end(), [surface](const Set& set) {
    return set.is_friction() &&
           std::find(set.places.begin(), set.places.end(), static_cast<std::uint32_t>(surface)) != set.places.end();
  });
}

Eigen::VectorXd LearnedSets::friction_changes(const Eigen::VectorXd& change) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(frictions_.size()));
  for (const Set& set : sets_)
    for (std::size_t i = 0; set.is_friction() && i < set.places.size(); ++i)
      result[set.places[i]] += change[static_cast<Eigen::Index>(set.first + i)];
  return result;
}

void LearnedSets::add_to_friction(const Eigen::VectorXd& by_friction) {
  for (Set& set : sets_)
    for (std::size_t i = 0; set.is_friction() && i < set.places.size(); ++i)
      set.values[set.places[i]] += by_friction[set.places[i]];
}

Eigen::VectorXd LearnedSets::friction_gradient(std::int32_t surface, double by_friction) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(count_));
  for (const Set& set : sets_)
    for (std::size_t i = 0; set.is_friction() && i < set.places.size(); ++i)
      if (set.places[i] == static_cast<std::uint32_t>(surface))
        result[static_cast<Eigen::Index>(set.first + i)] = by_friction;
  return result;
}

Eigen::VectorXd LearnedSets::mass_gradient(const Eigen::VectorXd& by_mass) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(count_));
  for (const Set& set : sets_)
    for (std::size_t i = 0; set.what.kind == Kind::mass && i < set.places.size(); ++i)
      result[static_cast<Eigen::Index>(set.first + i)] = set.factor(i) * by_mass[set.places[i]];
  return result;
}

std::vector<std::uint32_t> LearnedSets::with_start_velocities() const {
  std::vector<std::uint32_t> result;
  for (const Set& set : sets_)
    if (set.is_velocity()) result.insert(result.end(), set.what.members.begin(), set.what.members.end());
  return result;
}

Eigen::VectorXd LearnedSets::mass_changes(const Eigen::VectorXd& change, std::size_t nodes) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(nodes));
  for (const Set& set : sets_)
    for (std::size_t i = 0; set.what.kind == Kind::mass && i < set.places.size(); ++i)
      result[set.places[i]] += set.factor(i) * change[static_cast<Eigen::Index>(set.first + i)];
  return result;
}

void LearnedSets::add_to_masses(const Eigen::VectorXd& by_mass) {
  for (Set& set : sets_)
    for (std::size_t i = 0; set.what.kind == Kind::mass && i < set.places.size(); ++i)
      set.values[set.places[i]] += by_mass[set.places[i]];
}

void LearnedSets::start_velocity(const Eigen::VectorXd& change, Eigen::VectorXd& velocities) const {
  const Eigen::Index nodes = velocities.size() / 3;
  for (const Set& set : sets_) {
    if (!set.is_velocity()) continue;
    auto next = static_cast<Eigen::Index>(set.first);
    for (const std::uint32_t place : set.places)
      for (Eigen::Index axis = 0; axis < 3; ++axis) velocities[axis * nodes + place] += change[next++];
  }
}

}  // namespace springnet::learning
