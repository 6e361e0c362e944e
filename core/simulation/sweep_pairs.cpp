#include "simulation/sweep_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "constraints/independent_rows.hpp"
#include "constraints/same_rows.hpp"
#include "constraints/vectors.hpp"
#include "plugin_host/message.hpp"
#include "profile/stage.hpp"
#include "simulation/contact_notes.hpp"
#include "simulation/pair_ending.hpp"

namespace springnet {
namespace {

constexpr int most_rounds = 12;          // of a sweep: later ones go on
constexpr double crossing_share = 1e-3;  // of the thickness: nearer than that, paths cross
constexpr double deep = 0.5;             // of the thickness: what slides over a border is hardly nearer than that
// Target of the iterations, relative to that at a commit, because forces have to settle; after `patience` iterations
// the tolerance of gaps is enough.
constexpr double sweep_accuracy = 1e-3, share_of_first = 1e-4;
constexpr int before_newton = 10;
constexpr int patience = 100;
// In linear systems: more drags take longer than what they save of sweeps, and stiffer ones, in units of the inertia of
// the pair, hold it as well.
constexpr std::size_t most_drags = 200;
constexpr double stiffest_drag = 1e4;
// Friction on faces that are on faces is not unique, and its cone couples it to what presses: sweeps may carry it
// around for ever. After so many sweeps of a step, of newton and of the other rules, it follows by a share that falls
// to zero, and then keeps its impulses.
constexpr int patience_of_newton = 25, patience_of_others = 60, sweeps_to_rest = 20;
constexpr double falls_by = 0.8;
// Then directions and weights of pairs follow once in so many sweeps: the closest points of edges that are nearly
// parallel, or of faces, may wander to and fro by themselves.
constexpr int sweeps_of_newton = 12, sweeps_of_others = 40;
// What a step may leave of overlaps, in units of the tolerance: a step that has settled leaves far less.
constexpr double failed_gap = 300.0;

constexpr double little_slip = 1e-4;  // of the thickness, within a step: of friction that was held

// Friction that iterations have not just decided: at less than this share of its limit it does not slip.
constexpr double inside_cone = 1.0 - 1e-6;

bool presses(const PairRow& row) { return row.normal.dot(row.impulse) > 0.0; }
bool sticks(const PairRow& row) { return row.friction > 0.0 && !row.slips; }
bool is_within_cone(const PairRow& row) {
  const double along = row.normal.dot(row.impulse);
  return (row.impulse - along * row.normal).norm() < inside_cone * row.friction * along;
}

double weight_of(const springnet_sweep& sweep) { return sweep.time_constant * (sweep.theta > 0.0 ? sweep.theta : 1.0); }

}  // namespace

void SweepPairs::begin_step() {
  rows_.clear();
  contacts_.clear();
  known_.clear();
  reactions_.clear();
  on_obstacles_.clear();
  clusters_.clear();
  loose_.clear();
  mobility_.clear();
  no_list_.clear();
  sweeps_ = 0;
  kept_ = 0;
  friction_share_ = 1.0;
  model_.constraints.pushes().clear();
  const BodyContacts& bodies = model_.constraints.bodies();
  if (bodies.touching().empty()) return;
  const proximity::Positions x = positions_of(read_only(model_.state.view.position), model_.node_count());
  for (const PairTouch& touch : bodies.touching()) {
    const proximity::Separation at = separation(touch.kind, bodies.primitives().corners(touch.kind, touch.pair, x));
    add(touch.kind, touch.pair, at);
    // Begins with the force of the last step, so that what rests stays where it is.
    PairRow& row = rows_.back();
    const double along = row.normal.dot(touch.guess);
    row.impulse = model_.step_length * (touch.guess + (std::max(0.0, along) - along) * row.normal);
    row.slips = !is_within_cone(row);
  }
  store_pushes();
  store_rows(model_.state.view.velocity, model_.step_length);
}

void SweepPairs::add(proximity::PairKind kind, proximity::Pair pair, const proximity::Separation& met) {
  const BodyContacts& bodies = model_.constraints.bodies();
  if (mobility_.empty()) {
    mobility_ = pair_mobility(model_);
    added_.assign(model_.node_count(), Vector3::Zero());
  }
  const PairRow row = row_of(bodies, kind, pair, met);
  known_.emplace(kind, pair);
  for (int i = 0; i < row.count; ++i)
    if (const std::uint32_t k = row.nodes[static_cast<std::size_t>(i)]; mobility_[k] > 0.0)
      model_.constraints.pushes().add_node(k);
  rows_.push_back(row);
  contacts_.push_back({met, bodies.primitives().thickness(kind, pair), 0.0});
}

void SweepPairs::add(const springnet_sweep& sweep, proximity::PairKind kind, proximity::Pair pair,
                     const proximity::Separation& met) {
  if (known_.contains({kind, pair})) return;
  add(kind, pair, met);
  const std::size_t r = rows_.size() - 1;
  static_cast<void>(renew(r, sweep.next_position));
  know_inertia(sweep, rows_[r]);
  for (int i = 0; i < rows_[r].count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    contacts_[r].came -= rows_[r].weights[k] * met.direction.dot(vector_at(sweep.start_velocity, rows_[r].nodes[k]));
  }
}

// As of obstacles: not of approaches that are no faster than what other forces change within a step.
double SweepPairs::rebound(std::size_t r, const springnet_vectors& velocity) const {
  const PairRow& row = rows_[r];
  const double came = contacts_[r].came;
  double without = 0.0;  // m/s, its rate without bodies
  for (int i = 0; i < row.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const std::uint32_t node = row.nodes[k];
    const auto push = [this](std::uint32_t j) -> const Vector3& { return model_.constraints.pushes().impulse(j); };
    const ClusterResponses::Place* const place = clusters_.find(node);
    const Vector3 change = place == nullptr ? Vector3(mobility_[node] * push(node)) : clusters_.change(*place, push);
    without += row.weights[k] * row.normal.dot(vector_at(velocity, node) - change);
  }
  // What arrives at the very end of the step has not pressed within it.
  if (!(came > std::abs(without + came))) return 0.0;
  return model_.constraints.bodies().law_of(row.kind, row.pair).restitution * came;
}

double SweepPairs::renew(std::size_t r, const springnet_vectors& position) {
  PairRow& row = rows_[r];
  const Known& known = contacts_[r];
  const proximity::Primitives& all = model_.constraints.bodies().primitives();
  const std::size_t n = model_.node_count();
  const std::array<Vector3, 4> end = all.corners(row.kind, row.pair, positions_of(read_only(position), n));
  const proximity::Separation now = separation(row.kind, end);
  // On its side the distance counts, also where the pair has slid beyond a border. What has gone through goes back
  // through the plane in which it did.
  const auto apart_along = [&](const proximity::Separation& plane) {
    row.normal = plane.direction;
    row.weights = plane.weights;
    return row.normal.dot(relative(row, position));
  };
  if (row.kind == proximity::PairKind::node_node) {
    if (const double apart = apart_along(known.at); apart < 0.0) return apart - known.thickness;
  } else {
    const std::array<Vector3, 4> start =
        all.corners(row.kind, row.pair, positions_of(read_only(model_.state.view.position), n));
    double path = 0.0;  // at most, of one relative to the other
    for (std::size_t k = 0; k < end.size(); ++k) path = std::max(path, 2.0 * (end[k] - start[k]).norm());
    if (path > now.distance)
      if (const auto crossing = first_meeting(row.kind, start, end, crossing_share * known.thickness))
        if (const double apart = apart_along(crossing->at); apart < 0.0) return apart - known.thickness;
    // Beside a border it may get to the other side without a crossing, though not without overlapping.
    if (now.distance < deep * known.thickness)
      if (const double apart = apart_along(known.at); apart < known.thickness) return apart - known.thickness;
  }
  row.normal = now.direction;
  row.weights = now.weights;
  return now.distance - known.thickness;
}

bool SweepPairs::find(const springnet_sweep& sweep) {
  const profile::Stage stage("proximity");
  BodyContacts& bodies = model_.constraints.bodies();
  const std::size_t n = model_.node_count(), before = rows_.size();
  const proximity::Positions start = positions_of(sweep.start_position, n),
                             end = positions_of(read_only(sweep.next_position), n);
  try {
    bodies.list().update(start, end);
    no_list_.clear();
  } catch (const Error& error) {  // outputs that are too far away, or bodies that collapse
    no_list_ = error.what();
    return false;
  }
  const proximity::Primitives& all = bodies.primitives();
  const unsigned threads = model_.evaluator.threads();
  const auto at_start = [&](proximity::PairKind kind, proximity::Pair pair) {
    return separation(kind, all.corners(kind, pair, start));
  };
  proximity::find_meetings(all, bodies.list().close(0.0), start, end, met_, threads);
  for (const proximity::MeetingPair& each : met_)
    add(sweep, each.kind, each.pair, each.meeting.from_start ? at_start(each.kind, each.pair) : each.meeting.at);
  proximity::find_near(all, bodies.list().close(0.0), end, 0.0, near_, threads);
  for (const proximity::NearPair& each : near_) add(sweep, each.kind, each.pair, at_start(each.kind, each.pair));
  return rows_.size() > before;
}

void SweepPairs::know_inertia(const springnet_sweep& sweep, const PairRow& row) {
  if (sweep.inertia == nullptr) return;
  blocks_.resize(model_.node_count());
  for (int i = 0; i < row.count; ++i) {
    const std::uint32_t k = row.nodes[static_cast<std::size_t>(i)];
    if (mobility_[k] > 0.0) blocks_[k] = Eigen::Map<const Matrix3>(sweep.inertia + 9 * std::size_t{k}).inverse();
  }
}

void SweepPairs::know_clusters(const springnet_sweep& sweep, const Placement& at) {
  if (!model_.rigid.any()) return;
  const auto free = [&](std::uint32_t node) -> Matrix3 {
    if (sweep.inertia == nullptr) return Matrix3::Identity() / model_.mass[node];
    return Eigen::Map<const Matrix3>(sweep.inertia + 9 * std::size_t{node}).inverse();
  };
  clusters_.set(model_.rigid, at, read_only(sweep.next_position), model_.constraints.pushes().nodes(), free, loose_);
}

bool SweepPairs::loosen(const PairRow& row) {
  bool changed = false;
  for (int i = 0; i < row.count; ++i) {
    const std::uint32_t node = row.nodes[static_cast<std::size_t>(i)];
    if (mobility_[node] > 0.0 && model_.rigid.is_joined(node))
      changed = loose_.insert(model_.rigid.cluster_of()[node]).second || changed;
  }
  return changed;
}

// Impulses moved rigid bodies along straight lines. Lengths that cannot be kept are an error of the next sweep.
void SweepPairs::keep_lengths(const springnet_sweep& sweep, const Placement& at) {
  springnet_message unused{};
  for (const ClusterResponses::Cluster& cluster : clusters_.clusters())
    static_cast<void>(model_.rigid.project(at, cluster.number, sweep.next_position, sweep.next_velocity, unused));
}

MovedNodes SweepPairs::moved(const springnet_sweep& sweep) const {
  return {sweep.next_position,
          sweep.next_velocity,
          &mobility_,
          sweep.inertia != nullptr ? &blocks_ : nullptr,
          on_obstacles_.empty() ? nullptr : &on_obstacles_,
          clusters_.any() ? &clusters_ : nullptr};
}

void SweepPairs::store_pushes() {
  BodyPushes& pushes = model_.constraints.pushes();
  for (const std::uint32_t k : pushes.nodes()) pushes.set(k, Vector3::Zero(), SPRINGNET_NEAR);
  for (std::size_t r = 0; r < contacts_.size(); ++r) {
    const PairRow& row = rows_[r];
    const std::uint8_t how = !presses(row) ? SPRINGNET_NEAR : sticks(row) ? SPRINGNET_STUCK : SPRINGNET_PUSHED;
    for (int i = 0; i < row.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const std::uint32_t node = row.nodes[k];
      if (mobility_[node] > 0.0)
        pushes.set(node, pushes.impulse(node) + row.weights[k] * row.impulse, std::max(how, pushes.pushed()[node]));
    }
  }
}

void SweepPairs::store_rows(const springnet_vectors& velocity, double weight) {
  std::vector<ConstraintRow> rows;
  std::vector<BodyPushes::Drag> drags;
  for (const PairRow& row : rows_) {
    if (!presses(row) || row.is_blocked) continue;
    const auto along = [&row](const Vector3& direction) {
      ConstraintRow result{row.nodes[0], ConstraintRow::no_node, direction};
      if (row.count > 1) result.second = row.nodes[1];
      if (row.count > 2) result.third = row.nodes[2];
      if (row.count > 3) result.fourth = row.nodes[3];
      result.weights = row.weights;
      result.is_pair = true;
      return result;
    };
    rows.push_back(along(row.normal));
    if (!(row.friction > 0.0) || friction_share_ == 0.0) continue;
    if (!row.slips) {
      const Vector3 across = row.normal.unitOrthogonal();
      rows.push_back(along(across));
      rows.push_back(along(row.normal.cross(across)));
      continue;
    }
    const Vector3 friction = row.impulse - row.normal * row.normal.dot(row.impulse);
    Vector3 slip = relative(row, velocity) - row.ground;
    slip -= row.normal * row.normal.dot(slip);
    // Not before the first sweep of a step has found the slip and its mobility.
    if (!(row.across > 0.0) || friction.isZero(0.0)) continue;
    const double damping = std::min(friction.norm() / slip.norm(), stiffest_drag / row.across) / weight;
    drags.push_back({along(row.normal.cross(friction.normalized())), damping});
  }
  if (drags.size() > most_drags) {
    std::stable_sort(drags.begin(), drags.end(), [](const auto& a, const auto& b) { return a.damping > b.damping; });
    drags.resize(most_drags);
  }
  model_.constraints.pushes().set_rows(independent_rows(std::move(rows), mobility_), std::move(drags));
}

void SweepPairs::push(const springnet_sweep& sweep) {
  BodyPushes& pushes = model_.constraints.pushes();
  std::vector<Vector3> before;
  for (const std::uint32_t k : pushes.nodes()) before.push_back(pushes.impulse(k));
  store_pushes();
  const MovedNodes nodes = moved(sweep);
  const double weight = weight_of(sweep);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const std::uint32_t k = pushes.nodes()[i];
    const Vector3 more = pushes.impulse(k) - before[i];
    if (!more.isZero(0.0)) springnet::push(k, more, weight, nodes);
  }
}

bool SweepPairs::is_finite(const springnet_sweep& sweep) const {
  return std::all_of(rows_.begin(), rows_.end(), [&](const PairRow& row) {
    return relative(row, sweep.next_position).allFinite() && relative(row, sweep.next_velocity).allFinite();
  });
}

void SweepPairs::take_out(const springnet_sweep& sweep) {
  if (sweep.constraint_force.x == nullptr || added_.empty()) return;
  for (const std::uint32_t k : model_.constraints.pushes().nodes())
    put_vector(sweep.constraint_force, k, vector_at(sweep.constraint_force, k) - added_[k]);
}

void SweepPairs::put_back(const springnet_sweep& sweep) {
  if (sweep.constraint_force.x == nullptr || added_.empty()) return;
  for (const std::uint32_t k : model_.constraints.pushes().nodes())
    put_vector(sweep.constraint_force, k, vector_at(sweep.constraint_force, k) + added_[k]);
}

// Rows of the obstacles that pushed nodes are on, after those of pairs: what bodies and obstacles do to a node depends
// on each other. In sweeps that leave contacts as they are, obstacles may pull. Obstacles that hold a node, and edges
// of several, count as they are.
void SweepPairs::add_obstacles(const springnet_sweep& sweep, const Placement& at) {
  on_obstacles_.clear();
  const Contact& contact = model_.contact;
  if (contact.obstacles().empty()) return;
  for (const std::uint32_t k : model_.constraints.pushes().nodes()) {
    const Touch touch = contact.now(k);
    OnObstacle on;
    if (!is_on_obstacle(model_, at, k, touch, vector_at(sweep.next_position, k), on)) continue;
    const bool decides = sweep.contacts == 0 || sweep.contacts == SPRINGNET_MAY_TOUCH;
    if (on.sticks || !decides || contact.bounces(k) || sweep.constraint_force.x == nullptr) {
      on_obstacles_[k] = on;
      continue;
    }
    PairRow row;
    row.nodes[0] = k;
    row.weights[0] = 1.0;
    row.count = 1;
    row.impulse =
        touch.slides ? Vector3(weight_of(sweep) * vector_at(sweep.constraint_force, k)) : contact.sweep_impulse(k);
    // Friction of a node that arrives is that of its landing, too, and stays what the obstacle says.
    if (contact.committed(k).has(touch.surface))
      row.friction = coefficient_of(contact.obstacles()[static_cast<std::size_t>(touch.surface)].friction());
    else
      row.impulse = on.normal * on.normal.dot(row.impulse);
    rows_.push_back(row);
    reactions_.push_back({static_cast<std::size_t>(touch.surface), row.impulse});
  }
}

// Prepares a row for the outputs as they are. Returns whether it has converged.
bool SweepPairs::renew_row(std::size_t r, const springnet_sweep& sweep, const Placement& at, const MovedNodes& nodes,
                           const PairTolerances& tolerance) {
  PairRow& row = rows_[r];
  double gap = 0.0;
  if (r < contacts_.size()) {
    gap = r < kept_ ? row.normal.dot(relative(row, sweep.next_position)) - contacts_[r].thickness
                    : renew(r, sweep.next_position);
  } else {
    const std::size_t surface = reactions_[r - contacts_.size()].surface;
    const Vector3 p = vector_at(sweep.next_position, row.nodes[0]);
    gap = model_.contact.gap(at, surface, p);
    row.normal = model_.contact.normal(at, surface, p);
    row.ground = Contact::velocity(at, surface, p);
  }
  row.lever = weight_of(sweep);
  row.value = gap - row.normal.dot(relative(row, sweep.next_position));
  row.is_blocked = !set_mobility(row, nodes);
  if (row.is_blocked && gap < -tolerance.gap && loosen(row)) return false;  // from the next round on
  return row.is_blocked || (presses(row) ? std::abs(gap) <= tolerance.gap : gap >= -tolerance.gap);
}

void SweepPairs::find_impulses(const MovedNodes& nodes, double weight, const PairAccuracy& accuracy) {
  join_same(rows_);
  const auto keep = [this](bool keeps) {
    for (PairRow& row : rows_) row.keeps_across = keeps;
  };
  if (friction_share_ == 1.0) {
    solve(rows_, nodes, weight, accuracy);
    return;
  }
  if (friction_share_ > 0.0) {
    std::vector<Vector3> before;
    for (const PairRow& row : rows_) before.push_back(row.impulse);
    solve(rows_, nodes, weight, accuracy);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      Vector3 change = before[r] - rows_[r].impulse;
      change = (1.0 - friction_share_) * (change - rows_[r].normal * rows_[r].normal.dot(change));
      rows_[r].impulse += change;
      apply(rows_[r], change, nodes);
    }
  }
  keep(true);
  solve(rows_, nodes, weight, accuracy);
  keep(false);
}

void SweepPairs::constrain(const springnet_sweep& sweep, bool of_newton) {
  if (!model_.constraints.bodies().any()) return;
  if (!contacts_.empty()) ++sweeps_;
  const int sweeps = sweeps_ - (of_newton ? patience_of_newton : patience_of_others);
  friction_share_ = sweeps <= 0 ? 1.0 : sweeps > sweeps_to_rest ? 0.0 : std::pow(falls_by, sweeps);
  const int since_rest = sweeps - sweeps_to_rest;
  kept_ = since_rest > 0 && since_rest % (of_newton ? sweeps_of_newton : sweeps_of_others) != 0 ? contacts_.size() : 0;
  const double weight = weight_of(sweep);
  length_ = sweep.time_constant;
  if (!(weight > 0.0) || !is_finite(sweep)) return;
  for (const PairRow& row : rows_) know_inertia(sweep, row);
  const PairTolerances tolerance(model_);
  const std::shared_ptr<const Placement> at = model_.placement(sweep.time);
  MovedNodes nodes{};
  const auto finish = [&] {
    for (std::size_t i = 0; i < reactions_.size(); ++i) {
      const PairRow& row = rows_[contacts_.size() + i];
      if (!model_.contact.now(row.nodes[0]).slides) continue;  // held: no force is reported
      const Vector3 more = (row.impulse - reactions_[i].before) / weight;
      put_vector(sweep.constraint_force, row.nodes[0], vector_at(sweep.constraint_force, row.nodes[0]) + more);
    }
    rows_.resize(contacts_.size());
    reactions_.clear();
  };
  bool all_done = false, changed = false;
  for (int round = 0; round < most_rounds && !all_done; ++round) {
    if (reactions_.empty()) add_obstacles(sweep, *at);
    know_clusters(sweep, *at);
    nodes = moved(sweep);
    bool done = true;
    for (std::size_t r = 0; r < rows_.size(); ++r) done = renew_row(r, sweep, *at, nodes, tolerance) && done;
    // Friction has no say in gaps: it needs an iteration of its own.
    if (done && (round > 0 || contacts_.empty())) {
      finish();
      all_done = !find(sweep);
      continue;
    }
    changed = true;
    push(sweep);
    find_impulses(nodes, weight,
                  {sweep_accuracy * tolerance.accuracy, tolerance.gap, patience, most_pair_iterations,
                   model_.rigid.any() ? 0.0 : share_of_first, before_newton});
    store_pushes();
  }
  finish();
  if (changed) keep_lengths(sweep, *at);
  if (!all_done) find(sweep);  // for the next one
  store_rows(sweep.next_velocity, weight);
  if (sweep.constraint_force.x == nullptr) return;
  const BodyPushes& pushes = model_.constraints.pushes();
  for (const std::uint32_t k : pushes.nodes()) {
    const Touch& touch = model_.contact.now(k);
    const bool is_held = touch.surface >= 0 && !touch.slides;  // no force is reported then
    added_[k] = is_held ? Vector3(Vector3::Zero()) : Vector3(pushes.impulse(k) / weight);
  }
  put_back(sweep);
}

// Held friction may leave pairs that slip, though it would have force enough to stop them.
void SweepPairs::note_slips() {
  if (friction_share_ > 0.0) return;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const PairRow& row = rows_[r];
    if (!presses(row) || !is_within_cone(row) || row.is_blocked) continue;
    const Vector3 rate = relative(row, model_.state.view.velocity);
    const double way = length_ * (rate - row.normal * row.normal.dot(rate)).norm();
    if (way <= little_slip * contacts_[r].thickness) continue;
    note_held_friction(model_, model_.constraints.bodies().describe(row.kind, row.pair), model_.time);
    return;
  }
}

springnet_status SweepPairs::fail(const std::string& why, const char* or_else) const {
  set_message(model_.journal.message,
              fmt::format("contact of bodies does not converge in a step of {:g} s ({}); use a smaller time step{}",
                          length_, why, or_else));
  return SPRINGNET_RECOVERABLE;
}

springnet_status SweepPairs::check(const springnet_vectors& position) {
  if (!no_list_.empty()) {
    set_message(model_.journal.message, no_list_);
    return SPRINGNET_RECOVERABLE;
  }
  const BodyContacts& bodies = model_.constraints.bodies();
  const double most = rows_.empty() ? 0.0 : failed_gap * PairTolerances(model_).gap;
  for (std::size_t r = 0; r < rows_.size(); ++r)
    if (const double gap = renew(r, position); gap < -most && !rows_[r].is_blocked)
      return fail(fmt::format("{} overlap by {:g} m", bodies.describe(rows_[r].kind, rows_[r].pair), -gap),
                  ", or unsettled = \"adapt\", which divides such steps");
  return SPRINGNET_OK;
}

springnet_status SweepPairs::commit(const State& before) {
  BodyContacts& bodies = model_.constraints.bodies();
  if (rows_.empty() && bodies.touching().empty()) return SPRINGNET_OK;
  const springnet_vectors &position = model_.state.view.position, &velocity = model_.state.view.velocity;
  const std::shared_ptr<const Placement> at = model_.placement(model_.time);
  const auto free = [this](std::uint32_t node) -> Matrix3 { return Matrix3::Identity() / model_.mass[node]; };
  clusters_.set(model_.rigid, *at, read_only(position), model_.constraints.pushes().nodes(), free);
  note_slips();
  EndingPairs pairs;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    EndingPair& pair = pairs[{rows_[r].kind, rows_[r].pair}];
    pair.row = rows_[r];
    pair.impulse = rows_[r].impulse;
    pair.rebound = rebound(r, velocity);
    static_cast<void>(renew(r, position));
  }
  if (mobility_.empty()) mobility_ = pair_mobility(model_);
  std::map<std::uint32_t, OnObstacle> on_obstacles;
  for (std::uint32_t k = 0; !model_.contact.obstacles().empty() && k < model_.node_count(); ++k)
    if (OnObstacle on; is_on_obstacle(model_, *at, k, model_.contact.committed(k), vector_at(position, k), on))
      on_obstacles[k] = on;
  const MovedNodes nodes{position, velocity, &mobility_, nullptr, on_obstacles.empty() ? nullptr : &on_obstacles};
  const PairEnding ending{model_.time, length_, nodes, read_only(before.view.velocity), false, loose_};
  if (end_pairs(model_, ending, std::move(pairs)) != SPRINGNET_OK)
    return fail(fmt::format("impulses of {} pairs at its end", rows_.size()));
  model_.stale.forces = true;
  ++model_.load_revision;
  return SPRINGNET_OK;
}

}  // namespace springnet
