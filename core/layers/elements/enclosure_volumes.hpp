// Volumes of all enclosures at a state, kept up to date while nodes are updated one after another.
#pragma once

#include <cstdint>
#include <vector>

#include "layers/elements/layout.hpp"

namespace springnet::layers {

// V and V' are linear in a single node's position and velocity. So a sweep computes them once and then adds the change
// that each updated node makes; rounding errors grow as in a sum over its nodes.
class EnclosureVolumes {
 public:
  // Computes those of all live enclosures.
  void compute(const ElementLayout& elements, const NodeArrays& nodes);
  // Incremental mode: computes them, and until stop() they follow changes of the arrays. Call commit() for each node
  // that changed; before that, values_for() may be asked for it and for nodes that are not its neighbours.
  void follow(const ElementLayout& elements, const NodeArrays& nodes);
  void commit(std::uint32_t node);
  void stop() noexcept { following_ = false; }
  [[nodiscard]] bool follows(const NodeArrays& nodes) const noexcept {
    return following_ && nodes.px == now_.px && nodes.vx == now_.vx;
  }

  // Volume and rate with `node` at its present state and all others as last committed. gradient, rate_gradient: of the
  // enclosure at that node.
  [[nodiscard]] Enclosure::Values values_for(std::uint32_t node, std::uint32_t enclosure, const Vector3& gradient,
                                             const Vector3& rate_gradient) const noexcept;

 private:
  [[nodiscard]] NodeArrays base() const noexcept {
    return {base_[0].data(), base_[1].data(), base_[2].data(), base_[3].data(), base_[4].data(), base_[5].data()};
  }
  // Change of a node's state since its last commit.
  void change_since_commit(std::uint32_t node, Vector3& position, Vector3& velocity) const noexcept;

  const ElementLayout* elements_ = nullptr;
  bool following_ = false;
  NodeArrays now_{};
  std::vector<double> base_[6];            // [node] x, y, z of positions and velocities at the last commit
  std::vector<Enclosure::Values> values_;  // [enclosure] there
};

}  // namespace springnet::layers
