#include "simulation/reactions_at.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include <springnet/error.hpp>

#include "constraints/friction.hpp"
#include "constraints/island.hpp"
#include "constraints/vectors.hpp"

namespace springnet {

Engine::ReactionsAt::ReactionsAt(Engine& engine, double time, const springnet_const_vectors& position,
                                 const springnet_const_vectors& velocity)
    : engine_(engine),
      time_(time),
      position_(position),
      velocity_(velocity),
      external_(engine.external_at(time)),
      placement_(engine.placement(time)),
      cluster_known_(engine.rigid_.cluster_count(), 0) {
  if (engine.layout_.elements().live_surfaces() > 0)
    volumes_.compute(engine.layout_.elements(), node_arrays(position, velocity));
  if (!cluster_known_.empty()) {
    const std::size_t n = engine.layout_.node_count();
    for (auto* values : {&free_, &bound_}) values->resize(3 * n);
    tension_.resize(engine.rigid_.rods().size());
  }
}

springnet_status Engine::ReactionsAt::free_acceleration(std::uint32_t node, Vector3& acceleration) {
  Vector3 force;
  return engine_.evaluator_.evaluate_node(node, time_, node_arrays(position_, velocity_), external_, &volumes_, force,
                                          acceleration, nullptr, nullptr, engine_.message_);
}

Vector3 Engine::ReactionsAt::held(std::uint32_t node, Vector3 acceleration) const {
  double* const values[3] = {&acceleration[0], &acceleration[1], &acceleration[2]};
  engine_.constraints_.accelerate(*placement_, node, 1, position_, velocity_, values);
  return acceleration;
}

springnet_status Engine::ReactionsAt::of(std::uint32_t node, Vector3& reaction) {
  const std::uint32_t* clusters = engine_.rigid_.cluster_of();
  if (clusters != nullptr && clusters[node] != 0xffffffffu) return of_cluster(clusters[node], node, reaction);
  Vector3 free;
  if (const springnet_status status = free_acceleration(node, free); status != SPRINGNET_OK) return status;
  reaction = engine_.constraints_.reaction(node, free, held(node, free), position_, nullptr);
  return SPRINGNET_OK;
}

springnet_status Engine::ReactionsAt::unbraced(std::uint32_t node, Vector3& reaction) {
  const springnet_status status = of(node, reaction);
  const std::uint32_t* clusters = engine_.rigid_.cluster_of();
  if (status == SPRINGNET_OK && !bracing_.empty() && clusters[node] != ConstraintRow::no_node)
    reaction += engine_.rigid_.connection_force(node, position_, bracing_.data());
  return status;
}

springnet_status Engine::ReactionsAt::told(std::uint32_t node, Vector3& reaction, Vector3* withheld) {
  const springnet_status status = of(node, reaction);
  const Touch& touch = engine_.contact_.committed(node);
  if (status != SPRINGNET_OK || touch.surface < 0) return status;
  const std::vector<Vector3> normals = engine_.contact_.normals(*placement_, node, vector_at(position_, node));
  const std::vector<std::size_t> pressing = pressing_of(normals, reaction);
  if (pressing.size() == normals.size()) return status;
  const Vector3 all = reaction;
  reaction.setZero();
  std::vector<Vector3> some;
  for (const std::size_t i : pressing) some.push_back(normals[i]);
  if (!some.empty()) {
    const SplitReaction split = split_reaction(some, all);
    double bears = 0.0;
    for (std::size_t s = 0; s < some.size(); ++s) {
      reaction += split.normal[s] * some[s];
      const auto j = static_cast<std::size_t>(touch.surfaces()[pressing[s]]);
      bears += bearing(engine_.coefficient(node, j), split.normal[s]);
    }
    if (const double along = split.along.norm(); along > 0.0) reaction += std::min(1.0, bears / along) * split.along;
  }
  if (withheld != nullptr) *withheld = all - reaction;
  return status;
}

springnet_status Engine::ReactionsAt::unsupported(std::uint32_t node, Vector3& acceleration) {
  const Contact& contact = engine_.contact_;
  if (contact.fixed()[node] == 0) return free_acceleration(node, acceleration);
  acceleration = contact.prescribed().moves(node) ? contact.prescribed().acceleration(placement_->motions, node)
                                                  : Vector3(Vector3::Zero());
  return SPRINGNET_OK;
}

Vector3 Engine::ReactionsAt::position(std::uint32_t node) const { return vector_at(position_, node); }
Vector3 Engine::ReactionsAt::velocity(std::uint32_t node) const { return vector_at(velocity_, node); }

springnet_status Engine::ReactionsAt::acceleration(std::uint32_t node, Vector3& acceleration) {
  const std::uint32_t* clusters = engine_.rigid_.cluster_of();
  if (clusters == nullptr || clusters[node] == 0xffffffffu) return free_acceleration(node, acceleration);
  if (const springnet_status status = know(clusters[node]); status != SPRINGNET_OK) return status;
  const std::size_t n = engine_.layout_.node_count();
  acceleration = {bound_[node], bound_[n + node], bound_[2 * n + node]};
  return SPRINGNET_OK;
}

springnet_status Engine::ReactionsAt::bound(std::uint32_t node, Vector3& acceleration) {
  const std::uint32_t* clusters = engine_.rigid_.cluster_of();
  if (clusters != nullptr && clusters[node] != 0xffffffffu) return this->acceleration(node, acceleration);
  const springnet_status status = free_acceleration(node, acceleration);
  if (status == SPRINGNET_OK) acceleration = held(node, acceleration);
  return status;
}

springnet_status Engine::ReactionsAt::know(std::uint32_t cluster) {
  if (cluster_known_[cluster] != 0) return SPRINGNET_OK;
  const std::size_t n = engine_.layout_.node_count();
  const springnet_vectors free{free_.data(), free_.data() + n, free_.data() + 2 * n};
  const springnet_vectors bound{bound_.data(), bound_.data() + n, bound_.data() + 2 * n};
  for (const std::uint32_t k : engine_.rigid_.nodes_of(cluster)) {
    Vector3 a;
    if (const springnet_status status = free_acceleration(k, a); status != SPRINGNET_OK) return status;
    put_vector(free, k, a);
    double* const values[3] = {&a[0], &a[1], &a[2]};
    if (k != without_) engine_.constraints_.accelerate(*placement_, k, 1, position_, velocity_, values);
    put_vector(bound, k, a);
  }
  engine_.rigid_.accelerate(*placement_, cluster, position_, velocity_, bound, tension_.data(), without_);
  cluster_known_[cluster] = 1;
  brace(cluster);
  return SPRINGNET_OK;
}

// Connections between nodes that stick may bear any force. The least is taken by which braced nodes press, and friction
// holds all that stick.
void Engine::ReactionsAt::brace(std::uint32_t cluster) {
  const Contact& contact = engine_.contact_;
  const std::vector<std::uint32_t>& nodes = engine_.rigid_.nodes_of(cluster);
  const auto sticks = [&](std::uint32_t k) {
    return k != without_ && contact.fixed()[k] == 0 && contact.held()[k] != 0;
  };
  const auto braced = [&](std::uint32_t k) { return k != without_ && contact.braced(k); };
  if (contact.surfaces().empty() || std::none_of(nodes.begin(), nodes.end(), braced)) return;
  std::vector<std::size_t> rods;
  for (std::size_t r = 0; r < tension_.size(); ++r) {
    const RigidConnections::Rod& rod = engine_.rigid_.rods()[r];
    if (engine_.rigid_.cluster_of()[rod.first] == cluster && sticks(rod.first) && sticks(rod.second)) rods.push_back(r);
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
      const RigidConnections::Rod& rod = engine_.rigid_.rods()[rods[static_cast<std::size_t>(r)]];
      if (rod.first == k || rod.second == k)
        more.block<3, 1>(row, r) = -parts * (position(rod.first == k ? rod.second : rod.first) - p).normalized();
    }
    cones.push_back({engine_.coefficient(k, surface), 0.0});
  }
  for (Cone& cone : cones) cone.least = 1e-9 * most;  // rounding would make it a pull
  if (const auto least = min_norm_in_cones(base, more, cones)) {
    bracing_.resize(tension_.size(), 0.0);
    for (Eigen::Index r = 0; r < more.cols(); ++r) {
      tension_[rods[static_cast<std::size_t>(r)]] += (*least)[r];
      bracing_[rods[static_cast<std::size_t>(r)]] = (*least)[r];
    }
  }
}

springnet_status Engine::ReactionsAt::of_cluster(std::uint32_t cluster, std::uint32_t node, Vector3& reaction) {
  if (const springnet_status status = know(cluster); status != SPRINGNET_OK) return status;
  const std::size_t n = engine_.layout_.node_count();
  const auto of = [&](const std::vector<double>& values) {
    return Vector3(values[node], values[n + node], values[2 * n + node]);
  };
  reaction = engine_.constraints_.reaction(node, of(free_), of(bound_), position_, tension_.data());
  return SPRINGNET_OK;
}

const Engine::Reactions& Engine::reactions() {
  if (reactions_known_) return reactions_;
  const std::uint32_t n = layout_.node_count();
  reactions_.node.assign(n, Vector3::Zero());
  reactions_.rigid.assign(rigid_.rods().size(), 0.0);
  ReactionsAt at(*this, time_, read_only(state_.view.position), read_only(state_.view.velocity));
  springnet_status status = SPRINGNET_OK;
  for (std::uint32_t k = 0; k < n && status == SPRINGNET_OK; ++k)
    if (contact_.fixed()[k] != 0 || contact_.touching()[k] != 0) status = at.told(k, reactions_.node[k]);
  for (std::uint32_t c = 0; c < rigid_.cluster_count() && status == SPRINGNET_OK; ++c) status = at.know(c);
  if (status != SPRINGNET_OK) throw Error(ErrorKind::simulation, message_.text);
  reactions_.rigid = at.tensions();
  reactions_known_ = true;
  return reactions_;
}

Vector3 Engine::reaction_of(std::uint32_t node, std::size_t surface) {
  return constraints_.share_of(*placement(time_), node, surface, vector_at(state_.view.position, node),
                               reactions().node[node]);
}

}  // namespace springnet
