// Derivatives of the forces of elements and of following pressures.
//
// Elements of three or four nodes give blocks between their nodes, summed over the elements, so that a product reads
// each neighbour of a node once. An enclosure couples all of its nodes: with g = dV/dp, h = dV'/dp its part is
//   -dF/dp = g (Q_q g + Q_u h)^T + Q d2V/dp dp,   -dF/dv = Q_u g g^T,
// where the term with d2V has blocks only between nodes of a common side; the rank-one terms are kept as vectors.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "layers/elements/blocks.hpp"
#include "layers/evaluator.hpp"
#include "layers/linear/block_rows.hpp"

namespace springnet::layers {

class ElementLinearisation {
 public:
  // Layout and evaluator must outlive it.
  ElementLinearisation(const Layout& layout, const Evaluator& evaluator);
  ~ElementLinearisation();

  // Computes all blocks and vectors at a state. pressure: Pa, [load], or null. SPRINGNET_FAILED if a law has no
  // derivatives.
  springnet_status update(double time, const NodeArrays& nodes, const double* pressure, springnet_message& message);
  // Whether all that the laws answered in the last update() is finite.
  [[nodiscard]] bool finite() const noexcept { return finite_; }
  // Whether there is any live element or face under a following pressure.
  [[nodiscard]] bool any() const noexcept {
    return layout_.elements().live_count() > 0 || layout_.loaded_faces().any_following();
  }
  // Call it after elements or faces were removed, before the next update().
  void topology_changed() noexcept { pattern_known_ = false; }

  // Per-enclosure scalars of the rank-one terms; call before force(). dp, dv: 3n numbers, x of all nodes first.
  void prepare(const double* dp, const double* dv);
  // Change of the force on a node for these dp (m) and dv (m/s), N.
  [[nodiscard]] Vector3 force(std::uint32_t node, const double* dp, const double* dv) const;
  // The same transposed, for weights of forces on nodes: prepare_transposed(), then of each node what is added to the
  // weights of its position and velocity.
  void prepare_transposed(const double* weights);
  void add_transposed(std::uint32_t node, const double* weights, Vector3& by_position, Vector3& by_velocity) const;
  // Node by node, for dv = velocity_weight u and dp = position_weight u: the change of the force on a node due to all
  // other nodes. Call track() first and add_change() after every change of u; [3] components, [node].
  void set_weights(double velocity_weight, double position_weight) {
    velocity_weight_ = velocity_weight;
    position_weight_ = position_weight;
  }
  [[nodiscard]] Vector3 off_diagonal_force(std::uint32_t node, const double* const u[3]) const;
  void track(const double* const u[3]);
  void add_change(std::uint32_t node, const Vector3& change);
  // Diagonal block of velocity_weight (-dF/dv) + position_weight (-dF/dp), with or without the rank-one terms.
  [[nodiscard]] Block diagonal(std::uint32_t node, double velocity_weight, double position_weight, bool vectors) const;
  // Its other blocks, without the rank-one terms: what(i, j, block) for each i != j that has one.
  template <class What>
  void for_each_block(double velocity_weight, double position_weight, const What& what) const;
  // The pattern of the blocks, and one of them, of its row's node by itself or by another node; only if any().
  [[nodiscard]] const BlockRows& rows() const noexcept { return rows_; }
  [[nodiscard]] Block weighted(std::size_t b, double velocity_weight, double position_weight) const {
    Block result = position_weight * stiffness_[b];
    if (damped_) result += velocity_weight * damping_[b];
    return result;
  }
  // Its rank-one terms g weight^T, one for each enclosure: what(enclosure, node, g, weight).
  [[nodiscard]] std::size_t vector_count() const noexcept { return layout_.elements().enclosures().size(); }
  template <class What>
  void for_each_vector(double velocity_weight, double position_weight, const What& what) const;
  // The share of g in weight.
  [[nodiscard]] double vector_stiffness(std::size_t enclosure, double velocity_weight, double position_weight) const {
    const ElementForce& law = enclosures_[enclosure].law;
    return position_weight * law.by_q + velocity_weight * law.by_rate;
  }

 private:
  struct EnclosureDerivatives {
    ElementForce law;
    std::vector<Vector3> gradient;       // g, [place]
    std::vector<Vector3> rate_gradient;  // h, [place]
    double product = 0.0;                // of prepare(), prepare_transposed() or track()
  };
  springnet_status evaluate_elements(const ElementBatch& batch, double time, const NodeArrays& nodes,
                                     const std::uint32_t* members, const double* q, const double* rate,
                                     ElementForce* forces, springnet_message& message);
  springnet_status update_several(const ElementBatch& batch, double time, const NodeArrays& nodes,
                                  const std::uint32_t*& targets, springnet_message& message);
  springnet_status update_enclosures(double time, const NodeArrays& nodes, springnet_message& message);
  void make_pattern();
  void add_pressures(const NodeArrays& nodes, const double* pressure);
  void add(const ElementBlocks& blocks, std::size_t count, const std::uint32_t* targets);

  const Layout& layout_;
  const Evaluator& evaluator_;
  bool pattern_known_ = false;
  bool finite_ = true;
  BlockRows rows_;
  // Sums over elements, [block of rows_]. damping_ is used only if damped_: some law depends on the rate.
  std::vector<Block> stiffness_, damping_;
  bool damped_ = false;
  std::vector<std::uint32_t> mirrored_;           // [block of rows_] (j, i) of (i, j)
  std::vector<std::uint32_t> targets_;            // blocks of rows_: for batched elements (i, j), row by row
  std::vector<std::uint32_t> face_targets_;       // of each node, for each of its faces: itself, next, last
  std::vector<std::uint32_t> enclosure_targets_;  // of live enclosures, [spoke]
  std::vector<EnclosureDerivatives> enclosures_;
  struct SeveralWork;
  std::unique_ptr<SeveralWork> several_;  // null until an element's laws read several scalars
  // The factor of g in the rank-one term of an enclosure, by u of one of its nodes.
  [[nodiscard]] Vector3 weight_of(const EnclosureDerivatives& own, std::size_t place) const {
    return (position_weight_ * own.law.by_q + velocity_weight_ * own.law.by_rate) * own.gradient[place] +
           position_weight_ * own.law.by_rate * own.rate_gradient[place];
  }
  double velocity_weight_ = 0.0, position_weight_ = 0.0;  // of set_weights()
};

template <class What>
void ElementLinearisation::for_each_block(double velocity_weight, double position_weight, const What& what) const {
  for (std::uint32_t node = 0; node < layout_.node_count(); ++node) {
    for (std::size_t b = rows_.begin(node); b < rows_.end(node); ++b) {
      if (rows_.other(b) == node) continue;
      what(node, rows_.other(b), weighted(b, velocity_weight, position_weight));
    }
  }
}

template <class What>
void ElementLinearisation::for_each_vector(double velocity_weight, double position_weight, const What& what) const {
  const ElementLayout& elements = layout_.elements();
  for (std::size_t s = 0; s < enclosures_.size(); ++s) {
    const ElementLayout::EnclosureElement& enclosure = elements.enclosures()[s];
    if (!elements.alive(enclosure.element)) continue;
    const EnclosureDerivatives& own = enclosures_[s];
    const double by_gradient = position_weight * own.law.by_q + velocity_weight * own.law.by_rate;
    for (std::size_t place = 0; place < enclosure.shape.size(); ++place)
      what(s, enclosure.shape.nodes()[place], own.gradient[place],
           Vector3(by_gradient * own.gradient[place] + position_weight * own.law.by_rate * own.rate_gradient[place]));
  }
}

}  // namespace springnet::layers
