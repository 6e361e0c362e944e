#include "simulation/reactions_at.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include <springnet/error.hpp>

#include "constraints/friction.hpp"
#include "constraints/island.hpp"
#include "constraints/vectors.hpp"

namespace springnet {
namespace {

constexpr double rounding = 1e-9;  // of friction at the edge of its cone, relative to the reaction

}  // namespace

ReactionsAt::ReactionsAt(Model& model, double time, const springnet_const_vectors& position,
                         const springnet_const_vectors& velocity, const layers::InternalView& internal,
                         std::shared_ptr<const Placement> placement)
    : model_(model),
      time_(time),
      internal_(internal),
      position_(position),
      velocity_(velocity),
      external_(model.external_at(time)),
      placement_(placement ? std::move(placement) : model.placement(time)),
      cluster_known_(model.rigid.cluster_count(), 0) {
  if (model.layout.elements().live_enclosures() > 0)
    volumes_.compute(model.layout.elements(), node_arrays(position, velocity, internal_));
  if (!cluster_known_.empty()) {
    const std::size_t n = model.layout.node_count();
    for (auto* values : {&free_, &constrained_}) values->resize(3 * n);
    tension_.resize(model.rigid.rods().size());
  }
}

springnet_status ReactionsAt::prepare(std::vector<std::uint32_t> nodes) {
  const layers::NodeArrays arrays = node_arrays(position_, velocity_, internal_);
  double forces[3][layers::together_limit], accelerations[3][layers::together_limit];
  double* const force[3] = {forces[0], forces[1], forces[2]};
  double* const acceleration[3] = {accelerations[0], accelerations[1], accelerations[2]};
  prepared_ = std::move(nodes);
  prepared_acceleration_.clear();
  for (std::size_t begin = 0; begin < prepared_.size(); begin += layers::together_limit) {
    const std::size_t count = std::min(layers::together_limit, prepared_.size() - begin);
    const std::span<const std::uint32_t> list = std::span(prepared_).subspan(begin, count);
    layers::ListedNodes own;  // not initialised: written before it is read
    model_.evaluator.copy(list, arrays, own);
    springnet_status status = model_.evaluator.evaluate_together({list}, own, time_, arrays, external_, &volumes_,
                                                                 force, model_.journal.message);
    if (status == SPRINGNET_OK)
      status = model_.evaluator.accelerations(list, own, time_, force, acceleration, model_.journal.message);
    if (status != SPRINGNET_OK) {
      prepared_.clear();
      return status;
    }
    for (std::size_t i = 0; i < count; ++i)
      prepared_acceleration_.emplace_back(acceleration[0][i], acceleration[1][i], acceleration[2][i]);
  }
  return SPRINGNET_OK;
}

springnet_status ReactionsAt::free_acceleration(std::uint32_t node, Vector3& acceleration) {
  const auto prepared = std::lower_bound(prepared_.begin(), prepared_.end(), node);
  if (prepared != prepared_.end() && *prepared == node) {
    acceleration = prepared_acceleration_[static_cast<std::size_t>(prepared - prepared_.begin())];
    return SPRINGNET_OK;
  }
  Vector3 force;
  return model_.evaluator.evaluate_node(node, time_, node_arrays(position_, velocity_, internal_), external_, &volumes_,
                                        force, acceleration, nullptr, nullptr, model_.journal.message);
}

Vector3 ReactionsAt::held(std::uint32_t node, Vector3 acceleration) const {
  double* const values[3] = {&acceleration[0], &acceleration[1], &acceleration[2]};
  model_.constraints.accelerate(*placement_, node, 1, position_, velocity_, values);
  return acceleration;
}

springnet_status ReactionsAt::bodies(const BodyMotion*& motion) {
  motion = nullptr;
  const BodyContacts& contacts = model_.constraints.bodies();
  if (!contacts.located() || contacts.touching().empty()) return SPRINGNET_OK;
  if (!bodies_) {
    bodies_.emplace();
    std::vector<std::uint32_t> nodes = std::move(prepared_);
    std::vector<Vector3> accelerations = std::move(prepared_acceleration_);
    const springnet_status status = bodies_->find(model_, *this);
    give(std::move(nodes), std::move(accelerations));
    if (status != SPRINGNET_OK) {
      bodies_.reset();
      return status;
    }
  }
  motion = &*bodies_;
  return SPRINGNET_OK;
}

springnet_status ReactionsAt::of(std::uint32_t node, Vector3& reaction) {
  if (model_.rigid.is_joined(node)) return of_cluster(model_.rigid.cluster_of()[node], node, reaction);
  const BodyMotion* pushed = nullptr;
  if (const springnet_status status = bodies(pushed); status != SPRINGNET_OK) return status;
  if (const BodyMotion::OfNode* const own = pushed == nullptr ? nullptr : pushed->find(node); own != nullptr) {
    reaction = own->reaction;
    return SPRINGNET_OK;
  }
  Vector3 free;
  if (const springnet_status status = free_acceleration(node, free); status != SPRINGNET_OK) return status;
  reaction = model_.constraints.reaction(node, free, held(node, free), position_, nullptr);
  return SPRINGNET_OK;
}

springnet_status ReactionsAt::unbraced(std::uint32_t node, Vector3& reaction) {
  const springnet_status status = of(node, reaction);
  const std::uint32_t* clusters = model_.rigid.cluster_of();
  if (status == SPRINGNET_OK && !bracing_.empty() && clusters[node] != ConstraintRow::no_node)
    reaction += model_.rigid.connection_force(node, position_, bracing_.data());
  return status;
}

springnet_status ReactionsAt::reported(std::uint32_t node, Vector3& reaction, Vector3* withheld) {
  const springnet_status status = of(node, reaction);
  const Touch& touch = model_.contact.committed(node);
  if (status != SPRINGNET_OK || touch.surface < 0) return status;
  const std::vector<Vector3> normals = model_.contact.normals(*placement_, node, vector_at(position_, node));
  const std::vector<std::size_t> pressing = pressing_surfaces(normals, reaction);
  std::vector<Vector3> some;
  for (const std::size_t i : pressing) some.push_back(normals[i]);
  const Vector3 all = reaction;
  reaction.setZero();
  if (!some.empty()) {
    const SplitReaction split = split_reaction(some, all);
    double limit = 0.0;
    for (std::size_t s = 0; s < some.size(); ++s) {
      reaction += split.normal[s] * some[s];
      const auto j = static_cast<std::size_t>(touch.surfaces()[pressing[s]]);
      limit += friction_limit(model_.constraints.coefficient(node, j), split.normal[s]);
    }
    const double along = split.tangential.norm();
    if (some.size() == normals.size() && along <= limit + rounding * all.norm()) {
      reaction = all;
      return status;
    }
    // A slip that ended within the step may start again at once: sticking would take more than friction bears.
    if (along > 0.0) reaction += std::min(1.0, limit / along) * split.tangential;
  }
  if (withheld != nullptr) *withheld = all - reaction;
  return status;
}

springnet_status ReactionsAt::unsupported(std::uint32_t node, Vector3& acceleration) {
  const Contact& contact = model_.contact;
  if (contact.fixed()[node] == 0) return free_acceleration(node, acceleration);
  acceleration = contact.prescribed().moves(node) ? contact.prescribed().acceleration(placement_->motions, node)
                                                  : Vector3(Vector3::Zero());
  return SPRINGNET_OK;
}

Vector3 ReactionsAt::position(std::uint32_t node) const { return vector_at(position_, node); }
Vector3 ReactionsAt::velocity(std::uint32_t node) const { return vector_at(velocity_, node); }

springnet_status ReactionsAt::acceleration(std::uint32_t node, Vector3& acceleration) {
  const std::uint32_t* clusters = model_.rigid.cluster_of();
  if (clusters == nullptr || clusters[node] == 0xffffffffu) {
    const BodyMotion* pushed = nullptr;
    springnet_status status = bodies(pushed);
    if (status == SPRINGNET_OK) status = free_acceleration(node, acceleration);
    const BodyMotion::OfNode* const own = pushed == nullptr ? nullptr : pushed->find(node);
    if (own != nullptr) acceleration += own->pushed / model_.mass[node];
    return status;
  }
  if (const springnet_status status = know(clusters[node]); status != SPRINGNET_OK) return status;
  const std::size_t n = model_.layout.node_count();
  acceleration = {constrained_[node], constrained_[n + node], constrained_[2 * n + node]};
  return SPRINGNET_OK;
}

springnet_status ReactionsAt::constrained(std::uint32_t node, Vector3& acceleration) {
  const std::uint32_t* clusters = model_.rigid.cluster_of();
  if (clusters != nullptr && clusters[node] != 0xffffffffu) return this->acceleration(node, acceleration);
  const BodyMotion* pushed = nullptr;
  springnet_status status = bodies(pushed);
  if (status != SPRINGNET_OK) return status;
  if (const BodyMotion::OfNode* const own = pushed == nullptr ? nullptr : pushed->find(node); own != nullptr) {
    acceleration = own->acceleration;
    return status;
  }
  status = free_acceleration(node, acceleration);
  if (status == SPRINGNET_OK) acceleration = held(node, acceleration);
  return status;
}

springnet_status ReactionsAt::know(std::uint32_t cluster) {
  if (cluster_known_[cluster] != 0) return SPRINGNET_OK;
  const std::size_t n = model_.layout.node_count();
  const springnet_vectors free{free_.data(), free_.data() + n, free_.data() + 2 * n};
  const springnet_vectors constrained{constrained_.data(), constrained_.data() + n, constrained_.data() + 2 * n};
  const BodyMotion* pushed = nullptr;
  if (const springnet_status status = bodies(pushed); status != SPRINGNET_OK) return status;
  for (const std::uint32_t k : model_.rigid.nodes_of(cluster)) {
    Vector3 a;
    if (const springnet_status status = free_acceleration(k, a); status != SPRINGNET_OK) return status;
    if (const BodyMotion::OfNode* const own = pushed == nullptr ? nullptr : pushed->find(k); own != nullptr)
      a += own->pushed / model_.mass[k];
    else if (const auto added = added_.find(k); added != added_.end())
      a += added->second / model_.mass[k];
    put_vector(free, k, a);
    double* const values[3] = {&a[0], &a[1], &a[2]};
    if (k != without_) model_.constraints.accelerate(*placement_, k, 1, position_, velocity_, values);
    put_vector(constrained, k, a);
  }
  model_.rigid.accelerate(*placement_, cluster, position_, velocity_, constrained, tension_.data(), without_);
  cluster_known_[cluster] = 1;
  brace(cluster);
  return SPRINGNET_OK;
}

// The motion does not determine the force of a rod between two sticking nodes. Chooses the smallest forces for which
// braced nodes press on their obstacles and friction holds all sticking nodes.
void ReactionsAt::brace(std::uint32_t cluster) {
  const Contact& contact = model_.contact;
  const std::vector<std::uint32_t>& nodes = model_.rigid.nodes_of(cluster);
  const auto sticks = [&](std::uint32_t k) {
    return k != without_ && contact.fixed()[k] == 0 && contact.held()[k] != 0;
  };
  const auto braced = [&](std::uint32_t k) { return k != without_ && contact.braced(k); };
  if (contact.obstacles().empty() || std::none_of(nodes.begin(), nodes.end(), braced)) return;
  std::vector<std::size_t> rods;
  for (std::size_t r = 0; r < tension_.size(); ++r) {
    const RigidConnections::Rod& rod = model_.rigid.rods()[r];
    if (model_.rigid.cluster_of()[rod.first] == cluster && sticks(rod.first) && sticks(rod.second)) rods.push_back(r);
  }
  std::vector<std::uint32_t> pressed;
  for (const std::uint32_t k : nodes)
    if (sticks(k) && contact.committed(k).count() == 1) pressed.push_back(k);
  if (pressed.empty() || rods.empty()) return;
  Eigen::VectorXd base(static_cast<Eigen::Index>(3 * pressed.size()));
  Eigen::MatrixXd more = Eigen::MatrixXd::Zero(base.size(), static_cast<Eigen::Index>(rods.size()));
  std::vector<Cone> cones;
  double most = 0.0;
  for (std::size_t i = 0; i < pressed.size(); ++i) {
    const std::uint32_t k = pressed[i];
    const auto row = static_cast<Eigen::Index>(3 * i);
    const auto surface = static_cast<std::size_t>(contact.committed(k).surface);
    const Vector3 p = position(k), n = contact.normal(*placement_, surface, p), e = n.unitOrthogonal();
    Matrix3 parts;
    parts << n.transpose(), e.transpose(), n.cross(e).transpose();
    Vector3 reaction;
    if (of_cluster(cluster, k, reaction) != SPRINGNET_OK) return;
    base.segment<3>(row) = parts * reaction;
    most = std::max(most, std::abs(base[row]));
    for (Eigen::Index r = 0; r < more.cols(); ++r) {
      const RigidConnections::Rod& rod = model_.rigid.rods()[rods[static_cast<std::size_t>(r)]];
      if (rod.first == k || rod.second == k)
        more.block<3, 1>(row, r) = -parts * (position(rod.first == k ? rod.second : rod.first) - p).normalized();
    }
    cones.push_back({model_.constraints.coefficient(k, surface), 0.0});
  }
  for (Cone& cone : cones) cone.min_normal_force = 1e-9 * most;  // otherwise rounding makes it a pull
  if (const auto least = min_norm_in_cones(base, more, cones)) {
    bracing_.resize(tension_.size(), 0.0);
    for (Eigen::Index r = 0; r < more.cols(); ++r) {
      tension_[rods[static_cast<std::size_t>(r)]] += (*least)[r];
      bracing_[rods[static_cast<std::size_t>(r)]] = (*least)[r];
    }
  }
}

springnet_status ReactionsAt::of_cluster(std::uint32_t cluster, std::uint32_t node, Vector3& reaction) {
  if (const springnet_status status = know(cluster); status != SPRINGNET_OK) return status;
  const std::size_t n = model_.layout.node_count();
  const auto of = [&](const std::vector<double>& values) {
    return Vector3(values[node], values[n + node], values[2 * n + node]);
  };
  reaction = model_.constraints.reaction(node, of(free_), of(constrained_), position_, tension_.data());
  return SPRINGNET_OK;
}

namespace {

// As means over the last step, N.
std::map<std::uint32_t, Vector3> body_forces_on_clusters(const Model& model, const std::vector<Vector3>& of_pairs) {
  std::map<std::uint32_t, Vector3> result;
  for_each_body_force(model, of_pairs, [&](std::uint32_t node, const Vector3& force) {
    if (model.rigid.is_joined(node)) result.try_emplace(node, Vector3::Zero()).first->second += force;
  });
  return result;
}

}  // namespace

void for_each_body_force(const Model& model, const std::vector<Vector3>& of_pairs,
                         const std::function<void(std::uint32_t, const Vector3&)>& use) {
  const BodyContacts& bodies = model.constraints.bodies();
  if (bodies.touching().empty()) return;
  const proximity::Positions x = positions_of(read_only(model.state.view.position), model.node_count());
  for (std::size_t t = 0; t < of_pairs.size(); ++t) {
    const PairTouch& touch = bodies.touching()[t];
    const proximity::Separation at = bodies.separation_of(touch, x);
    const std::array<NodeIndex, 4> nodes = bodies.primitives().nodes_of(touch.kind, touch.pair);
    const int count = proximity::first_nodes(touch.kind) + proximity::second_nodes(touch.kind);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) use(nodes[i], at.weights[i] * of_pairs[t]);
  }
}

Reactions reactions_now(Model& model, const std::vector<Vector3>& of_pairs) {
  const springnet_state& state = model.state.view;
  ReactionsAt at(model, model.time, read_only(state.position), read_only(state.velocity));
  Reactions result;
  result.node.assign(model.node_count(), Vector3::Zero());
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t k = 0; k < model.node_count(); ++k)
    if (model.contact.fixed()[k] != 0 || model.contact.touching()[k] != 0) nodes.push_back(k);
  at.add_forces(body_forces_on_clusters(model, of_pairs));
  springnet_status status = at.prepare(nodes);
  for (std::size_t i = 0; i < nodes.size() && status == SPRINGNET_OK; ++i)
    status = at.reported(nodes[i], result.node[nodes[i]]);
  for (std::uint32_t c = 0; c < model.rigid.cluster_count() && status == SPRINGNET_OK; ++c) status = at.know(c);
  if (status != SPRINGNET_OK) throw Error(ErrorKind::simulation, model.journal.message.text);
  result.rigid = at.tensions();
  result.rigid.resize(model.rigid.rods().size(), 0.0);
  return result;
}

}  // namespace springnet
