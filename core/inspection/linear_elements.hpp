// The network's elements and following pressures, linearised where they are at the start and at rest.
#pragma once

#include <span>
#include <vector>

#include <springnet/network.hpp>

#include "layers/elements/blocks.hpp"
#include "layers/elements/enclosure.hpp"

namespace springnet {

// The forces on its nodes change by -sum_j (K_ij dp_j + D_ij dv_j).
struct LinearElement {
  std::vector<NodeIndex> nodes;              // each once
  double scale;                              // of q: 1 rad, or the area or volume at the start
  double force;                              // Q at the start; nan if a law cannot be linearised
  double stiffness, damping;                 // dQ/dq, dQ/dq'
  layers::ElementBlocks blocks;              // of three or four nodes
  std::vector<layers::Enclosure> enclosure;  // one of an enclosed volume, else none
  std::vector<Vector3> gradient;             // dq/dp, [node]
  std::vector<std::vector<Vector3>> across;  // Q d2V/dp dp_other x as a cross product, [node][spoke]

  [[nodiscard]] bool is_enclosure() const { return !enclosure.empty(); }
  // t^2 K + t D between two of its nodes. Of an enclosed volume: without what dV/dp makes of all its nodes.
  [[nodiscard]] layers::Block between(std::size_t i, std::size_t j, double t) const {
    return t * t * blocks.stiffness[i][j] + t * blocks.damping_block(i, j);
  }
  // The same of what it makes of them: (this) dV/dp_i dV/dp_j^T.
  [[nodiscard]] double of_volume(double t) const { return t * t * stiffness + t * damping; }
};

// An element as one of its nodes sees it.
struct LinearShare {
  ElementIndex element;
  std::uint32_t place;
};

class LinearElements {
 public:
  LinearElements() = default;
  LinearElements(const Network& network, std::vector<LinearElement> elements);

  // The network's elements, then faces under a following pressure.
  [[nodiscard]] const std::vector<LinearElement>& all() const { return elements_; }
  [[nodiscard]] std::span<const LinearShare> of(NodeIndex node) const {
    if (start_.empty()) return {};
    return {shares_.data() + start_[node], shares_.data() + start_[node + 1]};
  }
  // t^2 K + t D of a node by itself.
  [[nodiscard]] layers::Block diagonal(NodeIndex node, double t) const;
  // Norms of the stiffness and damping in the diagonal block.
  [[nodiscard]] double stiffness_bound(NodeIndex node) const { return diagonal(node, 1.0, 0.0).norm(); }
  [[nodiscard]] double damping_bound(NodeIndex node) const { return diagonal(node, 0.0, 1.0).norm(); }
  // Whether none of them can lose energy by a motion: no load on any, and none that softens.
  [[nodiscard]] bool plainly_definite() const;

 private:
  [[nodiscard]] layers::Block diagonal(NodeIndex node, double stiffness_weight, double damping_weight) const;

  std::vector<LinearElement> elements_;
  std::vector<std::size_t> start_;
  std::vector<LinearShare> shares_;
};

// The geometry of an element at rest; its laws have still to be asked.
[[nodiscard]] LinearElement element_at_rest(const Network& network, const Element& element, double& value);
// A face under a pressure that follows it: blocks without a law.
[[nodiscard]] LinearElement pressed_face(const Network& network, const Face& face, double pressure);
// Once force, stiffness and damping are known.
void linearise_element(const Network& network, const Element& element, LinearElement& linear);

}  // namespace springnet
