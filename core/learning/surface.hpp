// The surface of a net that moves, and which of its points are nearest to others.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <springnet/network.hpp>

namespace springnet::learning {

// The faces of each body; of bodies that have none, and of nodes outside of bodies, the nodes themselves. They are in a
// tree of boxes, which is made once, by where they are at the start, and whose boxes follow the motion.
class Surface {
 public:
  explicit Surface(const Network& network);

  // m, [3][node].
  void move(const Eigen::Matrix3Xd& positions);

  struct Nearest {
    std::array<NodeIndex, 3> nodes{};
    Vector3 weights = Vector3::Zero();  // of the nodes; the sum is 1
    Vector3 point = Vector3::Zero();    // m
    // Onto the directions in which the point only moves if its nodes do: normal to the face, normal to the edge, or all
    // of them at a corner. Along the others the nearest point slides on the surface.
    Eigen::Matrix3d normal = Eigen::Matrix3d::Identity();
  };
  // Of several that are equally near, on the face with the lowest number.
  [[nodiscard]] Nearest nearest(const Vector3& point) const;

 private:
  struct Box {
    Vector3 least, greatest;
    std::uint32_t first, count;  // of `parts_`; 0: no leaf
    std::uint32_t second;        // child; the first one is next to the box
  };
  void build(std::uint32_t first, std::uint32_t count, const std::vector<Vector3>& middles);
  [[nodiscard]] Nearest nearest_of(std::uint32_t part, const Vector3& point) const;

  std::vector<std::array<NodeIndex, 3>> faces_;  // three times the same: a node
  std::vector<std::uint32_t> parts_;             // numbers of faces, in the order of the tree
  std::vector<Box> boxes_;
  Eigen::Matrix3Xd positions_;  // m
};

}  // namespace springnet::learning
