#include "simulation/pair_ending.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <vector>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "simulation/pair_events.hpp"

namespace springnet {
namespace {

constexpr double accuracy_share = 1e-5;  // of the tolerance of gaps: most have it soon

void record(Model& model, Event::Kind kind, const PairRow& row, const PairEnding& step, const Vector3& impulse) {
  PairMotion pair;
  pair.kind = row.kind;
  pair.nodes = row.nodes;
  pair.weights = row.weights;
  pair.count = static_cast<std::size_t>(row.count);
  pair.normal = row.normal;
  record_pair(model, kind, step.until, pair, read_only(step.nodes.position), first_velocity(pair, step.start_velocity),
              impulse);
}

ClusterResponses clusters_of(const Model& model, const PairEnding& step, const std::vector<proximity::NearPair>& near) {
  ClusterResponses result;
  if (!model.rigid.any()) return result;
  std::set<std::uint32_t> struck;
  for (const proximity::NearPair& each : near) {
    const std::array<std::uint32_t, 4> nodes = model.constraints.bodies().primitives().nodes_of(each.kind, each.pair);
    const int count = proximity::first_nodes(each.kind) + proximity::second_nodes(each.kind);
    struck.insert(nodes.begin(), nodes.begin() + count);
  }
  result.set(
      model.rigid, *model.placement(step.until), read_only(step.nodes.position), {struck.begin(), struck.end()},
      [&](std::uint32_t node) -> Matrix3 { return Matrix3::Identity() / model.mass[node]; }, step.loose);
  return result;
}

}  // namespace

// The tolerance of contact looks at all nodes.
PairTolerances::PairTolerances(const Model& model) : PairTolerances(model, model.contact_tolerance()) {}

PairTolerances::PairTolerances(const Model& model, double contact_tolerance)
    : gap(std::max(gap_tolerance * model.constraints.bodies().least_thickness(), contact_tolerance)),
      accuracy(std::max(accuracy_share * gap, 0.1 * contact_tolerance)) {}

std::vector<double> pair_mobility(const Model& model) {
  std::vector<double> result(model.node_count());
  for (std::uint32_t k = 0; k < model.node_count(); ++k)
    result[k] = model.contact.fixed()[k] != 0 ? 0.0 : 1.0 / model.mass[k];
  return result;
}

PairRow row_of(const BodyContacts& bodies, proximity::PairKind kind, proximity::Pair pair,
               const proximity::Separation& at) {
  PairRow row;
  row.kind = kind;
  row.pair = pair;
  row.nodes = bodies.primitives().nodes_of(kind, pair);
  row.weights = at.weights;
  row.count = proximity::first_nodes(kind) + proximity::second_nodes(kind);
  row.normal = at.direction;
  row.friction = coefficient_of(bodies.law_of(kind, pair).friction);
  return row;
}

bool is_on_obstacle(const Model& model, const Placement& at, std::uint32_t node, const Touch& touch,
                    const Vector3& position, OnObstacle& on) {
  if (touch.surface < 0 || model.contact.fixed()[node] != 0) return false;
  if (model.rigid.is_joined(node)) return false;  // the response of its cluster includes them
  const auto surface = static_cast<std::size_t>(touch.surface);
  // Coulomb's friction gives way to a push; how far, the obstacle says.
  const Friction& friction = model.contact.obstacles()[surface].friction();
  on = {model.contact.normal(at, surface, position),
        touch.count() > 1 || (!touch.slides && friction.kind == Friction::Kind::held)};
  return true;
}

springnet_status end_pairs(Model& model, const PairEnding& step, EndingPairs pairs) {
  BodyContacts& bodies = model.constraints.bodies();
  MovedNodes nodes = step.nodes;
  const PairTolerances tolerance(model);
  for (const PairTouch& touch : bodies.touching())
    if (const auto found = pairs.find(touch.key()); found != pairs.end()) found->second.touched = true;
  // All that touch at the end, also what a node has slid to within the step.
  const proximity::Primitives& all = bodies.primitives();
  const proximity::Positions end = positions_of(read_only(nodes.position), model.node_count());
  std::vector<proximity::NearPair> near;
  try {
    bodies.list().update(end);
  } catch (const Error&) {  // the motion diverges, or bodies collapse
    return SPRINGNET_RECOVERABLE;
  }
  proximity::find_near(all, bodies.list().close(2.0 * tolerance.gap), end, 2.0 * tolerance.gap, near,
                       model.evaluator.threads());
  const ClusterResponses clusters = clusters_of(model, step, near);
  if (clusters.any()) nodes.clusters = &clusters;
  std::vector<PairRow> rows;
  std::vector<EndingPair*> of_row;
  std::set<const EndingPair*> held;  // that nothing can move: they go on touching
  for (const proximity::NearPair& each : near) {
    const auto known = pairs.find(std::pair(each.kind, each.pair));
    const bool pushed = known != pairs.end() && known->second.row.normal.dot(known->second.impulse) > 0.0;
    PairRow row = row_of(bodies, each.kind, each.pair, each.separation);
    if (!set_mobility(row, nodes)) {
      if (pushed || (known != pairs.end() && known->second.touched)) held.insert(&known->second);
      continue;
    }
    // Beside the border of a face its direction is not that of the face, however small the gap.
    if (!pushed && each.gap > 2.0 * tolerance.accuracy) continue;
    EndingPair& ending = pairs[std::pair(each.kind, each.pair)];
    if (ending.bounced) continue;
    row.by_rate = true;
    row.value = -ending.rebound;
    if (!step.in_halves) {
      // Has acted already. At theta < 1, keeping a pair apart takes more impulse than stopping it: the excess is taken
      // back, and friction is in the cone of what is left.
      row.impulse = ending.impulse;
    } else if (ending.touched) {
      row.impulse = ending.impulse;  // as before, if it rests
      apply(row, row.impulse, nodes);
    }
    rows.push_back(row);
    of_row.push_back(&ending);
  }
  const PairAccuracy accuracy{tolerance.accuracy, tolerance.gap, pair_patience, most_pair_iterations};
  if (solve(rows, nodes, step.length, accuracy).residual > tolerance.gap) return SPRINGNET_RECOVERABLE;
  const double no_rate = std::max(0.1 * tolerance.gap / step.length, model.no_speed());
  std::map<const EndingPair*, Vector3> last;  // N s, at the end
  std::map<const EndingPair*, bool> stays;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    of_row[i]->row = rows[i];
    last[of_row[i]] = step.in_halves ? rows[i].impulse : Vector3(rows[i].impulse - of_row[i]->impulse);
    stays[of_row[i]] = rows[i].normal.dot(relative(rows[i], nodes.velocity)) <= no_rate;
  }
  std::vector<PairTouch> touching;
  for (const auto& [key, pair] : pairs) {
    const auto found = last.find(&pair);
    const Vector3 at_end = found == last.end() ? Vector3(Vector3::Zero()) : found->second;
    const Vector3 impulse = pair.impulse + at_end;
    const bool acts = pair.row.normal.dot(impulse) > 0.0;
    if (!pair.touched && acts) record(model, Event::Kind::met, pair.row, step, impulse);
    if ((stays[&pair] || held.contains(&pair)) && (pair.touched || acts)) {
      const Vector3 guess = step.in_halves ? Vector3(2.0 * at_end) : pair.impulse;
      touching.push_back({key.first, key.second, impulse / step.length, guess / step.length});
    } else if (pair.touched || acts) {
      // Its last step has no row among the forces of pairs that touch. What met in it has that impulse already.
      record(model, Event::Kind::parted, pair.row, step, pair.touched ? impulse : Vector3(Vector3::Zero()));
    }
  }
  bodies.set_touching(std::move(touching));
  return SPRINGNET_OK;
}

}  // namespace springnet
