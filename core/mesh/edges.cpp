#include <algorithm>

#include <springnet/mesh.hpp>

namespace springnet {

std::vector<Edge> edges_of(const Mesh& mesh, const EdgeOptions& options) {
  std::vector<Edge> edges;
  for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
    const auto corners = mesh.cell(cell);
    const auto add = [&](std::span<const std::array<std::uint8_t, 2>> places) {
      for (const auto& [from, to] : places) edges.push_back(std::minmax<std::uint32_t>(corners[from], corners[to]));
    };
    const CellType type = mesh.types[cell];
    add(edge_places(type));
    if (options.face_diagonals) add(face_diagonal_places(type));
    if (options.space_diagonals) add(space_diagonal_places(type));
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace springnet
