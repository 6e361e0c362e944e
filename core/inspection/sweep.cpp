#include "inspection/sweep.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace springnet {

LinearSweep::LinearSweep(const Network& network, const LinearNetwork& linear, const Joints& joints, UpdateRule rule)
    : linear_(linear),
      joints_(joints),
      rule_(rule),
      cluster_(rigid_clusters(network)),
      free_(network.nodes().size()),
      inverse_root_(network.nodes().size()),
      weight_(network.nodes().size(), Block::Identity()),
      along_(network.springs().size()),
      across_(network.springs().size()),
      diagonal_(network.nodes().size()) {
  if (rule == UpdateRule::wavefront || rule == UpdateRule::block) order_ = wave_order(joints, linear.nodes);
  if (rule == UpdateRule::coloured) order_ = colour_order(joints, cluster_);
  const std::vector<LinearElement>& elements = linear.elements.all();
  if (std::any_of(elements.begin(), elements.end(), [](const LinearElement& e) { return e.is_enclosure(); }))
    rates_.resize(elements.size());
  for (std::size_t k = 0; k < free_.size(); ++k) {
    const LinearNode& node = linear.nodes[k];
    free_[k] = node.free ? 1 : 0;
    if (!node.free) continue;
    const double mass = network.nodes()[k].mass;
    inverse_root_[k] = 1.0 / std::sqrt(mass);
    weight_[k] = mass * node.by_force;
    const bool like_a_mass_point = (weight_[k] - Block::Identity()).norm() <= 1e-12;  // of 1, to rounding
    symmetric_ = symmetric_ && like_a_mass_point && node.by_position.isApprox(node.by_position.transpose()) &&
                 node.by_velocity.isApprox(node.by_velocity.transpose());
  }
  if (network.rigids().empty()) return;

  std::vector<std::vector<NodeIndex>> nodes;
  std::vector<std::vector<RigidIndex>> rigids;
  for (NodeIndex node = 0; node < cluster_.size(); ++node) {
    if (cluster_[node] == no_cluster) continue;
    if (cluster_[node] >= nodes.size()) nodes.resize(cluster_[node] + 1);
    if (free_[node] != 0) nodes[cluster_[node]].push_back(node);
  }
  rigids.resize(nodes.size());
  for (RigidIndex r = 0; r < network.rigids().size(); ++r) {
    rigids[cluster_[network.rigids()[r].first]].push_back(r);
  }
  for (std::size_t c = 0; c < nodes.size(); ++c) {
    projections_.emplace_back(network, nodes[c], rigids[c], inverse_root_);
  }
  done_.resize(nodes.size());
}

void LinearSweep::set_time_constant(double t) {
  time_constant_ = t;
  for (std::size_t s = 0; s < along_.size(); ++s) {
    const LinearSpring& spring = linear_.springs[s];
    const double across = spring.across_stiffness();
    along_[s] = t * t * (spring.stiffness - across) + t * spring.axial_damping;
    across_[s] = t * t * across + t * spring.general_damping;
  }
  for (NodeIndex k = 0; k < free_.size(); ++k) {
    diagonal_[k].setZero();
    if (free_[k] == 0) continue;
    Block sum = linear_.elements.diagonal(k, t);
    for (const Joint& joint : joints_.of(k)) {
      if (joint.spring == no_spring) continue;
      const Vector3& n = linear_.springs[joint.spring].direction;
      sum += along_[joint.spring] * n * n.transpose() + across_[joint.spring] * Block::Identity();
    }
    const LinearNode& node = linear_.nodes[k];
    const Block own =
        inverse_root_[k] * inverse_root_[k] * weight_[k] * sum - t * t * node.by_position - t * node.by_velocity;
    if (blocks()) {
      diagonal_[k] = (Block::Identity() + own).inverse();
    } else {
      diagonal_[k] = -own;
    }
  }
  if (blocks()) {
    for (RigidProjection& projection : projections_) projection.set_inverse_inertia(&diagonal_);
  }
}

void LinearSweep::restrict(Eigen::VectorXd& u) const {
  for (NodeIndex k = 0; k < free_.size(); ++k) {
    if (free_[k] == 0) u.segment<3>(at(k)).setZero();
  }
}

Vector3 LinearSweep::updated(NodeIndex node, const Eigen::VectorXd& u) const {
  Vector3 others = -pulled_by_elements(node, u);
  for (const Joint& joint : joints_.of(node)) {
    if (joint.spring == no_spring) continue;
    const Vector3& n = linear_.springs[joint.spring].direction;
    const Vector3 v = inverse_root_[joint.other] * u.segment<3>(at(joint.other));
    others += (along_[joint.spring] * n.dot(v)) * n + across_[joint.spring] * v;
  }
  others = inverse_root_[node] * (weight_[node] * others);
  if (blocks()) return diagonal_[node] * others;
  return diagonal_[node] * Vector3(u.segment<3>(at(node))) + others;
}

Vector3 LinearSweep::pulled_by_elements(NodeIndex node, const Eigen::VectorXd& u) const {
  const double t = time_constant_;
  Vector3 sum = Vector3::Zero();
  for (const LinearShare& share : linear_.elements.of(node)) {
    const LinearElement& e = linear_.elements.all()[share.element];
    if (e.is_enclosure()) {
      const Vector3& g = e.gradient[share.place];
      sum += e.of_volume(t) * (rates_[share.element] - g.dot(velocity(u, node))) * g;
      const auto spokes = e.enclosure[0].spokes(share.place);
      for (std::size_t i = 0; i < spokes.size(); ++i)
        sum += t * t * e.across[share.place][i].cross(velocity(u, spokes[i].other));
      continue;
    }
    for (std::size_t j = 0; j < e.nodes.size(); ++j)
      if (j != share.place) sum += e.between(share.place, j, t) * velocity(u, e.nodes[j]);
  }
  return sum;
}

void LinearSweep::sum_rates(const Eigen::VectorXd& u) {
  for (std::size_t e = 0; e < rates_.size(); ++e) {
    const LinearElement& element = linear_.elements.all()[e];
    rates_[e] = 0.0;
    for (std::size_t i = 0; element.is_enclosure() && i < element.nodes.size(); ++i)
      rates_[e] += element.gradient[i].dot(velocity(u, element.nodes[i]));
  }
}

void LinearSweep::change_rates(NodeIndex node, const Vector3& change) {
  if (rates_.empty()) return;
  for (const LinearShare& share : linear_.elements.of(node)) {
    const LinearElement& e = linear_.elements.all()[share.element];
    if (e.is_enclosure()) rates_[share.element] += inverse_root_[node] * e.gradient[share.place].dot(change);
  }
}

void LinearSweep::put(NodeIndex node, const Vector3& value, Eigen::VectorXd& u) {
  change_rates(node, value - Vector3(u.segment<3>(at(node))));
  u.segment<3>(at(node)) = value;
}

void LinearSweep::update_cluster(RigidProjection& cluster, Eigen::VectorXd& u) {
  members_.clear();
  for (const NodeIndex node : cluster.nodes()) members_.push_back(updated(node, u));
  for (std::size_t i = 0; i < members_.size(); ++i) u.segment<3>(at(cluster.nodes()[i])) = members_[i];
  cluster.apply(u);
  sum_rates(u);
}

void LinearSweep::apply(Eigen::VectorXd& u) {
  sum_rates(u);
  if (order_.empty()) {
    old_ = u;
    for (NodeIndex k = 0; k < free_.size(); ++k) {
      if (free_[k] != 0) u.segment<3>(at(k)) = updated(k, old_);
    }
    for (RigidProjection& projection : projections_) projection.apply(u);
    return;
  }
  // Nodes of a cluster have their turn together, with the first of them.
  std::fill(done_.begin(), done_.end(), std::uint8_t{0});
  for (const NodeIndex node : order_) {
    const std::uint32_t cluster = cluster_[node];
    if (cluster == no_cluster) {
      if (free_[node] != 0) put(node, updated(node, u), u);
    } else if (done_[cluster] == 0) {
      done_[cluster] = 1;
      update_cluster(projections_[cluster], u);
    }
  }
}

}  // namespace springnet
