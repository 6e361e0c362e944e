#include "simulation/pair_events.hpp"

#include <limits>
#include <set>

#include <Eigen/Geometry>

#include "constraints/friction.hpp"
#include "constraints/vectors.hpp"
#include "simulation/body_motion.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {
namespace {

std::size_t firsts_of(const PairMotion& pair) { return static_cast<std::size_t>(proximity::first_nodes(pair.kind)); }

}  // namespace

Vector3 first_velocity(const PairMotion& pair, const springnet_const_vectors& velocity) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < firsts_of(pair); ++i) sum += pair.weights[i] * vector_at(velocity, pair.nodes[i]);
  return sum;
}

void record_pair(Model& model, Event::Kind kind, double time, const PairMotion& pair,
                 const springnet_const_vectors& position, const Vector3& came, const Vector3& impulse) {
  Event event{kind, time, model.user_number(pair.nodes[0])};
  event.impulse = impulse;
  for (std::size_t i = 0; i < pair.count; ++i) {
    event.pair[i] = model.user_number(pair.nodes[i]);
    if (i < firsts_of(pair)) event.position += pair.weights[i] * vector_at(position, pair.nodes[i]);
  }
  event.velocity = came;
  event.pair_first = static_cast<std::uint8_t>(firsts_of(pair));
  event.pair_count = static_cast<std::uint8_t>(pair.count);
  event.normal = pair.normal;
  model.journal.record(event);
}

bool can_move(const Model& model, const std::array<NodeIndex, 4>& nodes, const std::array<double, 4>& weights) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (weights[i] != 0.0 && model.contact.fixed()[nodes[i]] == 0) return true;
  return false;
}

std::vector<proximity::NearPair> pairs_apart_within(Model& model, const springnet_const_vectors& position, double gap) {
  BodyContacts& bodies = model.constraints.bodies();
  if (!bodies.any()) return {};
  const proximity::Positions x = positions_of(position, model.node_count());
  bodies.list().update(x);
  std::vector<proximity::NearPair> near;
  proximity::find_near(bodies.primitives(), bodies.list().close(gap), x, gap, near, model.evaluator.threads());
  std::set<std::pair<proximity::PairKind, proximity::Pair>> touching;
  for (const PairTouch& touch : bodies.touching()) touching.insert(touch.key());
  std::erase_if(near, [&](const proximity::NearPair& each) {
    return touching.contains({each.kind, each.pair}) ||
           !can_move(model, bodies.primitives().nodes_of(each.kind, each.pair), each.separation.weights);
  });
  return near;
}

void keep_direction_of_pair(Model& model, double time, const State& state, PairTouch& touching) {
  BodyContacts& bodies = model.constraints.bodies();
  const springnet_const_vectors position = read_only(state.view.position), velocity = read_only(state.view.velocity);
  const PairMotion motion = pair_motion(bodies, touching, position, velocity, model.node_count());
  const Vector3 slip = motion.slip();
  if (slip.isZero(0.0)) return;
  const Vector3 goes = slip.normalized();
  touching.phase = Contact::Slip::ending;
  touching.slip = goes;
  if (coefficient_of(bodies.law_of(touching.kind, touching.pair).friction) >= friction_of_held) return;
  const auto place = static_cast<std::size_t>(&touching - bodies.touching().data());
  double slows = 0.0;
  const auto found = find_direction(motion.normal, goes, [&](const Vector3& against) {
    touching.slip = against;
    ReactionsAt reactions(model, time, position, velocity);
    const BodyMotion* all = nullptr;
    if (reactions.bodies(all) != SPRINGNET_OK || all == nullptr) return std::numeric_limits<double>::quiet_NaN();
    const Vector3& a = all->pairs()[place].acceleration;
    slows = -goes.dot(a);
    return motion.normal.dot(goes.cross(a));
  });
  // Otherwise the slip does not end, but passes by zero.
  touching.slip = found && found->dot(goes) > 0.0 && slows > 0.0 ? *found : goes;
}

}  // namespace springnet
