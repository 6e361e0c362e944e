// Which of the nodes whose contact would change in a sweep do so.
//
// Newton's method solves for all nodes at once with the contacts that it has, and the host then decides each node's
// contact by itself. That settles in a few sweeps where contacts hardly influence each other. In a stiff body they do:
// where many nodes meet a surface at once, the few that take the weight lift the others off, and decisions that all
// follow the same outputs may run in a circle. So after some sweeps only those change whose decision moves them
// farthest; then one; and at last the first of them, which ends where the problem has one solution (Murty 1974, "Note
// on a Bard-type scheme for solving the complementarity problem").
#include <algorithm>
#include <cmath>

#include "constraints/cluster.hpp"
#include "constraints/contact.hpp"
#include "constraints/contact_within.hpp"
#include "constraints/vectors.hpp"

namespace springnet {
namespace {

// Sweeps of a step that changed contacts, until nodes are chosen, until one is, and until that is the first.
constexpr int until_some = 1, until_one = 16, until_first = 48;
// Of the longest way that a decision moves a node: those beyond it change.
constexpr double share_of_longest = 0.5;

bool decides(const springnet_sweep& sweep) noexcept {
  return sweep.contacts == 0 || sweep.contacts == SPRINGNET_MAY_TOUCH;
}

}  // namespace

bool Contact::limits_changes(const springnet_sweep& sweep) const noexcept {
  return decides(sweep) && !obstacles_.empty() && changed_sweeps_ >= until_some;
}

void Contact::remember(const springnet_sweep& sweep) {
  if (obstacles_.empty() || !decides(sweep)) return;
  before_.now = now_;
  if (!limits_changes(sweep)) return;
  before_.changes = changes_;
  before_.slide_changes = slide_changes_;
  before_.was_in_contact = was_in_contact_;
  before_.last_surface = last_surface_;
  before_.slip = slip_;
  const std::size_t n = now_.size();
  before_.outputs.resize(6 * n);
  const double* const from[] = {sweep.next_position.x, sweep.next_position.y, sweep.next_position.z,
                                sweep.next_velocity.x, sweep.next_velocity.y, sweep.next_velocity.z};
  for (std::size_t c = 0; c < 6; ++c) std::copy_n(from[c], n, before_.outputs.data() + c * n);
}

bool Contact::is_simple(std::uint32_t node, const Touch& touch) const {
  return touch.count() <= 1 && bounces_[node] == 0 && (touch.surface < 0 || !holds(touch.surface));
}

// The outputs of the update, before contact, m and m/s.
void Contact::restore_outputs(const springnet_sweep& sweep, std::uint32_t node) {
  const std::size_t n = now_.size();
  const double* const made = before_.outputs.data();
  put_vector(sweep.next_position, node, {made[node], made[n + node], made[2 * n + node]});
  put_vector(sweep.next_velocity, node, {made[3 * n + node], made[4 * n + node], made[5 * n + node]});
  if (sweep.constraint_force.x != nullptr) put_vector(sweep.constraint_force, node, Vector3::Zero());
}

// The outputs of a node with the contact that it had before, m and m/s; the contact is set, too.
void Contact::take_back(const Within& within, std::uint32_t node) {
  const springnet_sweep& sweep = within.sweep;
  changes_[node] = before_.changes[node];
  slide_changes_[node] = before_.slide_changes[node];
  was_in_contact_[node] = before_.was_in_contact[node];
  last_surface_[node] = before_.last_surface[node];
  slip_[node] = before_.slip[node];
  const Touch& touch = before_.now[node];
  restore_outputs(sweep, node);
  if (touch.surface < 0) {
    decide(node, {}, Vector3::Zero());
    return;
  }
  keep(within, node, touch, candidate_of(within, node, nullptr));
}

void Contact::limit_changes(const Placement& end, const springnet_sweep& sweep, const std::uint32_t* cluster) {
  if (obstacles_.empty() || !decides(sweep)) return;
  const bool limits = limits_changes(sweep);
  changing_.clear();
  bool any = false;
  for (std::uint32_t k = 0; k < now_.size(); ++k) {
    if (fixed_[k] != 0 || before_.now[k] == now(k)) continue;
    any = true;
    if (!limits || !is_simple(k, before_.now[k]) || !is_simple(k, now(k)) ||
        (cluster != nullptr && cluster[k] != no_cluster))
      continue;
    changing_.push_back({k, now(k), 0.0, vector_at(sweep.next_position, k), vector_at(sweep.next_velocity, k),
                         sweep.constraint_force.x != nullptr ? vector_at(sweep.constraint_force, k) : Vector3::Zero(),
                         sweep_impulse_[k], slip_[k], lands_[k], landing_[k]});
  }
  if (any) ++changed_sweeps_;
  if (changing_.empty() || (changing_.size() < 2 && !slips_first(changing_.front()))) return;
  springnet_sweep keeping = sweep;
  keeping.contacts = 1;
  const Within within{keeping, end};
  double longest = 0.0;
  for (Changing& each : changing_) {
    take_back(within, each.node);
    each.way = (vector_at(sweep.next_position, each.node) - each.position).norm() +
               sweep.time_constant * (vector_at(sweep.next_velocity, each.node) - each.velocity).norm();
    // One that has changed before may wait for those that have not: two that differ most could take turns for ever.
    each.way = std::ldexp(each.way, -2 * std::min(limited_changes_[each.node], 50));
    longest = std::max(longest, each.way);
  }
  const auto first_longest =
      std::find_if(changing_.begin(), changing_.end(), [&](const Changing& each) { return !(each.way < longest); });
  for (auto each = changing_.begin(); each != changing_.end(); ++each) {
    const bool changes = changed_sweeps_ > until_first ? each == changing_.begin()
                         : changed_sweeps_ > until_one ? each == first_longest
                                                       : !(each->way < share_of_longest * longest);
    if (changes && slips_first(*each))
      slip_instead(within, each->node);
    else if (changes)
      change_as_decided(sweep, *each);
  }
}

// Where a node sticks by friction, the reaction leaves the cone of friction before it pulls: then the node slides, and
// may be released after that.
bool Contact::slips_first(const Changing& change) const {
  const Touch& touch = before_.now[change.node];
  return change.touch.surface < 0 && touch.surface >= 0 && !touch.slides &&
         obstacles_[static_cast<std::size_t>(touch.surface)].friction().kind == Friction::Kind::coulomb;
}

void Contact::slip_instead(const Within& within, std::uint32_t node) {
  const std::int32_t surface = before_.now[node].surface;
  restore_outputs(within.sweep, node);
  const Candidate candidate = candidate_of(within, node, nullptr);
  slip_[node] = slip_vector(within.at, node, static_cast<std::size_t>(surface), candidate.position, candidate.velocity);
  ++limited_changes_[node];
  keep(within, node, {surface, true}, candidate);
}

void Contact::change_as_decided(const springnet_sweep& sweep, const Changing& change) {
  const std::uint32_t k = change.node;
  ++limited_changes_[k];
  static_cast<void>(record_decision(k, change.touch.surface >= 0));
  if (change.touch.slides) slip_[k] = change.slip;
  decide(k, change.touch, change.impulse);
  lands_[k] = change.lands;
  landing_[k] = change.landing;
  put_vector(sweep.next_position, k, change.position);
  put_vector(sweep.next_velocity, k, change.velocity);
  if (sweep.constraint_force.x != nullptr) put_vector(sweep.constraint_force, k, change.force);
}

}  // namespace springnet
