// A closed surface of triangles and the volume that it encloses. "Surface" alone means an obstacle's.
//
// V is linear in the position of each node alone, and so is V' = dV/dt in its position and velocity. V = 1/3 sum_k (p_k
// - o) . g_k (Euler, degree 3; any o, because the gradients g_k = dV/dp_k add up to zero).
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

  // Each once, rising. A node's number in here is its place.
  [[nodiscard]] const std::vector<std::uint32_t>& nodes() const noexcept { return nodes_; }
  [[nodiscard]] std::size_t size() const noexcept { return nodes_.size(); }
  [[nodiscard]] std::span<const Spoke> spokes(std::size_t place) const noexcept {
    return {spokes_.data() + start_[place], spokes_.data() + start_[place + 1]};
  }
  [[nodiscard]] std::size_t first_spoke(std::size_t place) const noexcept { return start_[place]; }
  [[nodiscard]] std::size_t spoke_count() const noexcept { return spokes_.size(); }
  // Whether a side of a triangle joins the two.
  [[nodiscard]] bool has_side(std::uint32_t first, std::uint32_t second) const noexcept;

  // g = dV/dp of a node: it does not depend on the node's own position. m^2
  [[nodiscard]] Vector3 gradient(std::size_t place, const NodeArrays& nodes) const noexcept;
  // dV'/dp of a node: it does not depend on the node's own velocity. m^2/s
  [[nodiscard]] Vector3 rate_gradient(std::size_t place, const NodeArrays& nodes) const noexcept;
  // d2V/dp dp_other x is this vector times x; the transposed block of the other end is its negative. m
  [[nodiscard]] static Vector3 across(const Spoke& spoke, const NodeArrays& nodes) noexcept;

  // Shares of places [begin, end) in V and V'; their gradients where `gradients` is not null.
  [[nodiscard]] Values share(std::size_t begin, std::size_t end, const NodeArrays& nodes,
                             Vector3* gradients) const noexcept;
  [[nodiscard]] Values values(const NodeArrays& nodes) const noexcept;

 private:
  std::vector<std::uint32_t> nodes_;
  std::vector<std::uint32_t> start_;
  std::vector<Spoke> spokes_;
};

// Places of an enclosure that are summed together: sums have the same bits for every number of threads.
inline constexpr std::size_t enclosure_chunk = 256;

}  // namespace springnet::layers
