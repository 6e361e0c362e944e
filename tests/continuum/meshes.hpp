// Irregular meshes of tetrahedra and triangles, and nets of elements on them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include <Eigen/Dense>

#include "nets.hpp"

namespace springnet::testing {

using Matrix3 = Eigen::Matrix3d;

inline double random_unit(std::mt19937& random) { return 2.0 * (static_cast<double>(random()) * 0x1p-32) - 1.0; }
inline Vector3 random_vector(std::mt19937& random) {
  const double x = random_unit(random), y = random_unit(random), z = random_unit(random);
  return {x, y, z};
}
inline Matrix3 random_matrix(std::mt19937& random) {
  Matrix3 m;
  for (Eigen::Index c = 0; c < 3; ++c) m.col(c) = random_vector(random);
  return m;
}
inline Matrix3 random_rotation(std::mt19937& random) {
  const Vector3 axis = random_vector(random).normalized();
  return Eigen::AngleAxisd(3.0 * random_unit(random), axis).toRotationMatrix();
}

// Simplices with N corners; of solids tetrahedra with a volume above 0.
template <std::size_t N>
struct SimplexMesh {
  std::vector<Vector3> points;
  std::vector<std::array<NodeIndex, N>> cells;
  std::vector<bool> inside;  // [point] not on the boundary

  // Area vectors of a third each of the faces at a node of a solid's boundary, outward; of a sheet's in the plane z = 0
  // half of each boundary edge, times its outward normal in the plane.
  [[nodiscard]] std::vector<Vector3> boundary_areas() const {
    std::vector<Vector3> areas(points.size(), Vector3::Zero());
    for (const auto& cell : cells) {
      // Over a cell's own boundary each corner has minus the area vector of the opposite face, over N - 1; those of
      // inner faces cancel for the sum over cells of (all corners of each face).
      for (std::size_t k = 0; k < N; ++k) {
        Vector3 area = Vector3::Zero();  // of the face opposite to k, outward
        if constexpr (N == 4) {
          std::array<NodeIndex, 3> face{};
          for (std::size_t i = 0, at = 0; i < 4; ++i)
            if (i != k) face[at++] = cell[i];
          area = 0.5 * (points[face[1]] - points[face[0]]).cross(points[face[2]] - points[face[0]]);
          if (area.dot(points[face[0]] - points[cell[k]]) < 0.0) area = -area;
        } else {
          const Vector3 &a = points[cell[(k + 1) % 3]], &b = points[cell[(k + 2) % 3]];
          area = (b - a).cross(Vector3::UnitZ());
          if (area.dot(a - points[cell[k]]) < 0.0) area = -area;
        }
        for (std::size_t i = 0; i < N; ++i)
          if (i != k) areas[cell[i]] += area / (static_cast<double>(N) - 1.0);
      }
    }
    return areas;
  }
  // m^3, or m^2
  [[nodiscard]] double size() const {
    double sum = 0.0;
    for (const auto& cell : cells) {
      const Vector3 u = points[cell[1]] - points[cell[0]], v = points[cell[2]] - points[cell[0]];
      if constexpr (N == 4)
        sum += u.cross(v).dot(points[cell[3]] - points[cell[0]]) / 6.0;
      else
        sum += 0.5 * u.cross(v).norm();
    }
    return sum;
  }
};

// A box of n^3 cells in six tetrahedra each; inner points are moved at random.
inline SimplexMesh<4> solid_mesh(std::uint32_t n, const Vector3& size, unsigned seed) {
  std::mt19937 random(seed);
  SimplexMesh<4> mesh;
  const auto at = [n](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return static_cast<NodeIndex>(i + (n + 1) * (j + (n + 1) * k));
  };
  const auto inner = [n](std::uint32_t i) { return i > 0 && i < n; };
  for (std::uint32_t k = 0; k <= n; ++k)
    for (std::uint32_t j = 0; j <= n; ++j)
      for (std::uint32_t i = 0; i <= n; ++i) {
        Vector3 p = Vector3(i, j, k) / n;
        mesh.inside.push_back(inner(i) && inner(j) && inner(k));
        if (mesh.inside.back()) p += 0.2 / n * random_vector(random);
        mesh.points.push_back(p.cwiseProduct(size));
      }
  for (std::uint32_t k = 0; k < n; ++k)
    for (std::uint32_t j = 0; j < n; ++j)
      for (std::uint32_t i = 0; i < n; ++i) {
        std::array<std::size_t, 3> axes{0, 1, 2};
        do {
          std::array<std::uint32_t, 3> place{i, j, k};
          std::array<NodeIndex, 4> cell{at(i, j, k)};
          for (std::size_t step = 0; step < 3; ++step) {
            ++place[axes[step]];
            cell[step + 1] = at(place[0], place[1], place[2]);
          }
          const auto& p = mesh.points;
          if ((p[cell[1]] - p[cell[0]]).cross(p[cell[2]] - p[cell[0]]).dot(p[cell[3]] - p[cell[0]]) < 0.0)
            std::swap(cell[1], cell[2]);
          mesh.cells.push_back(cell);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  return mesh;
}

// A rectangle in the plane z = 0 of n^2 cells in two triangles each; inner points are moved at random in the plane.
inline SimplexMesh<3> sheet_mesh(std::uint32_t n, double width, double height, unsigned seed) {
  std::mt19937 random(seed);
  SimplexMesh<3> mesh;
  const auto at = [n](std::uint32_t i, std::uint32_t j) { return static_cast<NodeIndex>(i + (n + 1) * j); };
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) {
      Vector3 p(static_cast<double>(i) / n, static_cast<double>(j) / n, 0.0);
      mesh.inside.push_back(i > 0 && i < n && j > 0 && j < n);
      if (mesh.inside.back()) p += 0.2 / n * Vector3(random_unit(random), random_unit(random), 0.0);
      mesh.points.emplace_back(p.x() * width, p.y() * height, 0.0);
    }
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      mesh.cells.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.cells.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

// Nodes of 1 kg at the mesh's points, and elements at rest there; `turned` by a rotation and a shift if the material's
// positions at rest are given in other axes.
template <std::size_t N>
Network element_net(const SimplexMesh<N>& mesh, const Material& material, const Vector3& direction = Vector3::Zero(),
                    const Matrix3& turned = Matrix3::Identity(), const Vector3& shifted = Vector3::Zero()) {
  Network net;
  for (const Vector3& p : mesh.points) net.add_node(point(p));
  const MaterialIndex index = net.add_material(material);
  for (const auto& cell : mesh.cells) {
    std::vector<Vector3> rest;
    for (const NodeIndex node : cell) rest.push_back(turned * mesh.points[node] + shifted);
    net.add_element(N == 4 ? Invariant::tetrahedron : Invariant::triangle, {cell.begin(), cell.end()}, index,
                    std::move(rest), turned * direction);
  }
  return net;
}

// The inner edges of a mesh of triangles: a, b, and the tips of the triangles on its two sides, as hinges want them.
inline std::vector<std::array<NodeIndex, 4>> hinges_of(const SimplexMesh<3>& mesh) {
  std::map<std::pair<NodeIndex, NodeIndex>, NodeIndex> tip;
  for (const auto& cell : mesh.cells)
    for (std::size_t k = 0; k < 3; ++k) tip[{cell[k], cell[(k + 1) % 3]}] = cell[(k + 2) % 3];
  std::vector<std::array<NodeIndex, 4>> hinges;
  for (const auto& [edge, c] : tip) {
    const auto other = tip.find({edge.second, edge.first});
    if (edge.first < edge.second && other != tip.end()) hinges.push_back({edge.first, edge.second, c, other->second});
  }
  return hinges;
}

}  // namespace springnet::testing
