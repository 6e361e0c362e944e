// Surfaces for tests and measurements of contact: nodes, triangles, and what moves them.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <springnet/network_lists.hpp>

#include "proximity/primitives.hpp"

namespace springnet::proximity {

struct Surfaces {
  std::array<std::vector<double>, 3> x;  // m
  std::vector<Triangle> triangles;

  NodeIndex add(const Vector3& at) {
    for (std::size_t k = 0; k < 3; ++k) x[k].push_back(at[static_cast<Eigen::Index>(k)]);
    return static_cast<NodeIndex>(x[0].size() - 1);
  }
  [[nodiscard]] Positions positions() const { return {{x[0].data(), x[1].data(), x[2].data()}, x[0].size()}; }
  void set(NodeIndex node, const Vector3& at) {
    for (std::size_t k = 0; k < 3; ++k) x[k][node] = at[static_cast<Eigen::Index>(k)];
  }
  // Balls at all corners, and all edges.
  [[nodiscard]] PrimitiveLists lists(std::vector<CheckedGroups> checked) const {
    return {corners_of(triangles), edges_of(triangles), triangles, std::move(checked), {}};
  }
};

// A block of nodes_a_side^3 nodes, `spacing` (m) apart, whose faces are the surface: squares of two triangles.
inline void add_block(Surfaces& surfaces, int nodes_a_side, double spacing, const Vector3& origin, double radius,
                      Group group) {
  const int n = nodes_a_side;
  const auto first = static_cast<NodeIndex>(surfaces.x[0].size());
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) surfaces.add(origin + spacing * Vector3(i, j, k));
  const auto square = [&](const std::array<int, 3>& at, std::size_t u, std::size_t v) {
    const auto node = [&](int along_u, int along_v) {
      std::array<int, 3> place = at;
      place[u] += along_u;
      place[v] += along_v;
      return first + static_cast<NodeIndex>(place[0] + n * (place[1] + n * place[2]));
    };
    surfaces.triangles.push_back({{node(0, 0), node(1, 0), node(1, 1)}, radius, group});
    surfaces.triangles.push_back({{node(0, 0), node(1, 1), node(0, 1)}, radius, group});
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int side : {0, n - 1})
      for (int v = 0; v + 1 < n; ++v)
        for (int u = 0; u + 1 < n; ++u) {
          std::array<int, 3> at{};
          at[axis] = side;
          at[(axis + 1) % 3] = u;
          at[(axis + 2) % 3] = v;
          square(at, (axis + 1) % 3, (axis + 2) % 3);
        }
}

// A sheet of nodes_a_side^2 nodes, `spacing` (m) apart along it, in a zigzag: folds after every `columns`, whose layers
// open by `opening` (m) each column.
inline void add_folded_sheet(Surfaces& surfaces, int nodes_a_side, double spacing, int columns, double opening,
                             const Vector3& origin, double radius, Group group) {
  const int n = nodes_a_side;
  const auto first = static_cast<NodeIndex>(surfaces.x[0].size());
  const double rise = std::sqrt(spacing * spacing - opening * opening);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int place = i % (2 * columns), height = place < columns ? place : 2 * columns - place;
      surfaces.add(origin + Vector3(i * opening, j * spacing, height * rise));
    }
  const auto node = [&](int i, int j) { return first + static_cast<NodeIndex>(i + n * j); };
  for (int j = 0; j + 1 < n; ++j)
    for (int i = 0; i + 1 < n; ++i) {
      surfaces.triangles.push_back({{node(i, j), node(i + 1, j), node(i + 1, j + 1)}, radius, group});
      surfaces.triangles.push_back({{node(i, j), node(i + 1, j + 1), node(i, j + 1)}, radius, group});
    }
}

}  // namespace springnet::proximity
