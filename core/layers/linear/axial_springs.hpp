// Derivatives of springs whose laws act along their axes, nine numbers each, for products over all of them: the matrix
// and its parts are never written. Springs lie as SpringOrder has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "layers/evaluator.hpp"
#include "layers/linear/axial_segments.hpp"
#include "layers/linear/spring_kernels.hpp"
#include "layers/linear/spring_order.hpp"
#include "layers/springs/blocks.hpp"

namespace springnet::layers {

class AxialSprings {
 public:
  // References must outlive it.
  AxialSprings(const Layout& layout, const Evaluator& evaluator);

  // Evaluates the laws of all springs at a state. False: one of them failed, or its answer is not finite, of a spring
  // that does not join two constrained nodes ([node] 1).
  [[nodiscard]] bool update(double time, const NodeArrays& nodes, const std::vector<std::uint8_t>& constrained);
  [[nodiscard]] SpringBlocks blocks(std::uint32_t spring) const;
  // y -= (velocity_weight D + position_weight K)^T x, summed over all springs; [node][4]: x, y, z and 0, in y one of no
  // meaning.
  void subtract_transposed(double velocity_weight, double position_weight, const double* x, double* y) const;
  // y -= D v + K p, likewise.
  void subtract_product(const double* p, const double* v, double* y) const;

 private:
  void follow();
  [[nodiscard]] bool update_unit(std::size_t index, double time, const NodeArrays& nodes,
                                 const std::vector<std::uint8_t>& constrained);
  [[nodiscard]] bool is_finite_where_it_matters(const AxialAnswers& answers,
                                                const std::vector<std::uint8_t>& constrained) const;
  // function(rows, nodes, whether they end in these nodes), units side by side.
  template <class Function>
  void for_each_unit(const Function& function) const;

  const Layout& layout_;
  const Evaluator& evaluator_;
  const SpringKernels& linear_kernels_;
  SpringOrder order_;
  AxialSegments segments_;
  bool is_laid_out_ = false;        // what follows is of that order
  std::vector<std::size_t> begin_;  // [unit][2] of its springs within, and of those that leave it
  std::vector<std::vector<std::uint32_t>> place_of_slot_;        // [unit][slot]
  std::vector<std::uint32_t> place_;                             // [spring] one of its places
  std::vector<std::pair<std::uint32_t, std::uint32_t>> copies_;  // places of one spring: from, to
  struct alignas(64) Values {                                    // those of a spring lie in one line of the cache
    double number[8];
  };
  std::vector<Values> values_;     // [place], see AxialRows
  std::vector<double> by_length_;  // [place]
};

}  // namespace springnet::layers
