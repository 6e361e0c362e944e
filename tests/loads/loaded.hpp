// Surfaces under load.
#pragma once

#include <random>

#include "../elements/bodies.hpp"

namespace springnet::testing {

inline std::vector<Face> faces_of(const TriangleMesh& mesh) {
  std::vector<Face> faces;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    faces.push_back({mesh.triangles[t], mesh.triangles[t + 1], mesh.triangles[t + 2]});
  return faces;
}

inline Load pressed(const std::vector<Face>& faces, double pressure, bool follow) {
  Load load;
  load.faces = faces;
  load.pressure = pressure;
  load.follow = follow;
  return load;
}

// Points of a sphere, and its springs.
inline Network skin(const TriangleMesh& mesh, double mass, double stiffness, double damping) {
  Network net;
  for (const Vector3& p : mesh.points) net.add_node(point(p, mass));
  const MaterialIndex material = net.add_material(damped(stiffness, damping));
  for (const auto& [a, b] : sides(mesh)) net.add_spring(a, b, material);
  return net;
}

// A sphere with random displacements.
inline TriangleMesh crumpled(int levels, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-0.2, 0.2);
  TriangleMesh mesh = icosphere(levels, 1.0);
  for (Vector3& p : mesh.points)
    p = Vector3(1.5 * p[0], p[1], 0.6 * p[2]) + Vector3(unit(random), unit(random), unit(random));
  return mesh;
}

// -p A / 3 of each face on each of its nodes, with the area by Heron's formula and the normal by itself.
inline std::vector<Vector3> plain_pressure(const std::vector<Face>& faces, const std::vector<Vector3>& at, double p) {
  std::vector<Vector3> forces(at.size(), Vector3::Zero());
  for (const Face& face : faces) {
    const Vector3 u = at[face[1]] - at[face[0]], v = at[face[2]] - at[face[0]];
    const double a = u.norm(), b = v.norm(), c = (u - v).norm(), s = 0.5 * (a + b + c);
    const double area = std::sqrt(s * (s - a) * (s - b) * (s - c));
    for (const NodeIndex node : face) forces[node] -= p * area / 3.0 * u.cross(v).normalized();
  }
  return forces;
}

}  // namespace springnet::testing
