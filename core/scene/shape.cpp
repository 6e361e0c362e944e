#include "scene/shape.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "network/rotation.hpp"

namespace springnet::scene {
namespace {

constexpr std::int64_t default_neighbours = 30;

Diagonals read_diagonals(const Table& mesh) {
  const auto diagonals = mesh.find("diagonals");
  return diagonals ? static_cast<Diagonals>(diagonals->choice({"none", "face", "space", "all"})) : Diagonals::none;
}

void refuse(const Table& mesh, std::initializer_list<const char*> keys, std::string_view owner) {
  for (const char* key : keys) {
    if (mesh.has(key)) mesh.find(key)->fail(fmt::format("has no meaning with a {}; remove it", owner));
  }
}

// Transforms points p to origin + rotation (scale p).
void place(const Table& table, Mesh& mesh) {
  const auto scale = table.find("scale");
  const double factor = scale ? scale->number_above_0("") : 1.0;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  if (const auto rotation = table.find("rotation")) turn = read_rotation(rotation->table("body.mesh.rotation"));
  const auto origin = table.find("origin");
  const Vector3 move = origin ? origin->vector() : Vector3::Zero();
  if (!scale && !table.has("rotation") && !origin) return;
  for (Vector3& point : mesh.points) point = move + turn * (factor * point);
}

}  // namespace

Eigen::Matrix3d read_rotation(const Table& rotation) {
  const Vector3 axis = rotation.need("axis").direction();
  return rotation_about(axis, rotation.need("angle").number());
}

EdgeOptions edge_options(Diagonals diagonals) {
  return {.face_diagonals = diagonals == Diagonals::face || diagonals == Diagonals::all,
          .space_diagonals = diagonals == Diagonals::space || diagonals == Diagonals::all};
}

Lattice read_lattice(const Table& mesh) {
  refuse(mesh, {"scale", "rotation", "start", "radius", "neighbours"}, "lattice");
  Lattice lattice;
  const std::vector<Value> nodes = mesh.need("lattice").elements(3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    constexpr std::int64_t largest = std::numeric_limits<std::uint32_t>::max();
    lattice.nodes[axis] = static_cast<std::uint32_t>(nodes[axis].integer(1, largest));
  }
  const Value spacing = mesh.need("spacing");
  if (spacing.is_list()) {
    const std::vector<Value> spacings = spacing.elements(3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lattice.spacing[static_cast<Eigen::Index>(axis)] = spacings[axis].number_above_0("m");
    }
  } else {
    lattice.spacing.setConstant(spacing.number_above_0("m"));
  }
  if (const auto origin = mesh.find("origin")) lattice.origin = origin->vector();
  lattice.diagonals = read_diagonals(mesh);
  return lattice;
}

namespace {

// Points of a CSV table, or of a file with a mesh, in whose cells a cloud has no interest.
Mesh read_points_of(const Value& name, const Files& files) {
  const std::filesystem::path path = files.resolve(name);
  Mesh result;
  if (has_mesh_ending(path)) {
    Mesh read = name.at_this_place([&] { return read_points(path, files.loading); });
    result.points = std::move(read.points);
    result.notes = std::move(read.notes);
    return result;
  }
  const CsvColumns columns = files.csv_columns(name, {"x", "y", "z"});
  for (std::size_t row = 0; row < columns.lines.size(); ++row)
    result.points.emplace_back(columns.values[0][row], columns.values[1][row], columns.values[2][row]);
  if (result.points.empty()) name.fail("has no points; give a row x,y,z or more");
  return result;
}

// Points that no pair has, for a note.
std::size_t count_alone(std::size_t points, const std::vector<Edge>& pairs) {
  std::vector<bool> has_any(points);
  for (const Edge& pair : pairs) has_any[pair.first] = has_any[pair.second] = true;
  return static_cast<std::size_t>(std::count(has_any.begin(), has_any.end(), false));
}

MeshBody read_cloud(const Table& table, const std::string& body, const Files& files, std::vector<std::string>& notes) {
  refuse(table, {"spacing", "diagonals"}, "cloud of points");
  const Value radius = table.need("radius");
  const double within = radius.number_above_0("m");
  const std::int64_t most = table.has("neighbours") ? table.need("neighbours").integer(1) : default_neighbours;
  MeshBody result;
  result.is_cloud = true;
  result.mesh = read_points_of(table.need("points"), files);
  for (const std::string& note : result.mesh.notes) notes.push_back(fmt::format("Body '{}': {}", body, note));
  place(table, result.mesh);
  files.tell("finding the neighbours of points", result.mesh.points.size());
  const std::vector<Edge> pairs =
      radius.at_this_place([&] { return near_pairs(result.mesh.points, within, static_cast<std::size_t>(most)); });
  for (const auto& [first, second] : pairs) result.mesh.add_cell(CellType::line, std::array{first, second});
  if (const std::size_t alone = count_alone(result.mesh.points.size(), pairs); alone > 0)
    notes.push_back(fmt::format("Body '{}': {} of its {} points have no other within {:g} m, and so no spring.", body,
                                alone, result.mesh.points.size(), within));
  return result;
}

}  // namespace

MeshBody read_mesh_body(const Table& table, const std::string& body, const Files& files,
                        std::vector<std::string>& notes) {
  if (table.has("points")) return read_cloud(table, body, files, notes);
  refuse(table, {"spacing", "radius", "neighbours"}, "file");
  const Value file = table.need("file");
  const std::filesystem::path path = files.resolve(file);
  MeshBody result{file.at_this_place([&] { return read_mesh(path, files.loading); }),
                  edge_options(read_diagonals(table))};
  for (const std::string& note : result.mesh.notes) notes.push_back(fmt::format("Body '{}': {}", body, note));
  place(table, result.mesh);
  return result;
}

std::vector<Vector3> read_start(const Table& table, std::size_t count, const Files& files) {
  const auto start = table.find("start");
  if (!start) return {};
  const std::filesystem::path path = files.resolve(*start);
  Mesh mesh;
  if (table.has("points"))
    mesh = read_points_of(*start, files);
  else
    mesh = start->at_this_place([&] { return read_mesh(path, files.loading); });
  if (mesh.points.size() != count) {
    start->fail(fmt::format("has {} points, the body has {} nodes; give a mesh of the same points, in the same order",
                            mesh.points.size(), count));
  }
  place(table, mesh);
  return std::move(mesh.points);
}

Mesh read_listed(const Table& body) {
  Mesh mesh;
  const Value nodes = body.need("nodes");
  for (const Value& position : nodes.elements()) mesh.points.push_back(position.vector());
  if (mesh.points.empty()) nodes.fail("lists no node; give one position [x, y, z] or more");
  const auto springs = body.find("springs");
  if (!springs) return mesh;
  for (const Value& pair : springs->elements()) {
    const std::vector<Value> ends = pair.elements(2);
    std::array<std::uint32_t, 2> line{};
    for (std::size_t end = 0; end < 2; ++end) {
      const std::int64_t node = ends[end].integer(0);
      if (node >= static_cast<std::int64_t>(mesh.points.size())) {
        ends[end].fail(fmt::format("there is no node {}, the body has {}, numbered from 0", node, mesh.points.size()));
      }
      line[end] = static_cast<std::uint32_t>(node);
    }
    if (line[0] == line[1]) pair.fail("joins a node to itself; give two different nodes");
    if (mesh.points[line[0]] == mesh.points[line[1]]) {
      pair.fail("has length zero, both nodes are at the same place; move one, or leave the spring out");
    }
    mesh.add_cell(CellType::line, line);
  }
  return mesh;
}

namespace {

// A surface that branches or is one-sided keeps the file's orientation.
std::vector<Face> faces_of(const Mesh& mesh, const std::string& name, std::vector<std::string>& notes) {
  std::vector<Face> faces = surface_of(mesh);
  const bool solid = std::any_of(mesh.types.begin(), mesh.types.end(), [](CellType t) { return dimension_of(t) == 3; });
  if (solid || faces.empty()) return faces;
  try {
    return oriented(faces, mesh.points);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::input) throw;
    notes.push_back(fmt::format("Body '{}': its triangles keep the orientation of the file: {}.", name, error.what()));
    return faces;
  }
}

}  // namespace

void add_mesh_body(const std::string& name, const Mesh& mesh, const std::vector<Edge>& edges, const Node& prototype,
                   const std::vector<double>& masses, const std::vector<MaterialIndex>& materials, Network& network,
                   std::vector<std::string>& notes) {
  network.begin_body(name);
  const auto first = static_cast<NodeIndex>(network.nodes().size());
  network.reserve_nodes(first + mesh.points.size());
  network.reserve_springs(network.springs().size() + edges.size());
  Node node = prototype;
  for (std::size_t k = 0; k < mesh.points.size(); ++k) {
    node.position = mesh.points[k];
    if (!masses.empty()) node.mass = masses[k];
    network.add_node(node);
  }
  for (std::size_t k = 0; k < edges.size(); ++k) {
    network.add_spring(first + edges[k].first, first + edges[k].second, materials[materials.size() > 1 ? k : 0]);
  }
  for (const Face& face : faces_of(mesh, name, notes)) {
    network.add_face({first + face[0], first + face[1], first + face[2]});
  }
  for (const MeshGroup& group : mesh.groups) {
    std::vector<NodeIndex> nodes = group.points;
    for (NodeIndex& index : nodes) index += first;
    network.add_group(group.name, std::move(nodes));
  }
  network.end_body();
}

}  // namespace springnet::scene
