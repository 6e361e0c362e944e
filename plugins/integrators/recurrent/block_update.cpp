#include "block_update.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace springnet::recurrent {
namespace {

using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vector = Eigen::Vector3d;

// Eigenvalues of B below this count as zero or negative. The mass contributes 1.
constexpr double min_eigenvalue = 0.05;
// A step is too long if the slope at its end has the opposite sign and at least this share of the start's magnitude.
constexpr double overshoot = 0.5;
constexpr int max_halvings = 4;

bool is_definite(const Block& symmetric) {
  const Block s = symmetric - min_eigenvalue * Block::Identity();
  return s(0, 0) > 0.0 && s(0, 0) * s(1, 1) - s(0, 1) * s(1, 0) > 0.0 && s.determinant() > 0.0;
}

// The symmetric part of B with its eigenvalues made positive: at negative curvature its magnitude sets the length of a
// step.
Block made_definite(const Block& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> modes(symmetric);
  const Vector values = modes.eigenvalues().cwiseAbs().cwiseMax(min_eigenvalue);
  return modes.eigenvectors() * values.asDiagonal() * modes.eigenvectors().transpose();
}

}  // namespace

void BlockMemory::attach(const springnet_network& network) {
  acceleration.resize(network.node_count);
  const bool constrained = network.surface_count > 0 || network.rigid_count > 0 || network.body_contact_count > 0;
  inertia.assign(constrained ? 9 * std::size_t{network.node_count} : 0, 0.0);
}

BlockUpdate::BlockUpdate(const sdk::Host& host, const Step& step, BlockMemory& memory) noexcept
    : host_(host),
      step_(step),
      memory_(memory),
      position_(step.outputs->position),
      velocity_(step.outputs->velocity),
      weight_(step.weight()),
      constrained_(step.constrained()),
      writes_inertia_(step.may_be_constrained()) {}

void BlockUpdate::request(springnet_sweep& call) const noexcept {
  call.want_blocks = 1;
  if (writes_inertia_) call.inertia = memory_.inertia.data();
}

bool BlockUpdate::operator()(const springnet_node_batch& batch) const {
  bool finite = true;
  for (std::uint32_t i = 0; i < batch.count; ++i) finite = update(batch, i) && finite;
  return finite;
}

NodeStep::NodeStep(const Step& step, const springnet_state& from, const springnet_node_batch& batch, std::uint32_t i,
                   bool constrained)
    : velocity(at(from.velocity, batch.first + i)) {
  const std::uint32_t k = batch.first + i;
  const double w = step.weight();
  const Eigen::Map<const Block> by_velocity(batch.acceleration_by_velocity + 9 * std::size_t{i});
  const Eigen::Map<const Block> by_position(batch.acceleration_by_position + 9 * std::size_t{i});
  // At the start of the propagation a node may not be at p* + w U; the step moves it there, unless constraints place it
  // elsewhere.
  const Vector gap =
      constrained ? Vector(Vector::Zero()) : at(step.free_position, k) + w * velocity - at(from.position, k);
  residual = velocity - at(step.free_velocity, k) - w * (at(batch.acceleration, i) + by_position * gap);
  matrix = Block::Identity() - w * by_velocity - (w * w) * by_position;
  positive = 0.5 * (matrix + matrix.transpose());
  finite = positive.allFinite() && residual.allFinite();
  definite = finite && is_definite(positive);
  if (finite && !definite) positive = made_definite(positive);
}

bool BlockUpdate::update(const springnet_node_batch& batch, std::uint32_t i) const {
  const std::uint32_t k = batch.first + i;
  const bool constrained = is_partly_constrained(k);
  const NodeStep node(step_, *step_.outputs, batch, i, constrained);
  if (!node.finite) {
    put(k, node.velocity - node.residual);
    return false;
  }
  // The effective mass of the step, for the response to impulses.
  if (writes_inertia_)
    Eigen::Map<Block>(memory_.inertia.data() + 9 * std::size_t{k}) = step_.network.mass[k] * node.positive;
  const Block& matrix = node.definite && !constrained_ ? node.matrix : node.positive;
  const Vector direction = -(matrix.inverse() * node.residual);
  put(k, node.velocity + direction);
  if (!constrained && !step_.is_pushed(k) && step_.network.fixed[k] == 0 && !step_.is_linear)
    search(k, node.velocity, node.residual, direction);
  return at(position_, k).allFinite();
}

bool BlockUpdate::is_partly_constrained(std::uint32_t node) const noexcept {
  if (!constrained_) return false;
  const springnet_network& network = step_.network;
  return network.cluster[node] != no_node || network.touching[node] != 0 || network.status[node] != SPRINGNET_FREE;
}

void BlockUpdate::put(std::uint32_t node, const Vector& velocity) const noexcept {
  const Vector position = at(step_.free_position, node) + weight_ * velocity;
  velocity_.x[node] = velocity[0];
  velocity_.y[node] = velocity[1];
  velocity_.z[node] = velocity[2];
  position_.x[node] = position[0];
  position_.y[node] = position[1];
  position_.z[node] = position[2];
}

BlockUpdate::Vector BlockUpdate::acceleration_at(std::uint32_t node) const {
  auto evaluation = sdk::sized<springnet_evaluation>();
  evaluation.time = step_.until;
  evaluation.position = sdk::view(position_);
  evaluation.velocity = sdk::view(velocity_);
  evaluation.internal = step_.internal_step();
  evaluation.acceleration = memory_.acceleration.view();
  host_.evaluate_nodes(evaluation, {&node, 1});
  return at(sdk::view(evaluation.acceleration), node);
}

// The outputs are at start + direction.
void BlockUpdate::search(std::uint32_t node, const Vector& start, const Vector& residual,
                         const Vector& direction) const {
  const double slope = residual.dot(direction);
  if (!(slope < 0.0)) return;
  double share = 1.0;
  for (int halving = 0; halving < max_halvings; ++halving) {
    const Vector u = start + share * direction;
    double end = std::numeric_limits<double>::infinity();
    try {
      end = (u - at(step_.free_velocity, node) - weight_ * acceleration_at(node)).dot(direction);
    } catch (const sdk::Failure& failure) {
      if (!failure.recoverable()) throw;
    }
    if (end <= -overshoot * slope) return;
    // Zero of the linear interpolation of the slopes, away from both ends.
    const double zero = std::isfinite(end) ? slope / (slope - end) : 0.0;
    share *= zero < 0.1 ? 0.1 : zero > 0.5 ? 0.5 : zero;
    put(node, start + share * direction);
  }
}

}  // namespace springnet::recurrent
