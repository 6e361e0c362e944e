#include "simulation/pair_events.hpp"

#include <set>

#include "constraints/vectors.hpp"

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
  proximity::find_near(bodies.primitives(), bodies.list().pairs(), x, gap, near, model.evaluator.threads());
  std::set<std::pair<proximity::PairKind, proximity::Pair>> touching;
  for (const PairTouch& touch : bodies.touching()) touching.insert(touch.key());
  std::erase_if(near, [&](const proximity::NearPair& each) {
    return touching.contains({each.kind, each.pair}) ||
           !can_move(model, bodies.primitives().nodes_of(each.kind, each.pair), each.separation.weights);
  });
  return near;
}

}  // namespace springnet
