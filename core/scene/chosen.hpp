// Triangles and solid cells selected by nodes and groups.
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

// A selection: its nodes, and the triangles and solid cells whose nodes are all selected. If it names groups, triangles
// and cells must also belong to the cells of one of them; for a group without such cells (points, or cells of another
// dimension) all of their nodes must be in it.
class Chosen {
 public:
  Chosen(const Value& selection, const Network& network, const std::vector<Shape>& shapes);

  [[nodiscard]] const std::vector<bool>& nodes() const { return nodes_; }
  [[nodiscard]] bool by_groups() const { return !groups_.empty(); }
  [[nodiscard]] bool has_triangle(const Face& face) const;
  // Whether a tetrahedron, part of a body's solid cell, is selected.
  [[nodiscard]] bool has_part(std::size_t body, std::size_t cell, const std::array<NodeIndex, 4>& nodes) const;
  // The selected faces of all bodies.
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
