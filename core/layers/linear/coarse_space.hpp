// A second level for preconditioners of stiff nets: groups of some thirty neighbouring nodes that move as rigid bodies.
// Blocks of single nodes see nothing of motions in which a whole net bends; there these are few numbers, of one small
// dense system. With the groups' motions P, six numbers each, and D the blocks of the nodes,
//   B = D^-1 + P (P^T S P)^-1 P^T
// (R. A. Nicolaides, SIAM J. Numer. Anal. 24, 1987; additively, as J. Mandel, Comm. Numer. Meth. Eng. 9, 1993). S and
// the small system need not agree in all: it preconditions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "layers/linear/spring_kernels.hpp"

namespace springnet::layers {

class CoarseSpace {
 public:
  explicit CoarseSpace(InstructionSet set = InstructionSet::generic) : kernels_(spring_kernels_for(set)) {}

  // Whether it can be worth its price: nets of so many nodes, and so much stiffer than their masses. stiffness: the sum
  // of the diagonal of S over that of the masses. serves_many: it is kept for systems to come, see follow(), and
  // springs make its groups rigid.
  [[nodiscard]] static bool pays(std::size_t nodes, double stiffness, bool serves_many) noexcept;
  // Springs for each moving node, which then has twice as many neighbours on average, from which on they do that.
  static constexpr double rigid = 5.0;

  void clear() noexcept { is_ready_ = false; }
  [[nodiscard]] bool any() const noexcept { return is_ready_; }
  // Of the small system.
  [[nodiscard]] std::size_t numbers() const noexcept { return all_start_.empty() ? 0 : 6 * (all_start_.size() - 1); }

  // Divides the nodes that move into groups, where they are now: in two halves along the longer side, and so on. What
  // was added before is dropped. position: x, y, z, [node] m.
  void begin(const std::array<const double*, 3>& position, const std::vector<std::uint8_t>& constrained);
  // Adds a block of S, of a row and a column; all of them, but for nodes that do not move, which are left out.
  void add_block(std::size_t row, std::size_t column, const Eigen::Matrix3d& block);
  // Adds a spring's a I + q q^T.
  void add_spring(std::size_t first, std::size_t second, double a, const Eigen::Vector3d& q);
  // Ready, but for a matrix that is not positive definite.
  void factorise();
  // Keeps the small system for a matrix that has changed a little: nodes that no longer move leave their groups, and
  // come back when they do. Those that did not move at begin() are in none.
  void follow(const std::vector<std::uint8_t>& constrained);

  // z += P (P^T S P)^-1 P^T r; answers r times that. Vectors have `stride` numbers a node, the first three of meaning.
  template <std::size_t stride, class Number>
  double correct(const Number* r, Number* z) {
    for (std::size_t g = 0; g + 1 < start_.size(); ++g) {
      double sum[6] = {};
      for (std::uint32_t i = start_[g]; i < start_[g + 1]; ++i) {
        const Number* const f = r + stride * node_[i];
        const float* const d = &arm_[3 * std::size_t{i}];
        const double x = f[0], y = f[1], w = f[2];
        sum[0] += x;
        sum[1] += y;
        sum[2] += w;
        sum[3] += d[1] * w - d[2] * y;
        sum[4] += d[2] * x - d[0] * w;
        sum[5] += d[0] * y - d[1] * x;
      }
      for (std::size_t c = 0; c < 6; ++c) right_[6 * g + c] = static_cast<float>(sum[c]);
    }
    solve();
    for (std::size_t g = 0; g + 1 < start_.size(); ++g) {
      const float* const t = solution_.data() + 6 * g;
      for (std::uint32_t i = start_[g]; i < start_[g + 1]; ++i) {
        Number* const to = z + stride * node_[i];
        const float* const d = &arm_[3 * std::size_t{i}];
        to[0] += t[0] + t[4] * d[2] - t[5] * d[1];
        to[1] += t[1] + t[5] * d[0] - t[3] * d[2];
        to[2] += t[2] + t[3] * d[1] - t[4] * d[0];
      }
    }
    double along = 0.0;
    for (std::size_t i = 0; i < scale_.size(); ++i) along += double{right_[i]} * double{solution_[i]};
    return along;
  }

 private:
  static constexpr std::uint32_t none = 0xffffffffu;
  using Block = Eigen::Matrix<double, 6, 6>;
  void solve();
  // Of the groups row >= column.
  [[nodiscard]] Eigen::Map<Block> block(std::size_t row, std::size_t column) {
    return Eigen::Map<Block>(&blocks_[36 * (row * (row + 1) / 2 + column)]);
  }
  [[nodiscard]] Eigen::Vector3d arm(std::size_t node) const {
    const float* const d = &all_arms_[3 * std::size_t{place_[node]}];
    return {d[0], d[1], d[2]};
  }

  bool is_ready_ = false;
  std::vector<std::uint32_t> all_nodes_, all_start_;  // nodes by group; [group + 1]
  std::vector<float> all_arms_;                       // [place][3] from the group's centre, in its own radius
  std::vector<std::uint32_t> group_, place_;          // [node]; none: it does not move
  std::vector<std::uint32_t> node_, start_;           // of those, the ones that move now
  std::vector<float> arm_;
  std::vector<double> blocks_;  // [block of the lower triangle, by rows][6][6] of P^T S P, the columns of each together
  const SpringKernels& kernels_;
  std::vector<float> lower_, upper_, inverse_;   // of its factors, see SpringKernels::substitute
  std::vector<float> right_, solution_, scale_;  // scale_: [6 group]; the others in sixteens
};

}  // namespace springnet::layers
