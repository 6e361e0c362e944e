// Derivatives of the forces of elements on nodes.
//
// Elements of three or four nodes are blocks between their nodes. A closed surface joins all of its nodes: with g =
// dV/dp, h = dV'/dp its part is
//   -dF/dp = g (Q_q g + Q_u h)^T + Q d2V/dp dp,   -dF/dv = Q_u g g^T,
// of which the second term is blocks between nodes with a common side, and the rest is kept as the vectors that it is.
#pragma once

#include <cstdint>
#include <vector>

#include "layers/evaluator.hpp"
#include "layers/invariant.hpp"

namespace springnet::layers {

class ElementLinearisation {
 public:
  // References have to outlive it.
  ElementLinearisation(const Layout& layout, const Evaluator& evaluator) : layout_(layout), evaluator_(evaluator) {}

  // SPRINGNET_FAILED if a law has no derivatives.
  springnet_status update(double time, const NodeArrays& nodes, springnet_message& message);

  // What all nodes of a surface contribute to a product, before force(): dp, dv as 3n numbers, x of all nodes first.
  void prepare(const double* dp, const double* dv);
  // Change of the force on a node, N.
  [[nodiscard]] Vector3 force(std::uint32_t node, const double* dp, const double* dv) const;
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
    std::vector<Vector3> across;         // Q d2V/dp dp_other as a cross product, [spoke]
    double product = 0.0;                // of prepare()
  };
  springnet_status ask(const ElementBatch& batch, double time, const std::uint32_t* members, const double* q,
                       const double* rate, ElementForce* forces, springnet_message& message) const;

  const Layout& layout_;
  const Evaluator& evaluator_;
  std::vector<ElementBlocks> blocks_;  // [element]; of three or four nodes
  std::vector<SurfaceDerivatives> surfaces_;
};

// x -> a x x as a matrix.
[[nodiscard]] inline Block cross_matrix(const Vector3& a) {
  Block block;
  block << 0.0, -a[2], a[1], a[2], 0.0, -a[0], -a[1], a[0], 0.0;
  return block;
}

template <class What>
void ElementLinearisation::for_each_block(double velocity_weight, double position_weight, const What& what) const {
  const ElementLayout& elements = layout_.elements();
  for (const std::uint32_t e : elements.batched()) {
    const std::span<const std::uint32_t> nodes = elements.nodes(e);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (std::size_t j = 0; j < nodes.size(); ++j)
        if (i != j)
          what(nodes[i], nodes[j],
               Block(velocity_weight * blocks_[e].damping_block(i, j) + position_weight * blocks_[e].stiffness[i][j]));
  }
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    const ElementLayout::Surface& surface = elements.surfaces()[s];
    if (!elements.alive(surface.element)) continue;
    for (std::size_t place = 0; place < surface.surface.size(); ++place) {
      std::size_t spoke = surface.surface.first_spoke(place);
      for (const ClosedSurface::Spoke& to : surface.surface.spokes(place))
        what(surface.surface.nodes()[place], to.other,
             Block(position_weight * cross_matrix(surfaces_[s].across[spoke++])));
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
