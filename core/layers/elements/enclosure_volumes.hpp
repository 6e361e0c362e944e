// Volumes of all enclosures at a state, and how they change as nodes are updated one after another.
#pragma once

#include <cstdint>
#include <vector>

#include "layers/elements/layout.hpp"

namespace springnet::layers {

// V and V' are linear in one node's own position and velocity. So a sweep over all nodes computes them once, and again
// follows each node that was moved by what that node changes; the rounding of a sweep is that of a sum over its nodes.
class EnclosureVolumes {
 public:
  // Of all live enclosures.
  void compute(const ElementLayout& elements, const NodeArrays& nodes);
  // The same, and from here on until stop() they answer for these arrays while nodes in them change: at most those
  // since the last commit() that are no neighbours of the one asked for.
  void follow(const ElementLayout& elements, const NodeArrays& nodes);
  void commit(std::uint32_t node);
  void stop() noexcept { following_ = false; }
  [[nodiscard]] bool follows(const NodeArrays& nodes) const noexcept {
    return following_ && nodes.px == now_.px && nodes.vx == now_.vx;
  }

  // As one of the nodes of an enclosure sees them: with itself where it is now, all others as they were at the last
  // commit(). gradient, rate_gradient: of the enclosure at that node.
  [[nodiscard]] Enclosure::Values seen_by(std::uint32_t node, std::uint32_t enclosure, const Vector3& gradient,
                                          const Vector3& rate_gradient) const noexcept;

 private:
  [[nodiscard]] NodeArrays base() const noexcept {
    return {base_[0].data(), base_[1].data(), base_[2].data(), base_[3].data(), base_[4].data(), base_[5].data()};
  }
  // What moved since the last commit.
  void moved(std::uint32_t node, Vector3& position, Vector3& velocity) const noexcept;

  const ElementLayout* elements_ = nullptr;
  bool following_ = false;
  NodeArrays now_{};
  std::vector<double> base_[6];            // [node] x, y, z of positions and velocities at the last commit
  std::vector<Enclosure::Values> values_;  // [enclosure] there
};

}  // namespace springnet::layers
