// Faces under loads, and the following pressures on them.
//
// A pressure p on a triangle (a, b, c) with area vector A = (b - a) x (c - a) / 2 exerts -p A / 3 on each of its nodes:
// with linear shape functions a uniform pressure is shared equally. It follows the triangle, so it has derivatives:
//   -dF/da = p/6 [c - b]x,  -dF/db = p/6 [a - c]x,  -dF/dc = p/6 [b - a]x,   for the force F on any of the three.
// Their sum over a closed surface under one pressure is symmetric (the potential is p V); otherwise it is not.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <springnet/network.hpp>

#include "layers/block.hpp"
#include "layers/kernels.hpp"

namespace springnet::layers {

class LoadedFaces {
 public:
  // A face under a following pressure seen from one of its nodes: the triangle (node, next, last).
  struct NodeFace {
    std::uint32_t next, last;
    std::uint32_t load;  // index into Network::loads()
  };

  // engine: [user's node]
  LoadedFaces(const Network& network, const std::vector<std::uint32_t>& engine);

  // Faces of all loads, load by load; removed ones included.
  [[nodiscard]] std::size_t count() const noexcept { return corners_.size(); }
  [[nodiscard]] bool alive(std::size_t face) const noexcept { return alive_[face] != 0; }
  [[nodiscard]] std::size_t first_of(std::size_t load) const noexcept { return first_[load]; }
  [[nodiscard]] const std::array<std::uint32_t, 3>& corners(std::size_t face) const noexcept { return corners_[face]; }
  [[nodiscard]] std::uint32_t load_of(std::size_t face) const noexcept { return load_[face]; }

  // Whether any live face is under a following pressure.
  [[nodiscard]] bool any_following() const noexcept { return following_count_ > 0; }
  // Live ones at a node, by number.
  [[nodiscard]] std::span<const NodeFace> faces_at(std::uint32_t node) const noexcept {
    if (following_count_ == 0) return {};
    return {node_faces_.data() + start_[node], node_faces_.data() + start_[node + 1]};
  }
  // Force of all following pressures on a node, N. pressure: [load] Pa.
  [[nodiscard]] Vector3 force(std::uint32_t node, const NodeArrays& nodes, const double* pressure) const noexcept;
  // -dF/dp of that force with respect to the node's own position, N/m.
  [[nodiscard]] Block stiffness(std::uint32_t node, const NodeArrays& nodes, const double* pressure) const noexcept;
  // Whether that stiffness vanishes at every state: the faces of each load close around the node.
  [[nodiscard]] bool is_surrounded(std::uint32_t node) const noexcept;
  // -dF/dp of one face's force on the node, with respect to the positions of the node itself, `next` and `last`, N/m.
  [[nodiscard]] static std::array<Block, 3> blocks(std::uint32_t node, const NodeFace& face, const NodeArrays& nodes,
                                                   double pressure) noexcept;
  // Appends the nodes that share a face under a following pressure with a node; they may repeat.
  void add_neighbours(std::uint32_t node, std::vector<std::uint32_t>& neighbours) const;

  // Live faces one of whose sides is among these pairs of nodes. By number, each once.
  [[nodiscard]] std::vector<std::size_t> broken_by(
      const std::vector<std::pair<std::uint32_t, std::uint32_t>>& springs) const;
  // Live faces with a side for which crosses(node, node) is true.
  template <class Crosses>
  [[nodiscard]] std::vector<std::size_t> crossed_by(const Crosses& crosses) const {
    std::vector<std::size_t> found;
    for (std::size_t f = 0; f < count(); ++f) {
      const auto& [a, b, c] = corners_[f];
      if (alive(f) && (crosses(a, b) || crosses(b, c) || crosses(c, a))) found.push_back(f);
    }
    return found;
  }
  // Returns those that were live.
  std::vector<std::size_t> remove(const std::vector<std::size_t>& faces);
  void put_back_all() {
    alive_.assign(alive_.size(), 1);
    build();
  }

 private:
  void build();

  std::vector<std::array<std::uint32_t, 3>> corners_;  // [face]
  std::vector<std::uint32_t> load_;                    // [face]
  std::vector<std::uint8_t> alive_;                    // [face]
  std::vector<std::size_t> first_;                     // [load]
  std::vector<std::uint8_t> follows_;                  // [load]
  std::size_t node_count_ = 0;
  std::size_t following_count_ = 0;
  std::vector<std::size_t> start_;  // [node + 1], empty where no pressure follows
  std::vector<NodeFace> node_faces_;
};

}  // namespace springnet::layers
