// The shape of a body from its table: a lattice, a mesh file, or listed nodes and springs.
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
  Mesh mesh;  // scaled, rotated and moved
  EdgeOptions edges{};
  bool is_cloud = false;  // points, and lines between near ones
};
// The keys of body.mesh with a file, or with points. Notes name the body.
[[nodiscard]] MeshBody read_mesh_body(const Table& mesh, const std::string& body, const Files& files,
                                      std::vector<std::string>& notes);

// The key start: a mesh with the start positions of the nodes, by number. Empty without the key. Throws Error(input) if
// its number of points differs.
[[nodiscard]] std::vector<Vector3> read_start(const Table& mesh, std::size_t count, const Files& files);

// The keys nodes and springs as points, and lines in the order of the springs.
[[nodiscard]] Mesh read_listed(const Table& body);

// Adds a body with the nodes, faces and groups of a mesh and with these masses; springs along `edges`, edge i with
// material `materials[i]`, or all with materials[0]. Calls begin_body and end_body.
void add_mesh_body(const std::string& name, const Mesh& mesh, const std::vector<Edge>& edges, const Node& prototype,
                   const std::vector<double>& masses, const std::vector<MaterialIndex>& materials, Network& network,
                   std::vector<std::string>& notes);

}  // namespace springnet::scene
