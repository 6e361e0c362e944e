#include "simulation/linear_sweep.hpp"

#include <algorithm>
#include <utility>

#include <Eigen/LU>

#include "constraints/vectors.hpp"

namespace springnet {
namespace {

constexpr std::uint32_t no_island = 0xffffffffu;
using Block = layers::Block;

}  // namespace

LinearSweep::LinearSweep(layers::Linearisation& linearisation, const ConstraintSet& constraints,
                         const std::vector<double>& mass)
    : linearisation_(linearisation), constraints_(constraints), mass_(mass), island_of_(mass.size(), no_island) {
  const RigidConnections& rigid = constraints.rigid();
  for (std::size_t c = 0; c < rigid.cluster_count(); ++c) {
    islands_.emplace_back().nodes = rigid.nodes_of(c);
    for (const std::uint32_t node : rigid.nodes_of(c)) island_of_[node] = static_cast<std::uint32_t>(c);
  }
  for (const ConstraintRow& row : constraints.rows()) {
    if (row.is_pair) continue;  // how fast sweeps settle depends little on the pairs
    std::uint32_t& island = island_of_[row.first];
    if (island == no_island) {
      island = static_cast<std::uint32_t>(islands_.size());
      islands_.emplace_back().nodes = {row.first};
    }
    islands_[island].rows.push_back(row);
  }
}

void LinearSweep::set_weight(double weight) {
  if (weight == weight_) return;
  weight_ = weight;
  linearisation_.set_weights(weight, weight * weight);
  own_.resize(9 * mass_.size());
  linearisation_.diagonal_blocks(weight, weight * weight, own_.data());
  for (std::size_t i = 0; i < own_.size(); ++i) own_[i] = ((i % 9 % 4 == 0 ? 1.0 : 0.0) - own_[i]) / weight;
  by_velocity_.clear();
}

void LinearSweep::find_blocks() {
  if (!by_velocity_.empty()) return;
  const double weight = weight_;
  by_velocity_.resize(9 * mass_.size());
  by_position_.resize(9 * mass_.size());
  // Blocks of I - weight da/dv and I - weight^2 da/dp.
  linearisation_.diagonal_blocks(weight, 0.0, by_velocity_.data());
  linearisation_.diagonal_blocks(0.0, weight * weight, by_position_.data());
  for (std::size_t i = 0; i < by_velocity_.size(); ++i) {
    const double one = i % 9 % 4 == 0 ? 1.0 : 0.0;
    by_velocity_[i] = (one - by_velocity_[i]) / weight;
    by_position_[i] = (one - by_position_[i]) / (weight * weight);
  }
}

Vector3 LinearSweep::velocity(std::uint32_t node) const { return {u_[0][node], u_[1][node], u_[2][node]}; }

Vector3 LinearSweep::acceleration(std::uint32_t node) const {
  const Eigen::Map<const Block> own(own_.data() + 9 * std::size_t{node});
  return linearisation_.off_diagonal_product(node, u_) / weight_ + own * velocity(node);
}

void LinearSweep::call_update(std::uint32_t node, const Vector3& acceleration) {
  const Vector3 force = mass_[node] * acceleration;
  springnet_node_batch batch{};
  batch.struct_size = sizeof batch;
  batch.first = node;
  batch.count = 1;
  batch.force = {&force[0], &force[1], &force[2]};
  batch.acceleration = {&acceleration[0], &acceleration[1], &acceleration[2]};
  if (sweep_->want_blocks != 0) {
    batch.acceleration_by_velocity = by_velocity_.data() + 9 * std::size_t{node};
    batch.acceleration_by_position = by_position_.data() + 9 * std::size_t{node};
  }
  static_cast<void>(sweep_->update(sweep_->user, &batch));
}

void LinearSweep::finish(std::uint32_t node, const Vector3& before) {
  if (constraints_.contact().constrained()[node] != 0) put_vector(sweep_->next_velocity, node, Vector3::Zero());
  const Vector3 now = velocity(node);
  put_vector(sweep_->next_position, node, weight_ * now);
  linearisation_.add_change(node, now - before);
}

void LinearSweep::factorise(Island& island) {
  std::vector<double> inertia;
  if (sweep_->inertia != nullptr)
    for (const std::uint32_t node : island.nodes)
      inertia.insert(inertia.end(), sweep_->inertia + 9 * std::size_t{node},
                     sweep_->inertia + 9 * std::size_t{node} + 9);
  if (island.is_factorised && inertia == island.inertia) return;
  island.system->set(island.rows, [&](std::uint32_t node) -> Matrix3 {
    if (inertia.empty() || constraints_.contact().constrained()[node] != 0) return constraints_.rigid().mobility(node);
    return Eigen::Map<const Block>(sweep_->inertia + 9 * std::size_t{node}).inverse();
  });
  island.inertia = std::move(inertia);
  island.is_factorised = true;
}

// All nodes are evaluated before any is updated: updated outputs do not satisfy the constraints before the end.
void LinearSweep::update_island(Island& island) {
  members_.clear();
  before_.clear();
  for (const std::uint32_t node : island.nodes) {
    members_.push_back(acceleration(node));
    before_.push_back(velocity(node));
  }
  for (std::size_t i = 0; i < island.nodes.size(); ++i) call_update(island.nodes[i], members_[i]);
  for (const std::uint32_t node : island.nodes)
    if (constraints_.contact().constrained()[node] != 0) put_vector(sweep_->next_velocity, node, Vector3::Zero());
  if (!island.rows.empty()) {
    factorise(island);
    const Eigen::VectorXd rates = island.system->rates([&](std::uint32_t node) { return velocity(node); });
    island.system->for_each_change(island.system->solve(-rates), [&](std::uint32_t node, const Vector3& change) {
      put_vector(sweep_->next_velocity, node, velocity(node) + change);
    });
  }
  for (std::size_t i = 0; i < island.nodes.size(); ++i) finish(island.nodes[i], before_[i]);
}

void LinearSweep::run(const springnet_sweep& sweep) {
  sweep_ = &sweep;
  u_[0] = sweep.velocity.x;
  u_[1] = sweep.velocity.y;
  u_[2] = sweep.velocity.z;
  set_weight(sweep.time_constant * (sweep.theta > 0.0 ? sweep.theta : 1.0));
  if (sweep.want_blocks != 0) find_blocks();
  linearisation_.track(u_);
  for (Island& island : islands_) island.is_done = false;
  for (std::uint32_t i = 0; i < sweep.order_count; ++i) {
    const std::uint32_t node = sweep.order[i];
    if (island_of_[node] == no_island) {
      const Vector3 before = velocity(node);
      call_update(node, acceleration(node));
      finish(node, before);
      continue;
    }
    Island& island = islands_[island_of_[node]];
    if (island.is_done) continue;
    island.is_done = true;
    update_island(island);
  }
  sweep_ = nullptr;
}

}  // namespace springnet
