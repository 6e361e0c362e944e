#include "simulation/verlet_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "plugin_host/message.hpp"
#include "profile/stage.hpp"

namespace springnet {
namespace {

// Of gaps, in units of the tolerance of places on obstacles. Faces on faces have more pairs than determine their
// places, from slightly different times at which these met, and so agree no better.
constexpr double gap_tolerance = 100.0;
constexpr int max_pair_iterations = 20000;  // of impulses
constexpr int max_pair_rounds = 100;        // of finding pairs, and of curved gaps
// A pair that meets at the very end of a step: impulses of the kick stop it.
constexpr double least_lever = 1e-3;  // of the step

// When and how a pair comes to its thickness, from a meeting that may be a little early: Newton's method on the
// distance along the paths.
proximity::Meeting refine(proximity::PairKind kind, const std::array<Vector3, 4>& start,
                          const std::array<Vector3, 4>& end, double thickness, proximity::Meeting found) {
  constexpr int most = 8;
  for (int i = 0; i < most; ++i) {
    double rate = 0.0;  // of the distance, over the step
    for (std::size_t k = 0; k < 4; ++k) rate += found.at.weights[k] * found.at.direction.dot(end[k] - start[k]);
    const double gap = found.at.distance - thickness;
    if (!(rate < 0.0) || !(gap > 0.0) || found.time - gap / rate > 1.0) break;
    const double time = found.time - gap / rate;
    if (!(time > found.time)) break;
    std::array<Vector3, 4> now;
    for (std::size_t k = 0; k < 4; ++k) now[k] = start[k] + time * (end[k] - start[k]);
    found.at = on_side(separation(kind, now), found.at.direction);
    found.time = time;
  }
  return found;
}

}  // namespace

VerletPairs::VerletPairs(Model& model, double until, double length)
    : model_(model),
      from_(model.time),
      until_(until),
      h_(length),
      tolerance_(gap_tolerance * model.contact_tolerance()),
      accuracy_(0.1 * tolerance_),
      mobility_(model.node_count()) {
  for (std::uint32_t k = 0; k < model.node_count(); ++k)
    mobility_[k] = model.contact.fixed()[k] != 0 ? 0.0 : 1.0 / model.mass[k];
}

void VerletPairs::add(const springnet_sweep& step, proximity::PairKind kind, proximity::Pair pair,
                      const proximity::Separation& at, double share, bool is_new) {
  BodyContacts& bodies = model_.constraints.bodies();
  const BodyContact& law = bodies.law_of(kind, pair);
  PairRow row;
  row.kind = kind;
  row.pair = pair;
  row.nodes = bodies.primitives().nodes_of(kind, pair);
  row.weights = at.weights;
  row.count = proximity::first_nodes(kind) + proximity::second_nodes(kind);
  row.normal = at.direction;
  row.lever = std::max(least_lever, 1.0 - share) * h_;
  row.friction = coefficient_of(law.friction);
  known_.emplace(kind, pair);
  if (!set_mobility(row, mobility_)) return;
  Contact contact{at.direction, bodies.primitives().thickness(kind, pair), 0.0, law.restitution};
  if (is_new) {
    const Vector3 half = relative(row, step.next_velocity);
    contact.came = std::max(0.0, -row.normal.dot(half));
    // A rebound slower than the fall within the step ends in contact.
    Vector3 start = Vector3::Zero();
    for (int i = 0; i < row.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      start += row.weights[k] * vector_at(step.start_velocity, row.nodes[k]);
    }
    const double falls = 2.0 * std::max(0.0, -row.normal.dot(half - start));
    if (law.restitution * contact.came > falls) {
      row.by_rate = true;
      row.value = -law.restitution * contact.came;
    }
  }
  rows_.push_back(row);
  contacts_.push_back(contact);
}

bool VerletPairs::find(const springnet_sweep& step) {
  const profile::Stage stage("proximity");
  BodyContacts& bodies = model_.constraints.bodies();
  const std::size_t n = model_.node_count();
  const proximity::Positions start = positions_of(step.start_position, n),
                             end = positions_of(read_only(step.next_position), n);
  bodies.list().update(start, end);
  const proximity::Primitives& all = bodies.primitives();
  const unsigned threads = model_.evaluator.threads();
  proximity::find_near(all, bodies.list().pairs(), end, 0.0, near_, threads);
  proximity::find_meetings(all, bodies.list().pairs(), start, end, met_, threads);
  const std::size_t before = rows_.size();
  const auto is_known = [&](proximity::PairKind kind, proximity::Pair pair) {
    return known_.contains(std::pair(kind, pair));
  };
  const auto from_start = [&](proximity::PairKind kind, proximity::Pair pair) {
    add(step, kind, pair, separation(kind, all.corners(kind, pair, start)), 0.0, false);
  };
  if (rows_.empty())  // what touched before
    for (const PairTouch& touch : bodies.touching()) {
      from_start(touch.kind, touch.pair);
      // Begins with the force of the last step, so that what rests stays where it is.
      if (rows_.empty() || rows_.back().pair != touch.pair || rows_.back().kind != touch.kind) continue;
      PairRow& row = rows_.back();
      const double along = std::max(0.0, row.normal.dot(touch.force));
      const Vector3 across = touch.force - row.normal * row.normal.dot(touch.force);
      row.impulse = 0.5 * h_ * (along * row.normal + across);
      apply(row, row.impulse, {step.next_position, step.next_velocity, &mobility_});
    }
  for (const proximity::MeetingPair& each : met_) {
    if (is_known(each.kind, each.pair)) continue;
    if (each.meeting.from_start) {
      from_start(each.kind, each.pair);
      continue;
    }
    const proximity::Meeting meeting =
        refine(each.kind, all.corners(each.kind, each.pair, start), all.corners(each.kind, each.pair, end),
               all.thickness(each.kind, each.pair), each.meeting);
    add(step, each.kind, each.pair, meeting.at, meeting.time, true);
  }
  for (const proximity::NearPair& each : near_)
    if (each.gap < -tolerance_ && !is_known(each.kind, each.pair)) from_start(each.kind, each.pair);
  return rows_.size() > before;
}

double VerletPairs::gap(std::size_t row, const springnet_vectors& position) const {
  const PairRow& of = rows_[row];
  const proximity::Primitives& all = model_.constraints.bodies().primitives();
  const proximity::Positions x = positions_of(read_only(position), model_.node_count());
  const proximity::Separation now = on_side(separation(of.kind, all.corners(of.kind, of.pair, x)), contacts_[row].side);
  return now.distance - contacts_[row].thickness;
}

springnet_status VerletPairs::fail() const {
  set_message(
      model_.journal.message,
      fmt::format("the contacts of bodies, {} pairs, do not converge in a step of {:g} s; use a smaller time step",
                  rows_.size(), h_));
  return SPRINGNET_RECOVERABLE;
}

springnet_status VerletPairs::separate(const springnet_sweep& step) {
  const MovedNodes nodes{step.next_position, step.next_velocity, &mobility_};
  for (int round = 0; round < max_pair_rounds; ++round) {
    bool done = true;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      PairRow& row = rows_[r];
      if (row.by_rate) {
        done = done && round > 0;
        continue;
      }
      const double now = gap(r, step.next_position);
      row.value = now - row.normal.dot(relative(row, step.next_position));
      const bool pushes = row.normal.dot(row.impulse) > 0.0;
      done = done && (pushes ? std::abs(now) <= tolerance_ : now >= -tolerance_);
    }
    // Friction has no say in gaps: it needs an iteration of its own.
    if (done && round > 0 && !find(step)) return SPRINGNET_OK;
    if (solve(rows_, nodes, h_, accuracy_, max_pair_iterations).residual > accuracy_) return fail();
  }
  return fail();
}

springnet_status VerletPairs::drift(const springnet_sweep& step,
                                    const std::function<springnet_status()>& constrain_others) {
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
  const bool others = !model_.contact.obstacles().empty();
  std::array<std::vector<double>, 3> position, velocity;
  if (others) {
    position = copy(step.next_position);
    velocity = copy(step.next_velocity);
  }
  if (const springnet_status status = constrain_others(); status != SPRINGNET_OK) return status;
  if (!find(step)) return SPRINGNET_OK;
  for (int round = 0; round < max_pair_rounds; ++round) {
    std::vector<Vector3> before;
    for (const PairRow& row : rows_) before.push_back(row.impulse);
    if (const springnet_status status = separate(step); status != SPRINGNET_OK) return status;
    if (!others) return SPRINGNET_OK;
    double changed = 0.0;  // m
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const Vector3 change = rows_[r].impulse - (r < before.size() ? before[r] : Vector3(Vector3::Zero()));
      changed = std::max(changed, rows_[r].lever * rows_[r].mobility * change.norm());
    }
    if (round > 0 && changed <= 10.0 * accuracy_) return SPRINGNET_OK;
    put_back(position, step.next_position);
    put_back(velocity, step.next_velocity);
    const MovedNodes nodes{step.next_position, step.next_velocity, &mobility_};
    for (const PairRow& row : rows_) apply(row, row.impulse, nodes);
    if (const springnet_status status = constrain_others(); status != SPRINGNET_OK) return status;
  }
  return fail();
}

void VerletPairs::record(Event::Kind kind, const PairRow& row, const springnet_sweep& step, const Vector3& impulse) {
  Event event{kind, until_, model_.user_number(row.nodes[0])};
  event.impulse = impulse;
  const auto firsts = static_cast<std::size_t>(proximity::first_nodes(row.kind));
  for (int i = 0; i < row.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    event.pair[k] = model_.user_number(row.nodes[k]);
    if (k < firsts) {
      event.position += row.weights[k] * vector_at(step.next_position, row.nodes[k]);
      event.velocity += row.weights[k] * vector_at(step.start_velocity, row.nodes[k]);
    }
  }
  event.pair_first = static_cast<std::uint8_t>(firsts);
  event.pair_count = static_cast<std::uint8_t>(row.count);
  event.normal = row.normal;
  model_.journal.record(event);
}

springnet_status VerletPairs::kick(const springnet_sweep& step) {
  kicked_ = true;
  BodyContacts& bodies = model_.constraints.bodies();
  const proximity::Primitives& all = bodies.primitives();
  const proximity::Positions end = positions_of(read_only(step.next_position), model_.node_count());
  // Obstacles have done their part of the kick: nodes that they keep go on as they say.
  std::vector<double> mobility = mobility_;
  for (std::uint32_t k = 0; !model_.contact.obstacles().empty() && k < model_.node_count(); ++k)
    if (model_.contact.committed(k).surface >= 0) mobility[k] = 0.0;
  std::vector<PairRow> rows;
  std::vector<std::size_t> place;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const PairRow& of = rows_[r];
    if (of.by_rate) continue;
    const proximity::Separation now =
        on_side(separation(of.kind, all.corners(of.kind, of.pair, end)), contacts_[r].side);
    if (now.distance - contacts_[r].thickness > 2.0 * tolerance_) continue;
    PairRow row = of;
    row.weights = now.weights;
    row.normal = now.direction;
    row.lever = 0.0;
    row.by_rate = true;
    row.value = 0.0;
    // As in the drift, if it rests.
    if (contacts_[r].came > 0.0) row.impulse.setZero();
    if (!set_mobility(row, mobility)) continue;
    apply(row, row.impulse, {step.next_position, step.next_velocity, &mobility});
    rows.push_back(row);
    place.push_back(r);
  }
  const MovedNodes nodes{step.next_position, step.next_velocity, &mobility};
  if (solve(rows, nodes, h_, accuracy_, max_pair_iterations).residual > accuracy_) return fail();
  std::vector<std::uint8_t> stays(rows_.size(), 0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    contacts_[place[i]].kick = rows[i].impulse;
    const double rate = rows[i].normal.dot(relative(rows[i], step.next_velocity));
    stays[place[i]] = rate <= 10.0 * std::max(accuracy_ / h_, model_.no_speed()) ? 1 : 0;
  }
  const std::vector<PairTouch> before = bodies.touching();
  std::vector<PairTouch> touching;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const PairRow& row = rows_[r];
    const Vector3 impulse = row.impulse + contacts_[r].kick;
    const bool touched = std::any_of(before.begin(), before.end(), [&](const PairTouch& each) {
      return each.kind == row.kind && each.pair == row.pair;
    });
    const bool acts = row.normal.dot(impulse) > 0.0;
    if (!touched && acts) record(Event::Kind::met, row, step, impulse);
    if (stays[r] != 0 && (touched || acts)) {
      touching.push_back({row.kind, row.pair, impulse / h_});
    } else if (touched || acts) {
      record(Event::Kind::parted, row, step, Vector3::Zero());
    }
  }
  std::sort(touching.begin(), touching.end(), [](const PairTouch& a, const PairTouch& b) { return a.key() < b.key(); });
  bodies.set_touching(std::move(touching));
  return SPRINGNET_OK;
}

}  // namespace springnet
