#include "simulation/body_groups.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

namespace springnet {

std::vector<BodyGroup> body_groups(const Model& model, const std::vector<PairMotion>& pairs) {
  const std::vector<std::uint8_t>& fixed = model.contact.fixed();
  std::vector<std::size_t> parent(pairs.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::map<std::uint32_t, std::size_t> owner;  // [node] a pair of it, or of its cluster
  const auto own = [&](std::uint32_t k, std::size_t i) {
    if (fixed[k] != 0) return;
    const auto [found, is_new] = owner.emplace(k, i);
    if (is_new) return;
    const std::size_t a = root(found->second), b = root(i);
    parent[std::max(a, b)] = std::min(a, b);
  };
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (std::size_t j = 0; j < pairs[i].count; ++j) {
      const std::uint32_t k = pairs[i].nodes[j];
      own(k, i);
      // What is fixed takes nothing of an impulse on it to its cluster.
      if (fixed[k] != 0 || !model.rigid.is_joined(k)) continue;
      for (const std::uint32_t joined : model.rigid.nodes_of(model.rigid.cluster_of()[k])) own(joined, i);
    }
  std::vector<BodyGroup> groups;
  std::map<std::size_t, std::size_t> group_of;  // [root]
  for (const auto& [node, pair] : owner) {
    const auto [found, is_new] = group_of.emplace(root(pair), groups.size());
    if (is_new) groups.emplace_back();
    groups[found->second].nodes.push_back(node);
  }
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (const auto found = group_of.find(root(i)); found != group_of.end()) groups[found->second].pairs.push_back(i);
  return groups;
}

Eigen::MatrixXd mobility_of(const Model& model, const std::vector<Lever>& levers, const StruckClusters& clusters) {
  const auto size = static_cast<Eigen::Index>(3 * levers.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size, size);
  std::map<std::uint32_t, std::vector<std::pair<std::size_t, double>>> of_node;
  for (std::size_t i = 0; i < levers.size(); ++i)
    levers[i].for_each([&](std::uint32_t k, double weight) {
      if (model.contact.fixed()[k] == 0 && weight != 0.0) of_node[k].emplace_back(i, weight);
    });
  std::map<std::uint32_t, std::vector<std::uint32_t>> struck;  // [cluster]
  for (const auto& [node, users] : of_node) {
    if (model.rigid.is_joined(node)) {
      struck[model.rigid.cluster_of()[node]].push_back(node);
      continue;
    }
    for (const auto& [i, by] : users)
      for (const auto& [j, to] : users)
        for (Eigen::Index c = 0; c < 3; ++c)
          result(static_cast<Eigen::Index>(3 * i) + c, static_cast<Eigen::Index>(3 * j) + c) +=
              by * to / model.mass[node];
  }
  for (const auto& [number, nodes] : struck) {
    const Eigen::MatrixXd answers = clusters.clusters().at(number).mobility(nodes);
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t b = 0; b < nodes.size(); ++b) {
        const Matrix3 answer = answers.block<3, 3>(static_cast<Eigen::Index>(3 * a), static_cast<Eigen::Index>(3 * b));
        for (const auto& [i, by] : of_node[nodes[a]])
          for (const auto& [j, to] : of_node[nodes[b]])
            result.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j)) += by * to * answer;
      }
  }
  return result;
}

Vector3 slip_direction(const Model& model, const PairTouch& touch, const PairMotion& motion) {
  const Vector3 slip = motion.slip();
  const double speed = slip.norm();
  if (touch.phase == Contact::Slip::ongoing && speed > 0.5 * model.contact.rest_speed()) return slip / speed;
  const Vector3 kept = motion.along(touch.slip);
  const double length = kept.norm();
  return length > 0.0 ? Vector3(kept / length) : speed > 0.0 ? Vector3(slip / speed) : Vector3::Zero();
}

}  // namespace springnet
