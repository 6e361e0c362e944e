// The matrix of an implicit step, row by row: with A = (1 + shift) I - velocity da/dv - position da/dp,
//
//   S = M A + sum over enclosures and drags of g w^T
//
// in blocks of 3 x 3 numbers. M: the masses, so that S is symmetric for the most part where forces have a potential
// and neurons are point masses. Fixed and held nodes have zero rows and columns but for their own block. The pattern,
// and the place in it of each spring and element, stay until springs or elements are removed.
#pragma once

#include <cstdint>
#include <vector>

#include "layers/linear/block_kernels.hpp"
#include "layers/linear/linearisation.hpp"

namespace springnet::layers {

struct SystemWeights {
  double velocity = 0.0;  // s
  double position = 0.0;  // s^2
  double shift = 0.0;     // 1
};

class BlockSystem {
 public:
  // References must outlive it. mass: [node] kg; constrained: [node] 1 for nodes that do not move.
  BlockSystem(const Layout& layout, const std::vector<double>& mass, const std::vector<std::uint8_t>& constrained,
              unsigned threads)
      : layout_(layout), mass_(mass), constrained_(constrained), threads_(threads) {}

  // Takes over the derivatives. They must be known.
  void assemble(Linearisation& derivatives, const SystemWeights& weights);
  // Call it after springs or elements were removed.
  void topology_changed() noexcept { pattern_known_ = false; }

  [[nodiscard]] std::size_t node_count() const noexcept { return mass_.size(); }
  [[nodiscard]] BlockArrays arrays() const noexcept { return {start_.data(), column_.data(), values_.data()}; }
  [[nodiscard]] std::size_t block_count() const noexcept { return column_.size(); }
  // Index of a node's own block.
  [[nodiscard]] std::uint32_t own_block(std::size_t node) const noexcept { return own_[node]; }
  [[nodiscard]] const std::vector<double>& mass() const noexcept { return mass_; }
  [[nodiscard]] const std::vector<std::uint8_t>& constrained() const noexcept { return constrained_; }
  // |S - S^T| / |S|, Frobenius norms.
  [[nodiscard]] double asymmetry() const noexcept { return asymmetry_; }

  // The rank-one terms, one for each live enclosure and each drag. Vectors are [place].
  struct RankOne {
    std::vector<std::uint32_t> nodes;
    std::vector<Vector3> g, w;
    double stiffness = 0.0;  // c in w = c g + ..., kg m^-4 of an enclosure, kg of a drag
  };
  [[nodiscard]] const std::vector<RankOne>& terms() const noexcept { return terms_; }

 private:
  using Columns = Eigen::Matrix<double, 3, 3>;  // as blocks are stored
  void make_pattern(Linearisation& derivatives);
  [[nodiscard]] std::uint32_t find(std::uint32_t row, std::uint32_t column) const noexcept;
  void assemble_row(std::uint32_t node, const Linearisation& derivatives, const SystemWeights& weights);
  void add_enclosures(const Linearisation& derivatives, const SystemWeights& weights);
  void add_drags(const Linearisation& derivatives, const SystemWeights& weights);
  void measure();
  [[nodiscard]] Eigen::Map<Columns> block(std::size_t index) { return Eigen::Map<Columns>(values_.data() + 9 * index); }
  [[nodiscard]] Eigen::Map<const Columns> block(std::size_t index) const {
    return Eigen::Map<const Columns>(values_.data() + 9 * index);
  }

  const Layout& layout_;
  const std::vector<double>& mass_;
  const std::vector<std::uint8_t>& constrained_;
  unsigned threads_;
  bool pattern_known_ = false;
  std::vector<std::uint32_t> start_;  // [node + 1]
  std::vector<std::uint32_t> column_, transposed_;
  std::vector<std::uint32_t> own_;             // [node]
  std::vector<std::uint32_t> spring_places_;   // [incident]
  std::vector<std::uint32_t> element_places_;  // [block of the elements' rows]
  std::vector<double> values_;
  std::vector<RankOne> terms_;
  double asymmetry_ = 0.0;
};

}  // namespace springnet::layers
