// Nodes that rigid connections join, where bodies strike them in the drift of velocity Verlet: an impulse on one node
// moves and turns them all,
//
//   u = v + W (h/2 F + G^T r + sum w J),   P = p + h u + … ,   lengths(P) = l,
//
// with the connections' impulses r along their directions at p, or where the first impact of the step happens, so that
// momentum and angular momentum are kept.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "constraints/body_contacts.hpp"
#include "constraints/cluster_responses.hpp"
#include "constraints/pair_rows.hpp"
#include "simulation/model.hpp"
#include "simulation/verlet_contact.hpp"

namespace springnet {

class VerletClusters {
 public:
  // For a step of this length (s) that ends at `until`.
  VerletClusters(Model& model, double until, double length);

  [[nodiscard]] bool any() const noexcept { return model_.rigid.any(); }
  // Knows where clusters go without bodies: P and u of obstacles and forces.
  void begin(const springnet_sweep& step);
  // Positions at the end of the step, m, where also clusters that no body strikes keep their lengths. Valid until the
  // next call.
  [[nodiscard]] proximity::Positions end(const springnet_sweep& step);
  // Bodies strike a node at this share of the step: its cluster answers impulses on it, once renewed. False if it did
  // before, or has no rigid connections.
  bool strike(const springnet_sweep& step, std::uint32_t node, double share);
  // From the next renewal on the cluster of a node answers as if no obstacles held it: what they do then is found in
  // turn. False if it has no rigid connections, or does so already.
  bool loosen(std::uint32_t node);
  [[nodiscard]] const std::set<std::uint32_t>& loose() const noexcept { return loose_; }
  // Null: no cluster is struck.
  [[nodiscard]] const ClusterResponses* responses() const noexcept { return responses_.any() ? &responses_ : nullptr; }
  // After strikes, and when what obstacles let the nodes do has changed.
  void renew();
  // Impulses moved struck clusters along straight lines: corrects P and u. moved: m, by how much at most.
  // SPRINGNET_RECOVERABLE, with a message, if lengths cannot be kept.
  springnet_status keep_lengths(const springnet_sweep& step, double& moved) const;
  // Adds what the impulses of these rows give the nodes of clusters without obstacles.
  void add_pushes(const std::vector<PairRow>& rows, VerletContact::Pushes& pushes) const;
  // Which obstacles the nodes of struck clusters are on now, and how.
  [[nodiscard]] std::vector<Touch> touches() const;
  // use(node): of a node alone, or of all nodes of its cluster, those that can move.
  template <class Use>
  void for_each_moved(std::uint32_t node, const Use& use) const {
    if (!model_.rigid.is_joined(node)) {
      use(node);
      return;
    }
    for (const std::uint32_t k : model_.rigid.nodes_of(model_.rigid.cluster_of()[node]))
      if (model_.contact.fixed()[k] == 0) use(k);
  }

 private:
  using Rods = RigidConnections::WithoutContact;
  struct Cluster {
    Rods rods;
    std::vector<Vector3> velocity, position;  // u and P without bodies, m/s, m
    std::vector<Vector3> place;               // where impulses act, m
    bool is_struck = false;
  };

  Model& model_;
  double until_, h_;  // s
  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> struck_;  // nodes
  std::vector<std::uint8_t> is_node_struck_;
  std::set<std::uint32_t> loose_;  // clusters
  ClusterResponses responses_;
  std::array<std::vector<double>, 3> end_, place_;  // m, [node]
};

}  // namespace springnet
