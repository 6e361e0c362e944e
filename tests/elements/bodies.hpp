// Bodies with elements, and invariants by other formulas than the library's.
#pragma once

#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "nets.hpp"

namespace springnet::testing {

// q by a formula that has little to do with the engine's.
inline double plain_invariant(Invariant invariant, const std::vector<Vector3>& p) {
  switch (invariant) {
    case Invariant::angle:
      return std::acos((p[0] - p[1]).normalized().dot((p[2] - p[1]).normalized()));
    case Invariant::dihedral: {
      // The angle by which the plane of the second triangle is turned about the edge against that of the first.
      const Vector3 edge = (p[1] - p[0]).normalized();
      const auto tip = [&](const Vector3& t) { return Vector3((t - p[0]) - edge.dot(t - p[0]) * edge).normalized(); };
      const Vector3 c = tip(p[2]), d = -tip(p[3]);
      return std::asin(edge.dot(c.cross(d)));  // up to a right angle
    }
    case Invariant::area: {
      const double a = (p[1] - p[2]).norm(), b = (p[2] - p[0]).norm(), c = (p[0] - p[1]).norm();
      const double s = 0.5 * (a + b + c);
      return std::sqrt(s * (s - a) * (s - b) * (s - c));  // Heron
    }
    case Invariant::volume: {
      Eigen::Matrix4d rows;
      for (int i = 0; i < 4; ++i) rows.row(i) << p[static_cast<std::size_t>(i)].transpose(), 1.0;
      return -rows.determinant() / 6.0;
    }
    case Invariant::enclosed_volume: {
      // By the divergence theorem in z alone: sum of mean height times projected area.
      double sum = 0.0;
      for (std::size_t t = 0; t < p.size(); t += 3) {
        const Vector3 n = (p[t + 1] - p[t]).cross(p[t + 2] - p[t]);
        sum += (p[t].z() + p[t + 1].z() + p[t + 2].z()) / 3.0 * 0.5 * n.z();
      }
      return sum;
    }
    case Invariant::chain:  // of laws over several scalars: tests/continuum
    case Invariant::triangle:
    case Invariant::hinge:
    case Invariant::tetrahedron:
      break;
  }
  return 0.0;
}

struct TriangleMesh {
  std::vector<Vector3> points;
  std::vector<NodeIndex> triangles;  // three each, counterclockwise seen from outside
};

// A sphere about the origin: an icosahedron whose triangles are divided into four `levels` times; 10 4^levels + 2
// points.
inline TriangleMesh icosphere(int levels, double radius) {
  TriangleMesh mesh;
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  for (const auto& [x, y, z] : std::initializer_list<std::array<double, 3>>{{-1, g, 0},
                                                                            {1, g, 0},
                                                                            {-1, -g, 0},
                                                                            {1, -g, 0},
                                                                            {0, -1, g},
                                                                            {0, 1, g},
                                                                            {0, -1, -g},
                                                                            {0, 1, -g},
                                                                            {g, 0, -1},
                                                                            {g, 0, 1},
                                                                            {-g, 0, -1},
                                                                            {-g, 0, 1}})
    mesh.points.push_back(radius * Vector3(x, y, z).normalized());
  mesh.triangles = {0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4,  11, 10, 2,  10, 7, 6, 7, 1, 8,
                    3, 9,  4, 3, 4, 2, 3, 2, 6, 3, 6, 8,  3, 8,  9,  4, 9, 5, 2, 4,  11, 6,  2,  10, 8,  6, 7, 9, 8, 1};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<NodeIndex, NodeIndex>, NodeIndex> middle;
    std::vector<NodeIndex> finer;
    const auto between = [&](NodeIndex a, NodeIndex b) {
      const auto [entry, is_new] = middle.try_emplace(std::minmax(a, b), static_cast<NodeIndex>(mesh.points.size()));
      if (is_new) mesh.points.push_back(radius * (mesh.points[a] + mesh.points[b]).normalized());
      return entry->second;
    };
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
      const NodeIndex a = mesh.triangles[t], b = mesh.triangles[t + 1], c = mesh.triangles[t + 2];
      const NodeIndex ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca});
    }
    mesh.triangles = finer;
  }
  return mesh;
}

// The sides of the triangles, each once.
inline std::vector<std::pair<NodeIndex, NodeIndex>> sides(const TriangleMesh& mesh) {
  std::vector<std::pair<NodeIndex, NodeIndex>> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const NodeIndex a = mesh.triangles[t + k], b = mesh.triangles[t + (k + 1) % 3];
      if (a < b) found.emplace_back(a, b);
    }
  return found;
}

// A filled organ: springs on the sides, and a law on the enclosed volume; no damping where `damping` is 0.
inline Network filled(const TriangleMesh& mesh, double mass, double stiffness, double bulk, double damping) {
  Network net;
  for (const Vector3& p : mesh.points) net.add_node(point(p, mass));
  const MaterialIndex skin = net.add_material(damped(stiffness, damping));
  for (const auto& [a, b] : sides(mesh)) net.add_spring(a, b, skin);
  net.add_element(Invariant::enclosed_volume, mesh.triangles, net.add_material(damped(bulk, damping)));
  return net;
}

// Nodes about the origin at random with elements of all kinds, pre-stressed and damped, springs among them and a closed
// surface of their own: nothing in it is symmetric.
inline Network all_kinds(unsigned seed, bool damped_too = true, double scale = 1.0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Network net;
  for (int k = 0; k < 14; ++k) {
    net.add_node(point(scale * Vector3(unit(random), unit(random), unit(random)), 1.0 + 0.5 * unit(random),
                       {unit(random), unit(random), unit(random)}));
  }
  const TriangleMesh surface = icosphere(0, 1.3 * scale);
  for (const Vector3& p : surface.points)
    net.add_node(point(p + 0.2 * scale * Vector3(unit(random), unit(random), unit(random)), 1.0 + 0.5 * unit(random),
                       {unit(random), unit(random), unit(random)}));
  const auto material = [&](double stiffness, double damping) {
    Material m{LawUse{"nonlinear", {{"stiffness", stiffness}, {"cubic", 0.4 * stiffness}}}, std::nullopt};
    if (damped_too && damping > 0.0) m.viscosity = LawUse{"linear", {{"damping", damping}}};
    return net.add_material(m);
  };
  const MaterialIndex hard = material(2.0, 0.3), soft = material(0.7, 0.0), thick = material(1.1, 0.5);
  for (NodeIndex k = 0; k < 20; ++k) net.add_spring(k, k + 5, k % 3 == 0 ? hard : soft);
  for (NodeIndex k = 0; k + 4 < 14; k += 2) {
    const MaterialIndex m = k % 4 == 0 ? hard : thick;
    for (const Invariant invariant : {Invariant::angle, Invariant::area}) {
      const ElementIndex e = net.add_element(invariant, {k, k + 1, k + 3}, m);
      net.set_reference(e, 0.8 * net.elements()[e].reference);
    }
    for (const Invariant invariant : {Invariant::dihedral, Invariant::volume}) {
      const ElementIndex e = net.add_element(invariant, {k, k + 2, k + 1, k + 4}, k % 4 == 0 ? thick : soft);
      net.set_reference(e, net.elements()[e].reference + 0.2);
    }
  }
  std::vector<NodeIndex> triangles = surface.triangles;
  for (NodeIndex& node : triangles) node += 14;
  const ElementIndex filling = net.add_element(Invariant::enclosed_volume, triangles, thick);
  net.set_reference(filling, 1.2 * net.elements()[filling].reference);
  return net;
}

}  // namespace springnet::testing
