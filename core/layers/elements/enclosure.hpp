// A closed surface of triangles and the volume that it encloses. ("Surface" alone means that of an obstacle.)
//
// V is linear in the position of each single node, V' = dV/dt in its position and velocity. V = 1/3 sum_k (p_k - o) .
// g_k (Euler's theorem for degree 3; any origin o, because the gradients g_k = dV/dp_k add up to zero).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <springnet/network.hpp>

#include "layers/block.hpp"
#include "layers/kernels.hpp"

namespace springnet::layers {

class Enclosure {
 public:
  // A directed edge from a node: the triangle (node, other, left) is on its left, (other, node, right) on its right.
  struct Spoke {
    std::uint32_t other, left, right;
  };
  struct Values {
    double volume = 0.0;  // m^3
    double rate = 0.0;    // m^3/s
  };

  // triangles: three nodes each, every edge twice, once in each direction.
  explicit Enclosure(const std::vector<std::uint32_t>& triangles);

  // In rising order, each once. The index of a node in this list is its place.
  [[nodiscard]] const std::vector<std::uint32_t>& nodes() const noexcept { return nodes_; }
  [[nodiscard]] std::size_t size() const noexcept { return nodes_.size(); }
  [[nodiscard]] std::span<const Spoke> spokes(std::size_t place) const noexcept {
    return {spokes_.data() + start_[place], spokes_.data() + start_[place + 1]};
  }
  // Whether the nodes are joined by a side of a triangle.
  [[nodiscard]] bool has_side(std::uint32_t first, std::uint32_t second) const noexcept;

  // g = dV/dp of a node, m^2; does not depend on the node's own position.
  [[nodiscard]] Vector3 gradient(std::size_t place, const NodeArrays& nodes) const noexcept;
  // dV'/dp of a node, m^2/s; does not depend on the node's own velocity.
  [[nodiscard]] Vector3 rate_gradient(std::size_t place, const NodeArrays& nodes) const noexcept;
  // The vector a, in m, with d2V/(dp dp_other) x = a x x; the block of the other end is its transpose, -[a]x.
  [[nodiscard]] static Vector3 across(const Spoke& spoke, const NodeArrays& nodes) noexcept;

  // Contributions of places [begin, end) to V and V'. Writes their gradients, by place, if `gradients` is not null.
  [[nodiscard]] Values partial_values(std::size_t begin, std::size_t end, const NodeArrays& nodes,
                                      Vector3* gradients) const noexcept;
  [[nodiscard]] Values values(const NodeArrays& nodes) const noexcept;

 private:
  std::vector<std::uint32_t> nodes_;
  std::vector<std::uint32_t> start_;
  std::vector<Spoke> spokes_;
};

// Places are summed in chunks of this size, so that sums have the same bits for every number of threads.
inline constexpr std::size_t enclosure_chunk = 256;

}  // namespace springnet::layers
