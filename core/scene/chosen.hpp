// Triangles and solid cells that a selection of nodes and groups takes.
#pragma once

#include <array>
#include <set>
#include <span>
#include <unordered_set>
#include <vector>

#include <springnet/network.hpp>

#include "mesh/cells.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"

namespace springnet::scene {

// What a selection takes: its nodes; of triangles and solid cells those with all nodes selected and, where it names
// groups, in the cells of one of them. Of a group without such cells (a group of points, or of cells of another
// dimension) those with all nodes in it.
class Chosen {
 public:
  Chosen(const Value& selection, const Network& network, const std::vector<Shape>& shapes);

  [[nodiscard]] const std::vector<bool>& nodes() const { return nodes_; }
  [[nodiscard]] bool by_groups() const { return !groups_.empty(); }
  [[nodiscard]] bool has_triangle(const Face& face) const;
  // Of a solid cell of a body, one of the tetrahedra that it divides into.
  [[nodiscard]] bool has_part(std::size_t body, std::size_t cell, const std::array<NodeIndex, 4>& nodes) const;
  // Of the faces of all bodies.
  [[nodiscard]] std::vector<Face> triangles(const Network& network) const;

 private:
  void add_triangles(std::span<const std::uint32_t> cell, NodeIndex first);

  std::vector<bool> nodes_;  // [node]
  std::vector<SelectedGroup> groups_;
  std::array<std::vector<bool>, 2> by_nodes_;  // [0 triangles, 1 solid cells][node] of groups without such cells
  std::set<meshes::FaceKey> triangles_;
  std::vector<std::unordered_set<std::size_t>> solids_;  // [body]
};

}  // namespace springnet::scene
