#include "simulation/verlet_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "plugin_host/message.hpp"
#include "profile/stage.hpp"
#include "simulation/pair_ending.hpp"

namespace springnet {
namespace {

// Positions that no list of neighbours can be made of.
struct Diverged {
  std::string why;
};

constexpr int max_pair_rounds = 1000;  // of finding pairs, and of curved gaps
constexpr int max_obstacle_rounds = 200;
constexpr int max_reopened = 20;         // rounds of obstacles that change what they hold of rigid bodies
constexpr int most_rebounds = 50;        // of a pair within a step; later impacts of it are inelastic
constexpr double most_moved = 0.1;       // of weights: closest points beyond are others
constexpr double share_of_held = 0.25;   // of the thickness: overlaps of what nothing lets give way
constexpr double share_of_late = 0.001;  // likewise, of what impacts turn late in the step
// A pair that meets at the very end of a step: impulses of the kick stop it.
constexpr double least_lever = 1e-3;  // of the step

}  // namespace

VerletPairs::VerletPairs(Model& model, double until, double length)
    : model_(model),
      from_(model.time),
      until_(until),
      h_(length),
      tolerance_(model),
      mobility_(pair_mobility(model)),
      clusters_(model, until, length) {}

bool VerletPairs::strike(const springnet_sweep& step, proximity::PairKind kind, proximity::Pair pair, double share) {
  if (!clusters_.any()) return false;
  const proximity::Primitives& all = model_.constraints.bodies().primitives();
  const std::array<std::uint32_t, 4> nodes = all.nodes_of(kind, pair);
  bool changed = false;
  for (int i = 0; i < proximity::first_nodes(kind) + proximity::second_nodes(kind); ++i)
    changed = clusters_.strike(step, nodes[static_cast<std::size_t>(i)], share) || changed;
  return changed;
}

void VerletPairs::renew_mobility(const springnet_sweep& step) {
  clusters_.renew();
  set_blocked(step);
}

void VerletPairs::set_blocked(const springnet_sweep& step) {
  for (PairRow& row : rows_) row.is_blocked = !set_mobility(row, moved(step));
}

bool VerletPairs::loosen(const PairRow& row) {
  bool changed = false;
  for (int i = 0; i < row.count; ++i)
    if (const std::uint32_t node = row.nodes[static_cast<std::size_t>(i)]; mobility_[node] > 0.0)
      changed = clusters_.loosen(node) || changed;
  return changed;
}

void VerletPairs::add(const springnet_sweep& step, proximity::PairKind kind, proximity::Pair pair,
                      const proximity::Separation& at, double share, bool is_new) {
  const BodyContacts& bodies = model_.constraints.bodies();
  PairRow row = row_of(bodies, kind, pair, at);
  row.lever = h_;
  known_.emplace(kind, pair);
  if (strike(step, kind, pair, is_new ? share : 0.0)) renew_mobility(step);
  row.is_blocked = !set_mobility(row, moved(step));
  if (row.is_blocked && std::none_of(row.nodes.begin(), row.nodes.begin() + row.count,
                                     [&](std::uint32_t node) { return mobility_[node] > 0.0; }))
    return;
  Contact contact{at.direction, bodies.primitives().thickness(kind, pair), share, false, false};
  // Its gap closes at most. So what slides from one face to the next is carried by the plane of the first for the rest
  // of the step.
  row.by_rate = true;
  row.value = is_new ? 0.0 : (at.distance - contact.thickness) / h_;
  if (is_new) {
    const double came = -row.normal.dot(relative(row, step.next_velocity));
    const double restitution = bodies.law_of(kind, pair).restitution;
    const double falls = 2.0 * std::max(0.0, -row.normal.dot(relative(row, gained_.vectors())));
    row.lever = std::max(least_lever, 1.0 - share) * h_;
    contact.is_impact = true;
    contact.is_fast = came > std::max(falls, tolerance_.gap / h_);
    // A rebound slower than the fall within the step ends in contact, and so do many after each other.
    contact.bounces =
        restitution * came > std::max(falls, tolerance_.gap / h_) && ++bounces_[std::pair(kind, pair)] <= most_rebounds;
    if (contact.bounces) row.value = -restitution * came;
  }
  rows_.push_back(row);
  contacts_.push_back(contact);
}

bool VerletPairs::find(const springnet_sweep& step) {
  ++rounds_;
  const profile::Stage stage("proximity");
  BodyContacts& bodies = model_.constraints.bodies();
  const std::size_t n = model_.node_count();
  const proximity::Positions end =
      clusters_.any() ? clusters_.end(step) : positions_of(read_only(step.next_position), n);
  proximity::Positions start = positions_of(step.start_position, n);
  if (!start_[0].empty()) start = {{start_[0].data(), start_[1].data(), start_[2].data()}, n};
  try {
    bodies.list().update(start, end);
  } catch (const Error& error) {  // the motion diverges, or bodies collapse
    throw Diverged{error.what()};
  }
  const proximity::Primitives& all = bodies.primitives();
  const auto know_gained = [&] {
    if (!gained_.values.empty()) return;
    gained_.values.resize(3 * n);
    const springnet_vectors gained = gained_.vectors();
    for (std::uint32_t k = 0; k < n; ++k)
      put_vector(gained, k, vector_at(step.next_velocity, k) - vector_at(step.start_velocity, k));
  };
  const std::size_t before = rows_.size();
  // What touches already comes first: without its impulses bodies would sink into what is beside it.
  if (known_.empty() && !bodies.touching().empty()) {
    know_gained();
    for (const PairTouch& touch : bodies.touching()) strike(step, touch.kind, touch.pair, 0.0);
    clusters_.renew();
    for (const PairTouch& touch : bodies.touching()) {
      const std::size_t row_count = rows_.size();
      add(step, touch.kind, touch.pair, separation(touch.kind, all.corners(touch.kind, touch.pair, start)), 0.0, false);
      if (rows_.size() == row_count) continue;
      // Begins with the force of the last step, so that what rests stays where it is.
      PairRow& row = rows_.back();
      const double along = row.normal.dot(touch.guess);
      row.impulse = 0.5 * h_ * (touch.guess + (std::max(0.0, along) - along) * row.normal);
      apply(row, row.impulse, moved(step));
    }
    if (!rows_.empty()) return true;
  }
  const unsigned threads = model_.evaluator.threads();
  proximity::find_near(all, bodies.list().close(0.0), end, 0.0, near_, threads);
  proximity::find_meetings(all, bodies.list().close(0.0), start, end, met_, threads);
  if (near_.empty() && met_.empty()) return false;
  know_gained();
  add_first(step, start, end);
  pass_on(step, before, start, end);
  return rows_.size() > before;
}

void VerletPairs::pass_on(const springnet_sweep& step, std::size_t first_impact, const proximity::Positions& start,
                          const proximity::Positions& end) {
  const BodyContacts& bodies = model_.constraints.bodies();
  const std::size_t count = rows_.size();
  for (std::size_t r = first_impact; r < count; ++r) {
    if (!contacts_[r].is_fast) continue;
    std::set<std::uint32_t> struck;
    const auto strike_nodes = [&](const PairRow& row) {
      for (int i = 0; i < row.count; ++i)
        if (const std::uint32_t node = row.nodes[static_cast<std::size_t>(i)]; mobility_[node] > 0.0)
          clusters_.for_each_moved(node, [&](std::uint32_t k) { struck.insert(k); });
    };
    const auto is_struck = [&](const PairRow& row) {
      return std::any_of(row.nodes.begin(), row.nodes.begin() + row.count,
                         [&](std::uint32_t node) { return mobility_[node] > 0.0 && struck.contains(node); });
    };
    strike_nodes(rows_[r]);
    for (bool more = true; more;) {
      more = false;
      for (std::size_t q = 0; q < rows_.size(); ++q) {
        if (q >= first_impact && !contacts_[q].passes_on) continue;  // it has not happened yet
        const bool is_later = rows_[q].lever <= rows_[r].lever * (1.0 + simultaneous);
        if (rows_[q].is_done || rows_[q].is_blocked || is_later || !is_struck(rows_[q])) continue;
        const double time = contacts_[r].time;
        std::array<Vector3, 4> now = bodies.primitives().corners(rows_[q].kind, rows_[q].pair, start);
        const std::array<Vector3, 4> after = bodies.primitives().corners(rows_[q].kind, rows_[q].pair, end);
        for (std::size_t k = 0; k < 4; ++k) now[k] += time * (after[k] - now[k]);
        PairRow row = row_of(bodies, rows_[q].kind, rows_[q].pair, separation(rows_[q].kind, now));
        if (!set_mobility(row, moved(step))) continue;
        more = true;
        rows_[q].is_done = true;
        strike_nodes(row);
        row.lever = rows_[r].lever;
        row.by_rate = true;
        // It may take back what the rest of the step would have had of the impulse before.
        row.least = -(1.0 - time) * std::max(0.0, rows_[q].normal.dot(rows_[q].impulse));
        Contact contact = contacts_[q];
        contact.side = row.normal;
        contact.time = time;
        contact.least = row.least;
        contact.bounces = contact.is_fast = false;
        contact.is_impact = contact.passes_on = true;
        rows_.push_back(row);
        contacts_.push_back(contact);
      }
    }
  }
}

// Impacts are over: those that bounce keep their impulses, and nodes go on along other paths.
void VerletPairs::finish_impacts(const springnet_sweep& step) {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    PairRow& row = rows_[r];
    if (!contacts_[r].is_impact || row.is_done || row.is_blocked) continue;
    if (contacts_[r].passes_on && row.impulse.isZero(0.0)) continue;
    if (start_[0].empty()) {
      const std::size_t n = model_.node_count();
      start_[0].assign(step.start_position.x, step.start_position.x + n);
      start_[1].assign(step.start_position.y, step.start_position.y + n);
      start_[2].assign(step.start_position.z, step.start_position.z + n);
    }
    for (int i = 0; i < row.count; ++i) {
      const std::uint32_t node = row.nodes[static_cast<std::size_t>(i)];
      if (mobility_[node] == 0.0) continue;
      clusters_.for_each_moved(node, [&](std::uint32_t k) {
        const Vector3 from = vector_at(step.next_position, k) - h_ * vector_at(step.next_velocity, k);
        for (std::size_t c = 0; c < 3; ++c) start_[c][k] = from[static_cast<Eigen::Index>(c)];
        struck_[k] = std::max(struck_[k], contacts_[r].time);
      });
    }
    // Later ones do not undo it, which would take it back to where it was when they came.
    row.least = std::max(row.least, row.normal.dot(row.impulse));
    if (!contacts_[r].bounces) continue;
    row.is_done = true;
    known_.erase(std::pair(row.kind, row.pair));
  }
}

void VerletPairs::reopen_impacts() {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (!contacts_[r].is_impact || (rows_[r].is_done && !contacts_[r].bounces)) continue;
    rows_[r].least = contacts_[r].least;
    rows_[r].is_done = false;
    known_.emplace(rows_[r].kind, rows_[r].pair);
  }
}

proximity::Separation VerletPairs::separation_at(std::size_t row, const springnet_vectors& position) const {
  const PairRow& of = rows_[row];
  const proximity::Primitives& all = model_.constraints.bodies().primitives();
  const proximity::Positions x = positions_of(read_only(position), model_.node_count());
  return on_side(separation(of.kind, all.corners(of.kind, of.pair, x)), contacts_[row].side);
}

double VerletPairs::gap(std::size_t row, const springnet_vectors& position) const {
  return separation_at(row, position).distance - contacts_[row].thickness;
}

// Where the closest points have gone elsewhere, as along edges that are nearly parallel, the row says nothing of them:
// what it can do is keep its own points apart.
double VerletPairs::own_gap(std::size_t r, const springnet_vectors& position) const {
  const PairRow& row = rows_[r];
  const proximity::Separation now = separation_at(r, position);
  double moved = 0.0;
  for (std::size_t i = 0; i < row.weights.size(); ++i)
    moved = std::max(moved, std::abs(now.weights[i] - row.weights[i]));
  const double apart = moved > most_moved ? row.normal.dot(relative(row, position)) : now.distance;
  return apart - contacts_[r].thickness;
}

springnet_status VerletPairs::fail() const {
  set_message(
      model_.journal.message,
      fmt::format("the contacts of bodies, {} pairs, do not converge in a step of {:g} s (after {} rounds of finding "
                  "pairs)",
                  rows_.size(), h_, rounds_));
  return SPRINGNET_RECOVERABLE;
}

springnet_status VerletPairs::separate(const springnet_sweep& step) {
  double turned = 0.0;  // m, by which clusters were off their straight paths
  for (int round = 0; round < max_pair_rounds; ++round) {
    bool done = turned <= tolerance_.accuracy;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (!rows_[r].is_blocked || rows_[r].is_done) continue;
      if (gap(r, step.next_position) < -tolerance_.gap && loosen(rows_[r])) renew_mobility(step);
    }
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      PairRow& row = rows_[r];
      if (row.is_done || row.is_blocked) continue;
      const double now = own_gap(r, step.next_position);
      // Its path is curved. Where little of the step is left that is little, too, and left to the next one.
      const bool may_close = !contacts_[r].bounces && row.lever >= 0.5 * h_;
      if (row.by_rate && round > 0 && may_close && now < -tolerance_.gap) row.by_rate = false;
      if (row.by_rate) {
        done = done && round > 0;
        continue;
      }
      row.value = now - row.normal.dot(relative(row, step.next_position));
      const bool pushes = row.normal.dot(row.impulse) > row.least + 1e-12 * std::abs(row.least);
      done = done && (pushes ? std::abs(now) <= tolerance_.gap : now >= -tolerance_.gap);
    }
    // Friction has no say in gaps: it needs an iteration of its own.
    if (done && round > 0) {
      finish_impacts(step);
      if (!find(step)) return SPRINGNET_OK;
    }
    const PairAccuracy accuracy{tolerance_.accuracy, tolerance_.gap, pair_patience, most_pair_iterations};
    if (solve(rows_, moved(step), h_, accuracy).residual > tolerance_.gap) return fail();
    turned = 0.0;
    if (const springnet_status status = clusters_.keep_lengths(step, turned); status != SPRINGNET_OK) return status;
  }
  return fail();
}

MovedNodes VerletPairs::moved(const springnet_sweep& step) const {
  return {
      step.next_position,   step.next_velocity, &mobility_, nullptr, on_obstacles_.empty() ? nullptr : &on_obstacles_,
      clusters_.responses()};
}

// Those of the drift as it decided them, or as committed by the kick.
void VerletPairs::note_obstacles(const springnet_sweep& step, bool of_drift) {
  on_obstacles_.clear();
  if (model_.contact.obstacles().empty()) return;
  const std::shared_ptr<const Placement> at = model_.placement(until_);
  for (std::uint32_t k = 0; k < model_.node_count(); ++k) {
    const Touch touch = of_drift ? model_.contact.now(k) : model_.contact.committed(k);
    if (OnObstacle on; is_on_obstacle(model_, *at, k, touch, vector_at(step.next_position, k), on))
      on_obstacles_[k] = on;
  }
}

VerletContact::Pushes VerletPairs::pushes(const springnet_sweep& step) const {
  VerletContact::Pushes result;
  for (const PairRow& row : rows_)
    for (int i = 0; i < row.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double share = row.weights[k] * mobility_[row.nodes[k]];
      if (share == 0.0 || model_.rigid.is_joined(row.nodes[k])) continue;
      VerletContact::Push& push = result[row.nodes[k]];
      push.velocity += share * row.impulse;
      push.shift += (row.lever - h_) * share * row.impulse;
    }
  clusters_.add_pushes(rows_, result);
  // An impact may lead through a thin obstacle, on the other side of which the node would be free: no more of it than
  // leads into it.
  for (const auto& [k, on] : on_obstacles_) {
    const auto push = result.find(k);
    if (push == result.end()) continue;
    const double into = on.normal.dot(push->second.velocity);
    if (!(into < 0.0)) continue;
    const auto surface = static_cast<std::size_t>(model_.contact.now(k).surface);
    const std::shared_ptr<const Placement> at = model_.placement(until_);
    double share = 1.0;
    while (share > 1e-18 &&
           !(model_.contact.gap(*at, surface, vector_at(step.next_position, k) + share * h_ * into * on.normal) < 0.0))
      share *= 0.5;
    if (share < 1.0) share *= 0.25;  // its own forces press it on, too
    push->second.velocity += (share - 1.0) * into * on.normal;
  }
  return result;
}

// What impulses did not keep apart.
springnet_status VerletPairs::check(const springnet_sweep& step) const {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const double overlap = -gap(r, step.next_position);
    if (!(overlap > (rows_[r].is_blocked ? share_of_held : share_of_late) * contacts_[r].thickness)) continue;
    const char* const why = rows_[r].is_blocked
                                ? "and there is no place left for either between bodies and obstacles; stop their "
                                  "motion earlier, or let them escape"
                                : "at the end of a step in which they meet and turn";
    set_message(model_.journal.message,
                fmt::format("{} overlap by {:g} m, {}",
                            model_.constraints.bodies().describe(rows_[r].kind, rows_[r].pair), overlap, why));
    return SPRINGNET_RECOVERABLE;
  }
  return SPRINGNET_OK;
}

springnet_status VerletPairs::drift(const springnet_sweep& step, const ConstrainOthers& constrain_others) {
  try {
    const springnet_status status = keep_apart(step, constrain_others);
    return status == SPRINGNET_OK ? check(step) : status;
  } catch (const Diverged& diverged) {
    set_message(model_.journal.message, diverged.why);
    return SPRINGNET_RECOVERABLE;
  }
}

springnet_status VerletPairs::keep_apart(const springnet_sweep& step, const ConstrainOthers& constrain_others) {
  const std::size_t n = model_.node_count();
  const auto copy = [n](const springnet_vectors& from) {
    std::array<std::vector<double>, 3> to;
    to[0].assign(from.x, from.x + n);
    to[1].assign(from.y, from.y + n);
    to[2].assign(from.z, from.z + n);
    return to;
  };
  const auto put_back = [n](const std::array<std::vector<double>, 3>& from, const springnet_vectors& to) {
    std::copy_n(from[0].data(), n, to.x);
    std::copy_n(from[1].data(), n, to.y);
    std::copy_n(from[2].data(), n, to.z);
  };
  // Moved nodes go straight to where they will be.
  const Prescribed& prescribed = model_.contact.prescribed();
  const std::shared_ptr<const Placement> at = model_.placement(until_);
  for (std::uint32_t k = 0; k < n; ++k) {
    if (!prescribed.moves(k)) continue;
    const Vector3 place = prescribed.position(at->motions, k);
    put_vector(step.next_position, k, place);
    put_vector(step.next_velocity, k, (place - vector_at(step.start_position, k)) / h_);
  }
  const bool others = !model_.contact.obstacles().empty();
  std::array<std::vector<double>, 3> position, velocity;
  if (others) {
    position = copy(step.next_position);
    velocity = copy(step.next_velocity);
  }
  if (const springnet_status status = constrain_others({}); status != SPRINGNET_OK) return status;
  note_obstacles(step, true);
  if (clusters_.any()) clusters_.begin(step);
  if (!find(step)) return SPRINGNET_OK;
  std::vector<double> alone;  // mobility_ of nodes without rigid connections
  if (others) alone = mobility_;
  for (std::uint32_t k = 0; others && clusters_.any() && k < n; ++k)
    if (model_.rigid.is_joined(k)) alone[k] = 0.0;
  VerletContact::Pushes before;
  for (int round = 0; round < max_obstacle_rounds; ++round) {
    if (const springnet_status status = separate(step); status != SPRINGNET_OK) return status;
    if (!others) return SPRINGNET_OK;
    const VerletContact::Pushes given = pushes(step);
    double changed = 0.0;  // m
    for (const auto& [node, push] : given) {
      const auto found = before.find(node);
      const Vector3 last = found == before.end() ? Vector3(Vector3::Zero()) : found->second.velocity;
      changed = std::max(changed, h_ * (push.velocity - last).norm());
    }
    // Iterations are no more accurate than that; impulses of redundant pairs differ more, which moves nothing.
    if (round > 0 && changed <= (round < 10 ? 1.0 : 10.0) * tolerance_.gap) return SPRINGNET_OK;
    before = given;
    put_back(position, step.next_position);
    put_back(velocity, step.next_velocity);
    const MovedNodes nodes{step.next_position, step.next_velocity, &alone};
    for (const PairRow& row : rows_) apply(row, row.impulse, nodes);
    for (const auto& [node, push] : given) {
      if (!model_.rigid.is_joined(node) || mobility_[node] == 0.0) continue;
      put_vector(step.next_velocity, node, vector_at(step.next_velocity, node) + push.velocity);
      put_vector(step.next_position, node, vector_at(step.next_position, node) + h_ * push.velocity + push.shift);
    }
    const std::vector<Touch> held = clusters_.touches();
    if (const springnet_status status = constrain_others(given); status != SPRINGNET_OK) return status;
    const bool holds_others = clusters_.touches() != held;
    if (round < max_reopened && holds_others) reopen_impacts();
    double turned = 0.0;
    if (const springnet_status status = clusters_.keep_lengths(step, turned); status != SPRINGNET_OK) return status;
    note_obstacles(step, true);
    if (holds_others) clusters_.renew();
    set_blocked(step);
  }
  return fail();
}

springnet_status VerletPairs::kick(const springnet_sweep& step) {
  kicked_ = true;
  BodyContacts& bodies = model_.constraints.bodies();
  if (rows_.empty()) {
    bodies.set_touching({});
    return SPRINGNET_OK;
  }
  // Obstacles have done their part of the kick: nodes that they keep go on as they say.
  note_obstacles(step, false);
  EndingPairs pairs;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    EndingPair& pair = pairs[std::pair(rows_[r].kind, rows_[r].pair)];
    pair.row = rows_[r];
    pair.impulse += rows_[r].impulse;
    pair.bounced = contacts_[r].bounces;
  }
  const PairEnding ending{until_, h_, moved(step), step.start_velocity, true, clusters_.loose()};
  return end_pairs(model_, ending, std::move(pairs)) == SPRINGNET_OK ? SPRINGNET_OK : fail();
}

}  // namespace springnet
