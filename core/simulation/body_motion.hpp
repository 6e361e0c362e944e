// How bodies that touch, and the obstacles under them, push each other at a state, while no pair meets, parts, sticks
// or slips: for integrators that locate these events.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "constraints/pair_motion.hpp"
#include "simulation/model.hpp"

namespace springnet {

class ReactionsAt;

class BodyMotion {
 public:
  // Of the pairs that touch at the committed state, at the state of `reactions`.
  springnet_status find(Model& model, ReactionsAt& reactions);

  struct OfPair {
    PairMotion motion;
    Vector3 force = Vector3::Zero();         // N, on the first
    double pressing = 0.0;                   // N, along the normal
    Vector3 acceleration = Vector3::Zero();  // m/s^2, relative
  };
  [[nodiscard]] const std::vector<OfPair>& pairs() const noexcept { return pairs_; }  // as bodies.touching()
  struct OfNode {
    Vector3 acceleration = Vector3::Zero();  // m/s^2, with all forces
    Vector3 pushed = Vector3::Zero();        // N, by bodies
    Vector3 reaction = Vector3::Zero();      // N, of obstacles, or of what fixes it; not of fixed nodes of clusters
  };
  // Null: no body touches it.
  [[nodiscard]] const OfNode* find(std::uint32_t node) const {
    const auto found = nodes_.find(node);
    return found == nodes_.end() ? nullptr : &found->second;
  }
  [[nodiscard]] const std::map<std::uint32_t, OfNode>& nodes() const noexcept { return nodes_; }

 private:
  std::vector<OfPair> pairs_;
  std::map<std::uint32_t, OfNode> nodes_;
};

}  // namespace springnet
