// Approximate inverses of a block system, symmetric and positive definite where the system is symmetric: the nodes' own
// blocks, or an incomplete factorisation without fill-in, ILU(0), in pieces of some thousand nodes on which threads
// work independently. (Measured: ILU(0) wins on surfaces, tubes and small nets; on solids it takes as long as blocks.)
#pragma once

#include <cstdint>
#include <vector>

#include "layers/linear/block_system.hpp"

namespace springnet::layers {

class BlockPreconditioner {
 public:
  enum class Kind { blocks, factors };

  // Most nodes of a piece. Pieces depend on the network alone, never on the number of threads.
  static constexpr std::size_t piece = 4096;

  void set(const BlockSystem& system, Kind wanted, unsigned threads);
  [[nodiscard]] Kind kind() const noexcept { return kind_; }
  // Inverses of the nodes' own blocks, symmetric; [node][9]. Made positive definite where they are not.
  [[nodiscard]] const std::vector<double>& inverse_blocks() const noexcept { return inverse_; }
  // z = P^-1 r for nodes of one or more whole pieces.
  void apply(const BlockKernels& kernels, NodeRange nodes, const double* r, double* z) const;

 private:
  using Columns = Eigen::Matrix<double, 3, 3>;
  void invert_blocks(const BlockSystem& system);
  void find_pattern(const BlockSystem& system);
  void factorise(const BlockSystem& system, NodeRange nodes);

  struct Triangle {
    std::vector<std::uint32_t> start, column, source;  // source: block of the system
    std::vector<double> values;
    [[nodiscard]] BlockArrays arrays() const noexcept { return {start.data(), column.data(), values.data()}; }
    void clear() {
      start.assign(1, 0);
      column.clear();
      source.clear();
    }
  };
  Kind kind_ = Kind::blocks;
  std::vector<double> inverse_;
  Triangle lower_, upper_;
  std::vector<double> pivots_;  // [node][9] inverse diagonal blocks of U
};

}  // namespace springnet::layers
