#include "simulation/verlet_clusters.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "constraints/vectors.hpp"
#include "plugin_host/message.hpp"

namespace springnet {

VerletClusters::VerletClusters(Model& model, double until, double length) : model_(model), until_(until), h_(length) {}

void VerletClusters::begin(const springnet_sweep& step) {
  clusters_.clear();
  is_node_struck_.assign(model_.node_count(), 0);
  for (std::size_t c = 0; c < model_.rigid.cluster_count(); ++c) {
    Cluster cluster{Rods(model_.rigid, c, step.start_position), {}, {}, {}};
    for (const std::uint32_t k : model_.rigid.nodes_of(c)) {
      cluster.velocity.push_back(vector_at(step.next_velocity, k));
      cluster.position.push_back(vector_at(step.next_position, k));
      cluster.place.push_back(vector_at(step.start_position, k));
    }
    // Where they cannot be kept, the end of the step says so.
    if (std::vector<Vector3> u = cluster.velocity, p = cluster.position; cluster.rods.keep_lengths(h_, u, p)) {
      cluster.velocity = std::move(u);
      cluster.position = std::move(p);
    }
    clusters_.push_back(std::move(cluster));
  }
}

proximity::Positions VerletClusters::end(const springnet_sweep& step) {
  const std::size_t n = model_.node_count();
  end_[0].assign(step.next_position.x, step.next_position.x + n);
  end_[1].assign(step.next_position.y, step.next_position.y + n);
  end_[2].assign(step.next_position.z, step.next_position.z + n);
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    if (clusters_[c].is_struck) continue;
    const std::vector<std::uint32_t>& nodes = model_.rigid.nodes_of(c);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (std::size_t d = 0; d < 3; ++d) end_[d][nodes[i]] = clusters_[c].position[i][static_cast<Eigen::Index>(d)];
  }
  return {{end_[0].data(), end_[1].data(), end_[2].data()}, n};
}

bool VerletClusters::strike(const springnet_sweep& step, std::uint32_t node, double share) {
  if (!model_.rigid.is_joined(node) || is_node_struck_[node] != 0) return false;
  const std::uint32_t number = model_.rigid.cluster_of()[node];
  Cluster& cluster = clusters_[number];
  if (!cluster.is_struck) {
    cluster.is_struck = true;
    const std::vector<std::uint32_t>& nodes = model_.rigid.nodes_of(number);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      put_vector(step.next_velocity, nodes[i], cluster.velocity[i]);
      put_vector(step.next_position, nodes[i], cluster.position[i]);
      cluster.place[i] += share * (cluster.position[i] - cluster.place[i]);
    }
  }
  struck_.push_back(node);
  is_node_struck_[node] = 1;
  return true;
}

bool VerletClusters::loosen(std::uint32_t node) {
  return model_.rigid.is_joined(node) && loose_.insert(model_.rigid.cluster_of()[node]).second;
}

void VerletClusters::renew() {
  if (struck_.empty()) return;
  const std::size_t n = model_.node_count();
  for (std::vector<double>& each : place_) each.resize(n);
  const springnet_vectors place{place_[0].data(), place_[1].data(), place_[2].data()};
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    const std::vector<std::uint32_t>& nodes = model_.rigid.nodes_of(c);
    for (std::size_t i = 0; clusters_[c].is_struck && i < nodes.size(); ++i)
      put_vector(place, nodes[i], clusters_[c].place[i]);
  }
  responses_.set(
      model_.rigid, *model_.placement(until_), read_only(place), struck_,
      [this](std::uint32_t node) -> Matrix3 { return Matrix3::Identity() / model_.mass[node]; }, loose_);
}

springnet_status VerletClusters::keep_lengths(const springnet_sweep& step, double& moved) const {
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    if (!clusters_[c].is_struck) continue;
    const std::vector<std::uint32_t>& nodes = model_.rigid.nodes_of(c);
    std::vector<Vector3> u, p;
    for (const std::uint32_t k : nodes) {
      u.push_back(vector_at(step.next_velocity, k));
      p.push_back(vector_at(step.next_position, k));
    }
    if (!clusters_[c].rods.keep_lengths(h_, u, p)) {
      set_message(model_.journal.message,
                  fmt::format("the rigid connections of the {} nodes in the cluster of node {}, which bodies strike, "
                              "cannot keep their lengths in a step of {:g} s; use a smaller time step",
                              nodes.size(), model_.user_number(nodes.front()), h_));
      return SPRINGNET_RECOVERABLE;
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      moved = std::max(moved, (p[i] - vector_at(step.next_position, nodes[i])).norm());
      put_vector(step.next_velocity, nodes[i], u[i]);
      put_vector(step.next_position, nodes[i], p[i]);
    }
  }
  return SPRINGNET_OK;
}

std::vector<Touch> VerletClusters::touches() const {
  std::vector<Touch> result;
  for (std::size_t c = 0; c < clusters_.size(); ++c)
    if (clusters_[c].is_struck)
      for (const std::uint32_t k : model_.rigid.nodes_of(c)) result.push_back(model_.contact.now(k));
  return result;
}

void VerletClusters::add_pushes(const std::vector<PairRow>& rows, VerletContact::Pushes& pushes) const {
  // N s and N s^2 on each struck node.
  std::map<std::uint32_t, std::map<std::uint32_t, VerletContact::Push>> given;  // [cluster][node]
  for (const PairRow& row : rows)
    for (int i = 0; i < row.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (row.weights[k] == 0.0 || !model_.rigid.is_joined(row.nodes[k])) continue;
      VerletContact::Push& push = given[model_.rigid.cluster_of()[row.nodes[k]]][row.nodes[k]];
      push.velocity += row.weights[k] * row.impulse;
      push.shift += (row.lever - h_) * row.weights[k] * row.impulse;
    }
  for (const auto& [number, of_nodes] : given) {
    std::vector<std::uint32_t> nodes;
    std::vector<Vector3> impulses, levers;
    for (const auto& [node, push] : of_nodes) {
      nodes.push_back(node);
      impulses.push_back(push.velocity);
      levers.push_back(push.shift);
    }
    const auto ignore = [](std::uint32_t, const Vector3&) {};
    const Rods& rods = clusters_[number].rods;
    rods.push(
        nodes, impulses, [&](std::uint32_t k, const Vector3& by) { pushes[k].velocity += by; }, ignore);
    rods.push(
        nodes, levers, [&](std::uint32_t k, const Vector3& by) { pushes[k].shift += by; }, ignore);
  }
}

}  // namespace springnet
