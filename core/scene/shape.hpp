// What a body is made of, as its table says it: a lattice, a mesh file, or nodes and springs one by one.
#pragma once

#include <springnet/mesh.hpp>

#include "scene/parts.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {

// The keys axis and angle.
[[nodiscard]] Eigen::Matrix3d read_rotation(const Table& rotation);

// The keys of body.mesh with a lattice.
[[nodiscard]] Lattice read_lattice(const Table& mesh);

[[nodiscard]] EdgeOptions edge_options(Diagonals diagonals);

struct MeshBody {
  Mesh mesh;  // scaled, turned and moved
  EdgeOptions edges;
};
// The keys of body.mesh with a file. Notes name the body.
[[nodiscard]] MeshBody read_mesh_body(const Table& mesh, const std::string& body, const Files& files,
                                      std::vector<std::string>& notes);

// The key start: another mesh with the places where the nodes begin, by number. Nothing without the key; throws
// Error(input) if it has another number of points.
[[nodiscard]] std::vector<Vector3> read_start(const Table& mesh, std::size_t count, const Files& files);

// The keys nodes and springs as points, and lines in the order of the springs.
[[nodiscard]] Mesh read_listed(const Table& body);

// Nodes, springs, faces and groups of a mesh body, of given masses; springs along `edges`, of material `materials[i]`,
// or all of materials[0]. The body is begun and ended.
void add_mesh_body(const std::string& name, const Mesh& mesh, const std::vector<Edge>& edges, const Node& prototype,
                   const std::vector<double>& masses, const std::vector<MaterialIndex>& materials, Network& network,
                   std::vector<std::string>& notes);

}  // namespace springnet::scene
