#include "learning/cluster_event.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "constraints/vectors.hpp"
#include "learning/node_vectors.hpp"
#include "learning/settled_difference.hpp"
#include "simulation/reactions_at.hpp"
#include "simulation/settling.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using EventKind = LocatedEvent::Kind;

// Of lengths, speeds, accelerations and masses. Lengths and rates are kept to 1e-13: differences are good to some 1e-8.
constexpr double share = 2e-5;
// Values that are typical change by this share of themselves over the shortest time.
constexpr double steepest = 2e-5;

double largest(const VectorXd& values) { return values.size() == 0 ? 0.0 : values.cwiseAbs().maxCoeff(); }

std::optional<ContactEvents::Source::Kind> source_of(EventKind kind) {
  using Source = ContactEvents::Source::Kind;
  if (kind == EventKind::release) return Source::release;
  if (kind == EventKind::slip) return Source::slip;
  return std::nullopt;
}

}  // namespace

// What carrying out an event changes in an engine besides contacts, but for sums and texts that nothing depends on:
// impulses of surfaces, the revision, notes. Put back at the end of a scope.
struct ClusterEvent::Kept {
  explicit Kept(Model& of)
      : model(of),
        stale(of.stale),
        touches(of.recent_touches),
        slips(of.recent_slips),
        mass(of.mass),
        events(of.journal.events().size()) {
    const springnet_state& now = of.state.view;
    for (const springnet_vectors* vectors : {&now.position, &now.velocity})
      for (const double* values : {vectors->x, vectors->y, vectors->z})
        state.insert(state.end(), values, values + of.node_count());
    internal.assign(now.internal, now.internal + of.state.internal_count);
  }
  ~Kept() {
    forget();
    std::copy(mass.begin(), mass.end(), model.mass.begin());  // in place: others have the address
    springnet_state& now = model.state.view;
    const double* from = state.data();
    for (const springnet_vectors* vectors : {&now.position, &now.velocity})
      for (double* values : {vectors->x, vectors->y, vectors->z}) {
        std::copy_n(from, model.node_count(), values);
        from += model.node_count();
      }
    std::copy(internal.begin(), internal.end(), now.internal);
  }
  Kept(const Kept&) = delete;
  Kept& operator=(const Kept&) = delete;
  // What does not belong to the state.
  void forget() const {
    model.stale = stale;
    model.recent_touches = touches;
    model.recent_slips = slips;
    model.journal.forget_events(events);
  }

  Model& model;
  decltype(Model::stale) stale;
  RecentTouches touches, slips;
  std::vector<double> mass, state, internal;
  std::size_t events;
};

ClusterEvent::ClusterEvent(Engine& engine, const LocatedEvent& event, const State& state, Begin begin, Placed placed)
    : engine_(engine),
      model_(engine.model()),
      event_(event),
      state_(state),
      begin_(std::move(begin)),
      placed_(std::move(placed)) {
  const RigidConnections& rigid = model_.rigid;
  cluster_ = rigid.cluster_of()[event.index];
  nodes_ = rigid.nodes_of(cluster_);
  const auto place_of = [&](std::uint32_t node) {
    return std::lower_bound(nodes_.begin(), nodes_.end(), node) - nodes_.begin();
  };
  for (const RigidConnections::Rod& rod : rigid.rods()) {
    if (rigid.cluster_of()[rod.first] != cluster_) continue;
    rods_.push_back({place_of(rod.first), place_of(rod.second), rod.length});
    length_ = std::max(length_, rod.length);
  }
  const auto count = static_cast<Index>(nodes_.size());
  mobility_.resize(count);
  found_.mass.resize(count);
  for (Index i = 0; i < count; ++i) {
    const std::uint32_t k = nodes_[static_cast<std::size_t>(i)];
    found_.mass[i] = model_.mass[k];
    mobility_[i] = model_.contact.fixed()[k] != 0 ? 0.0 : 1.0 / model_.mass[k];
  }
  found_.p = gather(state.p);
  found_.v = gather(state.v);
  found_.time = state.time;
}

bool ClusterEvent::has_condition(LocatedEvent::Kind kind) { return source_of(kind).has_value(); }

VectorXd ClusterEvent::gather(const VectorXd& of) const {
  VectorXd result(static_cast<Index>(3 * nodes_.size()));
  for (std::size_t i = 0; i < nodes_.size(); ++i) result.segment<3>(static_cast<Index>(3 * i)) = node_of(of, nodes_[i]);
  return result;
}

bool ClusterEvent::surfaces_move() const {
  const auto moves = [&](std::int32_t surface) {
    return surface >= 0 && model_.contact.obstacles()[static_cast<std::size_t>(surface)].moves();
  };
  return moves(event_.surface) ||
         std::any_of(event_.cluster.begin(), event_.cluster.end(), [&](const NodeChange& each) {
           const auto of = each.before.surfaces();
           return std::any_of(of.begin(), of.end(), moves);
         });
}

// All nodes as the event found them.
void ClusterEvent::write_state() {
  const springnet_state& now = model_.state.view;
  for (std::uint32_t k = 0; k < model_.node_count(); ++k) {
    put_vector(now.position, k, node_of(state_.p, k));
    put_vector(now.velocity, k, node_of(state_.v, k));
  }
  std::copy_n(state_.z.data(), state_.z.size(), now.internal);
  begun_ = std::numeric_limits<double>::quiet_NaN();
}

void ClusterEvent::begin_with(const Input& input) {
  Contact& contact = model_.contact;
  if (input.time != begun_) {
    begin_(input.time);
    begun_ = input.time;
    slips_.clear();
    for (const NodeChange& each : event_.cluster) {
      const bool is_kept = contact.slip_phase(each.node) != Contact::Slip::ongoing;
      slips_.push_back({each.node, is_kept ? contact.slip(each.node) : each.slip, contact.slip_phase(each.node)});
    }
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    contact.touch(nodes_[i], event_.cluster[i].before, Vector3::Zero());
    contact.set_braced(nodes_[i], false);
    if (event_.cluster[i].before.slides) contact.set_slip(nodes_[i], slips_[i].direction, slips_[i].phase);
    const auto at = static_cast<Index>(i);
    put_vector(model_.state.view.position, nodes_[i], input.p.segment<3>(3 * at));
    put_vector(model_.state.view.velocity, nodes_[i], input.v.segment<3>(3 * at));
    model_.mass[nodes_[i]] = input.mass[at];
  }
}

double ClusterEvent::largest_of_moving(const VectorXd& of_nodes) const {
  double result = 0.0;
  const Index each = of_nodes.size() / mobility_.size();
  for (Index k = 0; k < of_nodes.size(); ++k)
    if (mobility_[k / each] > 0.0) result = std::max(result, std::abs(of_nodes[k]));
  return result;
}

// ---- when it happens ------------------------------------------------------------------------------------------------

std::optional<VectorXd> ClusterEvent::value(const Input& input, const VectorXd& free) {
  begin_with(input);
  const springnet_state& now = model_.state.view;
  ReactionsAt reactions(model_, input.time, read_only(now.position), read_only(now.velocity), model_.state.internal,
                        placed_(input.time));
  std::vector<Vector3> accelerations;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    accelerations.emplace_back(free.segment<3>(static_cast<Index>(3 * i)));
  reactions.give(nodes_, std::move(accelerations));
  const ContactEvents::Source source{*source_of(event_.kind), event_.index, static_cast<std::uint32_t>(event_.surface)};
  VectorXd result(1);
  if (engine_.contact_events().value(source, reactions, result[0]) != SPRINGNET_OK) return std::nullopt;
  return result;
}

std::optional<ClusterCondition> ClusterEvent::condition(const VectorXd& accelerations) {
  const Kept kept(model_);
  write_state();
  const VectorXd free = gather(accelerations);
  const std::optional<VectorXd> here = value(found_, free);
  if (!here) return std::nullopt;
  // change(input, accelerations, h): moves them along what the number is by.
  const auto by = [&](const auto& change, double h, double typical, double& to) {
    const auto at = [&](double way) {
      Input input = found_;
      VectorXd other = free;
      change(input, other, way);
      return value(input, other);
    };
    const std::optional<VectorXd> found = settled_difference(at, *here, h, typical);
    if (found) to = (*found)[0];
    return found.has_value();
  };
  const auto count = static_cast<Index>(nodes_.size());
  ClusterCondition result;
  for (VectorXd* each : {&result.by_position, &result.by_velocity, &result.by_acceleration}) each->setZero(3 * count);
  result.by_mass.setZero(count);
  const double speed = speed_or_typical(largest_of_moving(found_.v));
  const double acceleration = std::max(largest_of_moving(free), speed * speed / length_);
  const double force = acceleration * largest_of_moving(found_.mass);
  for (Index k = 0; k < 3 * count; ++k) {
    if (!(mobility_[k / 3] > 0.0)) continue;
    // The value has no other derivative by an acceleration than one of a mass, or of a ratio of masses.
    if (!by([k](Input&, VectorXd& a, double h) { a[k] += h; }, share * acceleration, found_.mass[k / 3],
            result.by_acceleration[k]) ||
        !by([k](Input& to, VectorXd&, double h) { to.p[k] += h; }, share * length_, force / length_,
            result.by_position[k]) ||
        !by([k](Input& to, VectorXd&, double h) { to.v[k] += h; }, share * speed, force / speed, result.by_velocity[k]))
      return std::nullopt;
  }
  for (Index i = 0; i < count; ++i)
    if (const double own = found_.mass[i];
        mobility_[i] > 0.0 &&
        !by([i](Input& to, VectorXd&, double h) { to.mass[i] += h; }, share * own, force / own, result.by_mass[i]))
      return std::nullopt;
  if (surfaces_move() && !by([](Input& to, VectorXd&, double h) { to.time += h; }, state_.shortest,
                             steepest * force / state_.shortest, result.by_time))
    return std::nullopt;
  return result;
}

// ---- what it leaves -------------------------------------------------------------------------------------------------

// A change of friction's direction, which leaves the state as it is. So does the rest of a slip that has turned by a
// right angle, and goes on.
bool ClusterEvent::only_marks() const noexcept {
  return event_.kind == EventKind::slow || event_.kind == EventKind::quick || event_.kind == EventKind::seam ||
         (event_.kind == EventKind::rest && event_.own.after.slides && event_.own.next_v == event_.own.v);
}

// The cluster as the event leaves it: (p, v), [6 node]. Before it the state is one that connections and contacts allow:
// what is not allowed would count as an impact.
std::optional<VectorXd> ClusterEvent::after(const Input& input, const Kept& kept) {
  kept.forget();
  begin_with(input);
  Contact& contact = model_.contact;
  const springnet_state& now = model_.state.view;
  const std::shared_ptr<const Placement> at = model_.placement(input.time);
  springnet_message message{};
  for (const NodeChange& each : event_.cluster)
    if (each.before.surface >= 0 && !each.before.slides)
      put_vector(
          now.velocity, each.node,
          Contact::velocity(*at, static_cast<std::size_t>(each.before.surface), vector_at(now.position, each.node)));
  if (model_.rigid.project(*at, cluster_, now.position, now.velocity, message) != SPRINGNET_OK) return std::nullopt;
  Findings findings;
  Finding& own = findings.nodes[event_.index];
  own.slips = event_.kind == EventKind::slip;
  own.slip_ended = event_.kind == EventKind::rest;
  if (event_.kind == EventKind::touch) own.touched.push_back(event_.surface);
  if (event_.kind == EventKind::release) own.released.push_back(event_.surface);
  const Loads::Instant loads(model_.loads, input.time);
  if (settle(model_, input.time, model_.state, findings) != SPRINGNET_OK) return std::nullopt;
  for (const NodeChange& each : event_.cluster)
    if (contact.committed(each.node) != each.after) return std::nullopt;
  VectorXd result(static_cast<Index>(6 * nodes_.size()));
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    result.segment<3>(static_cast<Index>(3 * i)) = vector_at(now.position, nodes_[i]);
    result.segment<3>(static_cast<Index>(3 * (nodes_.size() + i))) = vector_at(now.velocity, nodes_[i]);
  }
  return result;
}

std::optional<EventJump> ClusterEvent::jump() {
  const auto count = static_cast<Index>(nodes_.size()), size = 3 * count;
  VectorXd given_p(size), given_v(size);
  for (Index i = 0; i < count; ++i) {
    const NodeChange& own = event_.cluster[static_cast<std::size_t>(i)];
    given_p.segment<3>(3 * i) = own.next_p;
    given_v.segment<3>(3 * i) = own.next_v;
  }
  const Kept kept(model_);
  write_state();
  const bool marks = only_marks();
  const std::optional<VectorXd> base =
      marks ? std::optional<VectorXd>((VectorXd(2 * size) << found_.p, found_.v).finished()) : after(found_, kept);
  // What an event leaves follows from what it finds to this share: see event_jump.cpp.
  constexpr double same = 1e-5, rounding = 1e-9;
  const double speed = speed_or_typical(std::max(largest_of_moving(found_.v), largest_of_moving(given_v)));
  if (!base || !(largest(base->tail(size) - given_v) <= same * speed) ||
      !(largest(base->head(size) - given_p) <= same * length_ + rounding * largest(given_p)))
    return std::nullopt;
  EventJump result{MatrixXd::Identity(2 * size, 2 * size), VectorXd::Zero(2 * size), VectorXd::Zero(2 * size),
                   MatrixXd::Zero(2 * size, count)};
  if (marks) return result;
  const auto fill = [&](const auto& change, double h, double typical, auto&& column) {
    const auto at = [&](double way) {
      Input input = found_;
      change(input, way);
      return after(input, kept);
    };
    const std::optional<VectorXd> found = settled_difference(at, *base, h, typical);
    if (found) column = *found;
    return found.has_value();
  };
  for (Index k = 0; k < size; ++k) {
    if (!(mobility_[k / 3] > 0.0)) continue;
    const auto place = [&](Input& to, double h) {
      to.p[k] += h;
      to.p = with_lengths(rods_, mobility_, std::move(to.p));
    };
    if (!fill(place, share * length_, std::max(1.0, speed / length_), result.by_state.col(k)) ||
        !fill([k](Input& to, double h) { to.v[k] += h; }, share * speed, 1.0, result.by_state.col(size + k)))
      return std::nullopt;
  }
  for (Index i = 0; i < count; ++i)
    if (const double own = found_.mass[i]; mobility_[i] > 0.0 && !fill([i](Input& to, double h) { to.mass[i] += h; },
                                                                       share * own, speed / own, result.by_mass.col(i)))
      return std::nullopt;
  if (surfaces_move() && !fill([](Input& to, double h) { to.time += h; }, state_.shortest,
                               steepest * speed / state_.shortest, result.by_time))
    return std::nullopt;
  return result;
}

}  // namespace springnet::learning
