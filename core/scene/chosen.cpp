#include "scene/chosen.hpp"

#include <algorithm>

namespace springnet::scene {
namespace {

template <std::size_t Count>
bool all_inside(const std::array<NodeIndex, Count>& nodes, const std::vector<bool>& inside) {
  return std::all_of(nodes.begin(), nodes.end(), [&](NodeIndex node) { return inside[node]; });
}

}  // namespace

Chosen::Chosen(const Value& selection, const Network& network, const std::vector<Shape>& shapes)
    : nodes_(network.nodes().size(), false), groups_(select_groups(selection, network)) {
  for (const NodeIndex node : select_nodes(selection, network)) nodes_[node] = true;
  if (groups_.empty()) return;
  by_nodes_[0] = by_nodes_[1] = std::vector<bool>(nodes_.size(), false);
  solids_.resize(shapes.size());
  for (const auto& [body, group] : groups_) {
    std::array<bool, 2> has_cells{};  // triangles or quadrilaterals, solid cells
    const Body& owner = network.bodies()[body];
    if (const auto* mesh = std::get_if<Mesh>(&shapes[body])) {
      for (const std::uint32_t cell : mesh->groups[group].cells) {
        const int dimension = dimension_of(mesh->types[cell]);
        if (dimension < 2) continue;
        has_cells[static_cast<std::size_t>(dimension - 2)] = true;
        if (dimension == 2) {
          add_triangles(mesh->cell(cell), owner.first_node);
        } else {
          solids_[body].insert(cell);
        }
      }
    }
    for (const NodeIndex node : owner.groups[group].nodes) {
      for (std::size_t kind = 0; kind < 2; ++kind) {
        if (!has_cells[kind]) by_nodes_[kind][node] = nodes_[node];
      }
    }
  }
}

bool Chosen::has_triangle(const Face& face) const {
  if (!all_inside(face, nodes_)) return false;
  return groups_.empty() || triangles_.contains(meshes::face_key(face)) || all_inside(face, by_nodes_[0]);
}

bool Chosen::has_part(std::size_t body, std::size_t cell, const std::array<NodeIndex, 4>& nodes) const {
  if (!all_inside(nodes, nodes_)) return false;
  return groups_.empty() || solids_[body].contains(cell) || all_inside(nodes, by_nodes_[1]);
}

std::vector<Face> Chosen::triangles(const Network& network) const {
  std::vector<Face> found;
  std::copy_if(network.faces().begin(), network.faces().end(), std::back_inserter(found),
               [this](const Face& face) { return has_triangle(face); });
  return found;
}

// A quadrilateral may be divided along either diagonal: adds all four triangles of three of its corners.
void Chosen::add_triangles(std::span<const std::uint32_t> cell, NodeIndex first) {
  for (std::size_t left_out = 0; left_out < (cell.size() == 4 ? 4U : 1U); ++left_out) {
    std::vector<std::uint32_t> corners;
    for (std::size_t k = 0; k < cell.size(); ++k) {
      if (cell.size() == 3 || k != left_out) corners.push_back(first + cell[k]);
    }
    triangles_.insert(meshes::face_key(corners));
  }
}

}  // namespace springnet::scene
