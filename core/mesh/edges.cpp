#include <algorithm>

#include <springnet/mesh.hpp>

#include "mesh/by_point.hpp"

namespace springnet {

std::vector<Edge> edges_of(const Mesh& mesh, const EdgeOptions& options) {
  // The upper points by the lower ones; an edge occurs once for each of its cells.
  meshes::ByPoint<std::uint32_t> upper(mesh.points.size(), [&](const auto& add) {
    for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
      const auto corners = mesh.cell(cell);
      const auto add_all = [&](std::span<const std::array<std::uint8_t, 2>> places) {
        for (const auto& [from, to] : places)
          add(std::min(corners[from], corners[to]), std::max(corners[from], corners[to]));
      };
      const CellType type = mesh.types[cell];
      add_all(edge_places(type));
      if (options.face_diagonals) add_all(face_diagonal_places(type));
      if (options.space_diagonals) add_all(space_diagonal_places(type));
    }
  });
  const auto points = static_cast<std::int64_t>(upper.points());
  std::vector<std::size_t> start(upper.points() + 1, 0);
#pragma omp parallel for schedule(dynamic, 4096) if (points > 10000)
  for (std::int64_t p = 0; p < points; ++p) {
    const std::span<std::uint32_t> others = upper.of(static_cast<std::size_t>(p));
    std::sort(others.begin(), others.end());
    start[static_cast<std::size_t>(p) + 1] =
        static_cast<std::size_t>(std::unique(others.begin(), others.end()) - others.begin());
  }
  for (std::size_t p = 0; p < upper.points(); ++p) start[p + 1] += start[p];
  std::vector<Edge> edges;
  reserve_huge(edges, start.back());
  for (std::size_t p = 0; p < upper.points(); ++p)
    for (const std::uint32_t other : upper.of(p).first(start[p + 1] - start[p]))
      edges.emplace_back(static_cast<std::uint32_t>(p), other);
  return edges;
}

}  // namespace springnet
