#include <algorithm>
#include <set>

#include <fmt/format.h>

#include <springnet/material.hpp>

#include "network/checks.hpp"
#include "network/spacing.hpp"
#include "scene/component.hpp"
#include "scene/lists.hpp"
#include "scene/material.hpp"
#include "scene/parts.hpp"
#include "scene/shape.hpp"
#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

const char* const needs_a_law =
    "has springs, but none of 'spring', 'viscosity' and 'material' says what they are made of; add spring = { type = "
    "…, … }";

// Includes the mass, unless it follows from a density.
Node read_prototype(const Table& body, const PluginHost& plugins, const Files& files, Network& network) {
  Node node;
  const Table neuron = body.need("neuron").open_table("body.neuron");
  const LawUse use = read_component(neuron, "type", ComponentKind::neuron, plugins, files);
  const auto mass = neuron.find("mass");
  if (mass && body.has("density")) {
    mass->fail("cannot be combined with 'density', which gives the masses; remove one of them");
  }
  for (const char* key : {"masses", "mass"})
    if (mass && body.has(key))
      mass->fail(fmt::format("cannot be combined with '{}' of the body; remove one of them", key));
  if (mass) {
    node.mass = mass->number_above_0("kg");
  } else if (!body.has("density") && !body.has("masses") && !body.has("mass")) {
    neuron.fail(
        fmt::format("has no mass; add 'mass' here, in kg, of each node, or to the body 'mass', in kg, of all of it{}",
                    is_cloud(body) ? "" : ", or 'density', in kg/m^3, which gives masses from its cells"));
  }
  node.neuron = network.add_neuron(use);
  if (const auto velocity = body.find("velocity")) node.velocity = velocity->vector();
  return node;
}

// A value that is computed on first use.
template <class Result, class Make>
auto lazily(Make make) {
  return [make, made = std::make_shared<std::optional<Result>>()]() -> const Result& {
    if (!*made) *made = make();
    return **made;
  };
}

struct BodyReader {
  const Table& body;
  std::string name;
  const PluginHost& plugins;
  const Files& files;
  Scene& scene;
  Network& network = scene.network;
  std::vector<std::string>& notes = scene.notes;

  // Sets the material of each spring of the last body to that of its edge.
  void set_materials(const std::vector<Edge>& edges, const std::vector<MaterialIndex>& materials) const {
    const Body& added = network.bodies().back();
    for (SpringIndex i = added.first_spring; i < added.first_spring + added.spring_count; ++i) {
      const Spring& spring = network.springs()[i];
      const Edge edge = std::minmax(spring.first - added.first_node, spring.second - added.first_node);
      const auto found = std::lower_bound(edges.begin(), edges.end(), edge);
      network.set_spring_material(i, materials[static_cast<std::size_t>(found - edges.begin())]);
    }
  }

  void set_masses(const std::vector<double>& masses) const {
    const NodeIndex first = network.bodies().back().first_node;
    for (std::size_t k = 0; k < masses.size(); ++k) {
      Node node = network.nodes()[first + k];
      node.mass = masses[k];
      network.set_node(first + static_cast<NodeIndex>(k), node);
    }
  }

  Shape read_lattice_body(const Table& mesh) {
    const Lattice lattice = read_lattice(mesh);
    mesh.value().at_this_place(
        [&] { checks::check_lattice(name, lattice, network.nodes().size(), network.springs().size()); });
    const auto cells = lazily<Mesh>([&] { return mesh_of(lattice); });
    const auto edges = lazily<std::vector<Edge>>([&] { return edges_of(cells(), edge_options(lattice.diagonals)); });
    const Node prototype = read_prototype(body, plugins, files, network);
    const std::vector<double> masses = read_masses(body, cells);
    if (const auto elements = read_element_material(body, plugins, files, network)) {
      if (lattice.diagonals != Diagonals::none)
        mesh.need("diagonals").fail("has no meaning without springs; remove it");
      mesh.value().at_this_place([&] { add_mesh_body(name, cells(), {}, prototype, masses, {}, network, notes); });
      add_body_elements(body, *elements, cells(), plugins, scene);
      return lattice;
    }
    const std::vector<MaterialIndex> materials = read_materials(body, cells, edges, plugins, files, network, notes);
    const bool one_node = lattice.nodes == std::array<std::uint32_t, 3>{1, 1, 1};
    if (materials.empty() && !one_node) body.fail(needs_a_law);
    files.tell("building the lattice", std::size_t{lattice.nodes[0]} * lattice.nodes[1] * lattice.nodes[2]);
    mesh.value().at_this_place([&] {
      if (!materials.empty()) {
        network.add_lattice(name, lattice, prototype, materials.front());
        return;
      }
      Node node = prototype;
      node.position = lattice.origin;
      network.begin_body(name);
      network.add_node(node);
      network.end_body();
    });
    if (materials.size() > 1) set_materials(edges(), materials);
    set_masses(masses);
    return lattice;
  }

  Shape read_file_body(const Table& table) {
    MeshBody read = read_mesh_body(table, name, files, notes);
    const Mesh& mesh = read.mesh;
    files.tell("finding the edges of the mesh", mesh.cell_count());
    const std::vector<Edge> edges = edges_of(mesh, read.edges);
    const auto cells = [&]() -> const Mesh& { return mesh; };
    const auto springs = [&]() -> const std::vector<Edge>& { return edges; };
    const Node prototype = read_prototype(body, plugins, files, network);
    if (read.is_cloud && body.has("density"))
      body.find("density")->fail("points have no volume; give the body's 'mass' in kg in its place");
    if (read.is_cloud && body.has("material") && !body.has("cross_section"))
      body.need("material")
          .fail(
              "a cloud of points has springs, but no cells from which their stiffness follows; add to the body "
              "'cross_section', in m^2, of each spring, or 'spring' with a stiffness in place of 'material'");
    const std::vector<double> masses = read_masses(body, cells);
    if (const auto elements = read_element_material(body, plugins, files, network)) {
      table.value().at_this_place([&] { add_mesh_body(name, mesh, {}, prototype, masses, {}, network, notes); });
      files.tell("adding elements", mesh.cell_count());
      add_body_elements(body, *elements, mesh, plugins, scene);
      return std::move(read.mesh);
    }
    const std::vector<MaterialIndex> materials = read_materials(body, cells, springs, plugins, files, network, notes);
    if (materials.empty() && !edges.empty()) body.fail(needs_a_law);
    files.tell(fmt::format("adding {} springs", grouped(edges.size())), edges.size());
    table.value().at_this_place(
        [&] { add_mesh_body(name, mesh, edges, prototype, masses, materials, network, notes); });
    return std::move(read.mesh);
  }

  void read_listed_body() {
    const Mesh mesh = read_listed(body);
    const std::vector<Edge> edges = edges_of(mesh);
    if (body.has("material") && edges.size() < mesh.cell_count()) {
      body.find("springs")->fail(
          "joins two nodes twice, so that their stiffness from 'material' is ambiguous; remove one");
    }
    const auto cells = [&]() -> const Mesh& { return mesh; };
    const auto sorted_edges = [&]() -> const std::vector<Edge>& { return edges; };
    const Node prototype = read_prototype(body, plugins, files, network);
    const std::vector<double> masses = read_masses(body, cells);
    if (read_element_material(body, plugins, files, network))
      body.find("material")->fail("is for cells, and a body of nodes and springs has none; use a mesh");
    const std::vector<MaterialIndex> materials =
        read_materials(body, cells, sorted_edges, plugins, files, network, notes);
    if (materials.empty() && mesh.cell_count() > 0) body.fail(needs_a_law);

    network.begin_body(name);
    const auto first = static_cast<NodeIndex>(network.nodes().size());
    const std::vector<Value> places = body.need("nodes").elements();
    Node node = prototype;
    for (std::size_t k = 0; k < mesh.points.size(); ++k) {
      node.position = mesh.points[k];
      places[k].at_this_place([&] { network.add_node(node); });
    }
    for (std::size_t c = 0; c < mesh.cell_count(); ++c) {
      body.find("springs")->at_this_place(
          [&] { network.add_spring(first + mesh.cell(c)[0], first + mesh.cell(c)[1], materials.front()); });
    }
    read_own_lists(body, network);
    network.end_body();
    if (materials.size() > 1) set_materials(edges, materials);
    set_masses(masses);
  }

  Shape read() {
    const bool has_mesh = body.has("mesh"), has_nodes = body.has("nodes");
    if (has_mesh && has_nodes) body.fail("has both 'mesh' and 'nodes'; leave one out");
    if (!has_mesh && !has_nodes) {
      body.fail(
          "has no nodes; add mesh = { lattice = [4, 4, 4], spacing = 1.0 }, mesh = { file = … }, mesh = { points = …, "
          "radius = … } or 'nodes'");
    }
    if (has_mesh && body.has("springs")) body.find("springs")->fail("a mesh has springs of its own; remove this key");
    for (const char* key : {"rest_lengths", "masses", "velocities", "faces", "groups"})
      if (has_mesh && body.has(key)) body.find(key)->fail("is for bodies of listed 'nodes'; a mesh has its own");
    if (!has_mesh) {
      read_listed_body();
      return {};
    }
    const Table mesh = body.need("mesh").table("body.mesh");
    for (const auto& [one, other] :
         {std::pair("file", "lattice"), std::pair("points", "lattice"), std::pair("points", "file")})
      if (mesh.has(one) && mesh.has(other)) mesh.fail(fmt::format("has both '{}' and '{}'; leave one out", one, other));
    return mesh.has("file") || mesh.has("points") ? read_file_body(mesh) : read_lattice_body(mesh);
  }
};

// The value that determines the body's position.
Value placed_by(const Table& body) {
  if (body.has("nodes")) return body.need("nodes");
  const Table mesh = body.need("mesh").table("body.mesh");
  return mesh.has("origin") ? mesh.need("origin") : mesh.value();
}

void scale_rest_lengths(const Value& scale, Network& network) {
  const double factor = scale.number_above_0("");
  const Body& added = network.bodies().back();
  for (SpringIndex i = added.first_spring; i < added.first_spring + added.spring_count; ++i) {
    scale.at_this_place([&] { network.set_rest_length(i, factor * network.springs()[i].rest_length); });
  }
}

}  // namespace

std::vector<Shape> read_bodies(const Table& root, const PluginHost& plugins, const Files& files, Scene& scene) {
  Network& network = scene.network;
  std::vector<Shape> shapes;
  std::set<std::string> names;
  for (const Value& value : root.tables("body")) {
    const Table body = value.table("body");
    const Value name = body.need("name");
    if (!names.insert(name.text()).second) name.fail("another body has this name; names are unique");
    const Checked before{.springs = network.springs().size()};
    shapes.push_back(
        BodyReader{.body = body, .name = name.text(), .plugins = plugins, .files = files, .scene = scene}.read());
    placed_by(body).at_this_place([&] { check_spacing(network, before); });
    // A sheet is as thick in contact as it is.
    const auto of_surface = body.find("surface_thickness"), of_sheet = body.find("thickness");
    const auto radius = body.find("radius");
    const double thickness = of_surface ? of_surface->number_from_0("m") : of_sheet ? of_sheet->number_above_0("m") : 0;
    network.set_extent(network.bodies().size() - 1, thickness, radius ? radius->number_from_0("m") : 0.0);
    if (const auto scale = body.find("rest_length_scale")) scale_rest_lengths(*scale, network);
  }
  if (network.nodes().empty()) root.fail("the scene has no body; add a [[body]]");
  return shapes;
}

void read_starts(const Table& root, const Files& files, Network& network) {
  std::size_t index = 0;
  for (const Value& value : root.tables("body")) {
    const Body& body = network.bodies()[index++];
    const auto mesh = value.table("body").find("mesh");
    if (!mesh) continue;
    const Table table = mesh->table("body.mesh");
    const std::vector<Vector3> places = read_start(table, body.node_count, files);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const auto number = body.first_node + static_cast<NodeIndex>(k);
      Node node = network.nodes()[number];
      node.position = places[k];
      table.need("start").at_this_place([&] { network.set_node(number, node); });
    }
    if (!places.empty()) table.need("start").at_this_place([&] { check_spacing(network, {body.first_spring}); });
  }
}

}  // namespace springnet::scene
