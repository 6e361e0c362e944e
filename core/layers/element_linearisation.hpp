// Derivatives of the forces of elements, and of pressures that follow faces, on nodes.
//
// Elements of three or four nodes are blocks between their nodes; those of all elements are summed up, so that a
// product reads every neighbour of a node once. A closed surface joins all of its nodes: with g = dV/dp, h = dV'/dp its
// part is
//   -dF/dp = g (Q_q g + Q_u h)^T + Q d2V/dp dp,   -dF/dv = Q_u g g^T,
// of which the second term is blocks between nodes with a common side, and the rest is kept as the vectors that it is.
#pragma once

#include <cstdint>
#include <vector>

#include "layers/block_rows.hpp"
#include "layers/evaluator.hpp"
#include "layers/invariant.hpp"

namespace springnet::layers {

class ElementLinearisation {
 public:
  // References have to outlive it.
  ElementLinearisation(const Layout& layout, const Evaluator& evaluator) : layout_(layout), evaluator_(evaluator) {}

  // SPRINGNET_FAILED if a law has no derivatives.
  // pressure: that of the external forces.
  springnet_status update(double time, const NodeArrays& nodes, const double* pressure, springnet_message& message);
  // Whether what the laws answered to the last update() is finite.
  [[nodiscard]] bool finite() const noexcept { return finite_; }
  // Whether there is anything at all.
  [[nodiscard]] bool any() const noexcept {
    return layout_.elements().live_count() > 0 || layout_.loaded_faces().any_follows();
  }
  // To be called after elements or faces were removed, before the next update().
  void topology_changed() noexcept { pattern_known_ = false; }

  // What all nodes of a surface contribute to a product, before force(): dp, dv as 3n numbers, x of all nodes first.
  void prepare(const double* dp, const double* dv);
  // Change of the force on a node, N.
  [[nodiscard]] Vector3 force(std::uint32_t node, const double* dp, const double* dv) const;
  // Node by node: with F the change of the force on a node by velocity_weight dv = position_weight dp = u, what the
  // other nodes have of it. follow() before, and moved() after every change of u; [3] components, [node].
  void weigh(double velocity_weight, double position_weight) {
    velocity_weight_ = velocity_weight;
    position_weight_ = position_weight;
  }
  [[nodiscard]] Vector3 force_of_others(std::uint32_t node, const double* const u[3]) const;
  void follow(const double* const u[3]);
  void moved(std::uint32_t node, const Vector3& change);
  // velocity_weight (-dF/dv) + position_weight (-dF/dp) of a node by itself, with or without the vectors.
  [[nodiscard]] Block diagonal(std::uint32_t node, double velocity_weight, double position_weight, bool vectors) const;
  // The same between two different nodes, without the vectors: what(i, j, block), for every block that there is.
  template <class What>
  void for_each_block(double velocity_weight, double position_weight, const What& what) const;
  // The vectors: the sum over `vector_count()` surfaces of g (weight)^T. what(surface, node, g, weight).
  [[nodiscard]] std::size_t vector_count() const noexcept { return layout_.elements().surfaces().size(); }
  template <class What>
  void for_each_vector(double velocity_weight, double position_weight, const What& what) const;

 private:
  struct SurfaceDerivatives {
    ElementForce law;
    std::vector<Vector3> gradient;       // g, [place]
    std::vector<Vector3> rate_gradient;  // h, [place]
    double product = 0.0;                // of prepare(), or follow()
  };
  springnet_status ask(const ElementBatch& batch, double time, const std::uint32_t* members, const double* q,
                       const double* rate, ElementForce* forces, springnet_message& message);
  springnet_status update_surfaces(double time, const NodeArrays& nodes, springnet_message& message);
  void make_pattern();
  void add_pressures(const NodeArrays& nodes, const double* pressure);
  void add(const ElementBlocks& blocks, std::size_t count, const std::uint32_t* targets);

  const Layout& layout_;
  const Evaluator& evaluator_;
  bool pattern_known_ = false;
  bool finite_ = true;
  BlockRows rows_;
  // Sums of blocks, [block of rows_]; of damping only where `damped_`: a law answers to rates.
  std::vector<Block> stiffness_, damping_;
  bool damped_ = false;
  std::vector<std::uint32_t> targets_;          // blocks of rows_: for batched elements (i, j), row by row
  std::vector<std::uint32_t> face_targets_;     // for each node and each of its faces: itself, next, last
  std::vector<std::uint32_t> surface_targets_;  // for live surfaces, [spoke]
  std::vector<SurfaceDerivatives> surfaces_;
  // The factor of g in the rank-one term of a surface, by u of one of its nodes.
  [[nodiscard]] Vector3 weight_of(const SurfaceDerivatives& own, std::size_t place) const {
    return (position_weight_ * own.law.by_q + velocity_weight_ * own.law.by_rate) * own.gradient[place] +
           position_weight_ * own.law.by_rate * own.rate_gradient[place];
  }
  double velocity_weight_ = 0.0, position_weight_ = 0.0;  // of weigh()
};

template <class What>
void ElementLinearisation::for_each_block(double velocity_weight, double position_weight, const What& what) const {
  for (std::uint32_t node = 0; node < layout_.node_count(); ++node) {
    for (std::size_t b = rows_.begin(node); b < rows_.end(node); ++b) {
      if (rows_.other(b) == node) continue;
      Block block = position_weight * stiffness_[b];
      if (damped_) block += velocity_weight * damping_[b];
      what(node, rows_.other(b), block);
    }
  }
}

template <class What>
void ElementLinearisation::for_each_vector(double velocity_weight, double position_weight, const What& what) const {
  const ElementLayout& elements = layout_.elements();
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    const ElementLayout::Surface& surface = elements.surfaces()[s];
    if (!elements.alive(surface.element)) continue;
    const SurfaceDerivatives& own = surfaces_[s];
    const double by_gradient = position_weight * own.law.by_q + velocity_weight * own.law.by_rate;
    for (std::size_t place = 0; place < surface.surface.size(); ++place)
      what(s, surface.surface.nodes()[place], own.gradient[place],
           Vector3(by_gradient * own.gradient[place] + position_weight * own.law.by_rate * own.rate_gradient[place]));
  }
}

}  // namespace springnet::layers
