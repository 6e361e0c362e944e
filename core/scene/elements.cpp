#include <algorithm>
#include <array>
#include <map>
#include <set>

#include <fmt/format.h>

#include <springnet/material.hpp>
#include <springnet/mesh.hpp>

#include "mesh/cells.hpp"
#include "mesh/coordinates.hpp"
#include "network/spacing.hpp"
#include "scene/chosen.hpp"
#include "scene/component.hpp"
#include "scene/lists.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"
#include "scene/time_table.hpp"
#include "scene/value_tables.hpp"

namespace springnet::scene {
namespace {

using NodeLists = std::vector<std::vector<NodeIndex>>;

// An angle at each node that has exactly two springs to different nodes, all three inside: lower neighbour, node, upper
// neighbour.
NodeLists find_angles(const Network& network, const std::vector<bool>& inside) {
  std::vector<std::vector<NodeIndex>> neighbours(network.nodes().size());
  const auto add = [&](NodeIndex node, NodeIndex other) {
    if (inside[node] && neighbours[node].size() < 3) neighbours[node].push_back(other);
  };
  for (const Spring& spring : network.springs()) {
    add(spring.first, spring.second);
    add(spring.second, spring.first);
  }
  NodeLists angles;
  for (NodeIndex node = 0; node < neighbours.size(); ++node) {
    const std::vector<NodeIndex>& ends = neighbours[node];
    if (ends.size() != 2 || ends[0] == ends[1]) continue;
    angles.push_back({std::min(ends[0], ends[1]), node, std::max(ends[0], ends[1])});
  }
  return angles;
}

NodeLists find_hinges(const Network& network, const Chosen& chosen) {
  NodeLists hinges;
  for (const Body& body : network.bodies()) {
    const auto first = network.faces().begin() + static_cast<std::ptrdiff_t>(body.first_face);
    const std::vector<Face> faces(first, first + static_cast<std::ptrdiff_t>(body.face_count));
    for (const auto& hinge : hinges_of(faces)) {
      const auto& [from, to, left, right] = hinge;
      if (!chosen.has_triangle({from, to, left}) || !chosen.has_triangle({to, from, right})) continue;
      hinges.emplace_back(hinge.begin(), hinge.end());
    }
  }
  return hinges;
}

NodeLists find_triangles(const Network& network, const Chosen& chosen) {
  NodeLists triangles;
  for (const Face& face : chosen.triangles(network)) triangles.emplace_back(face.begin(), face.end());
  return triangles;
}

NodeLists find_tetrahedra(const Network& network, const Chosen& chosen, const std::vector<Shape>& shapes,
                          bool conforming) {
  NodeLists tetrahedra;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const NodeIndex first = network.bodies()[k].first_node;
    const auto add = [&](const Mesh& mesh) {
      for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
        for (std::array<std::uint32_t, 4> nodes :
             conforming ? conforming_tetrahedra_of(mesh, cell) : tetrahedra_of(mesh, cell)) {
          for (NodeIndex& node : nodes) node += first;
          if (chosen.has_part(k, cell, nodes)) tetrahedra.emplace_back(nodes.begin(), nodes.end());
        }
      }
    };
    if (const auto* mesh = std::get_if<Mesh>(&shapes[k])) add(*mesh);
    if (const auto* lattice = std::get_if<Lattice>(&shapes[k])) add(mesh_of(*lattice));
  }
  return tetrahedra;
}

// All selected triangles as one closed surface, oriented outward.
NodeLists find_surface(const Value& selection, const Network& network, const Chosen& chosen) {
  std::vector<NodeIndex> surface;
  std::set<Edge> edges;  // directed
  for (const std::vector<NodeIndex>& face : find_triangles(network, chosen)) {
    for (std::size_t k = 0; k < 3; ++k) edges.emplace(face[k], face[(k + 1) % 3]);
    surface.insert(surface.end(), face.begin(), face.end());
  }
  if (surface.empty()) return {};
  for (const auto& [from, to] : edges) {
    if (edges.contains({to, from})) continue;
    selection.fail(fmt::format(
        "the surface of these nodes is open at the edge from {} to {} (nodes {} and {}); select all of a closed "
        "surface, or repair the mesh there",
        meshes::text(network.nodes()[from].position), meshes::text(network.nodes()[to].position), from, to));
  }
  // The wall of a cavity in a solid is oriented into the cavity: reverse it.
  if (network.value_of({Invariant::enclosed_volume, surface, 0, 0.0}) < 0) std::reverse(surface.begin(), surface.end());
  return {surface};
}

// Number of parts of a surface without common nodes.
std::size_t count_parts(const std::vector<NodeIndex>& triangles) {
  std::map<NodeIndex, NodeIndex> parent;
  for (const NodeIndex node : triangles) parent.emplace(node, node);
  const auto root = [&](NodeIndex node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  for (std::size_t k = 0; k < triangles.size(); k += 3) {
    parent[root(triangles[k])] = root(triangles[k + 1]);
    parent[root(triangles[k + 1])] = root(triangles[k + 2]);
  }
  std::set<NodeIndex> roots;
  for (const auto& [node, up] : parent) roots.insert(root(node));
  return roots.size();
}

NodeLists find_elements(const Value& selection, Invariant invariant, const Network& network,
                        const std::vector<Shape>& shapes) {
  const Chosen chosen(selection, network, shapes);
  NodeLists found;
  std::string_view what;
  switch (invariant) {
    case Invariant::angle:
    case Invariant::chain:
      found = find_angles(network, chosen.nodes());
      what = "has no node with exactly two springs";
      break;
    case Invariant::dihedral:
    case Invariant::hinge:
      found = find_hinges(network, chosen);
      what = "has no two triangles with a common edge among the faces of a body";
      break;
    case Invariant::area:
    case Invariant::triangle:
      found = find_triangles(network, chosen);
      what = "has no triangle among the faces of a body";
      break;
    case Invariant::volume:
    case Invariant::tetrahedron:
      found = find_tetrahedra(network, chosen, shapes, reads_several(invariant));
      what = "has no solid cell of a mesh";
      break;
    case Invariant::enclosed_volume:
      found = find_surface(selection, network, chosen);
      what = "has no triangle among the faces of a body";
      break;
  }
  if (found.empty()) {
    selection.fail(
        fmt::format("{}, all of whose nodes are selected{}; select more, or list the elements one by one with 'nodes'",
                    what, chosen.by_groups() ? " and that is in one of the groups named" : ""));
  }
  return found;
}

NodeLists read_lists(const Value& lists, const Table& table, const Network& network) {
  const Body* body = nullptr;
  if (const auto name = table.find("body")) body = &find_body(*name, network);
  NodeLists result;
  for (const Value& list : lists.elements()) {
    result.emplace_back();
    for (const Value& number : list.elements()) result.back().push_back(read_node(number, body, network));
  }
  if (result.empty()) lists.fail("lists no element; give the nodes of one or more, as [[0, 1, 2], [1, 2, 3]]");
  return result;
}

// Lengths at rest are those of the present times a factor, or between the places at rest, if there are any.
void add_several(Network& network, Invariant shape, const std::vector<NodeIndex>& nodes, MaterialIndex material,
                 double factor, const Vector3& direction, const std::vector<Value>& places) {
  std::vector<Vector3> rest;
  for (const Value& place : places) rest.push_back(place.vector());
  const Vector3& origin = network.nodes()[nodes[0]].position;
  for (const NodeIndex node : places.empty() ? nodes : std::vector<NodeIndex>())
    rest.push_back(factor == 1.0 ? network.nodes()[node].position
                                 : Vector3(origin + factor * (network.nodes()[node].position - origin)));
  network.add_element(shape, nodes, material, std::move(rest), direction);
}

void read_element(const Table& table, const PluginHost& plugins, const Files& files, const std::vector<Shape>& shapes,
                  std::set<std::string>& names, Scene& scene) {
  Network& network = scene.network;
  const auto name = table.find("name");
  if (name && !names.insert(name->text()).second) name->fail("another [[element]] has this name; names are unique");
  const auto invariant = static_cast<Invariant>(table.need("invariant")
                                                    .choice({"angle", "dihedral", "area", "volume", "enclosed_volume",
                                                             "chain", "triangle", "hinge", "tetrahedron"}));
  const Material material = read_material(table, plugins, files, invariant);
  if (!material.spring && !material.viscosity) {
    table.fail("neither 'spring' nor 'viscosity' says what the elements do; add spring = { type = …, … }");
  }
  const ElementCheck check(material, plugins);
  const auto selection = table.find("select");
  const auto lists = table.find("nodes");
  if (selection && lists) table.fail("has both 'select' and 'nodes'; leave one out");
  if (!selection && !lists) table.fail("has no nodes; add 'select', or 'nodes' as [[0, 1, 2], [1, 2, 3]]");
  if (selection && table.has("body")) {
    table.find("body")->fail("requires 'nodes'; write select = { body = … } instead");
  }
  const auto reference = table.find("reference");
  const auto scale = table.find("reference_scale");
  if (reference && scale) scale->fail("cannot be combined with 'reference'; remove one of them");
  std::optional<double> given;
  if (reference) given = reference->number();
  const double factor = scale ? scale->number() : 1.0;
  const bool several = reads_several(invariant);
  if (several && reference)
    reference->fail(
        fmt::format("has no meaning for a {}, whose laws have a reference value for each scalar; write "
                    "reference_scale, a factor on lengths at rest",
                    name_of(invariant)));
  if (several && scale && !(factor > 0.0)) scale->fail("must be above 0, a factor on lengths at rest");
  const auto direction = table.find("direction");
  if (direction && !several)
    direction->fail(fmt::format("has no meaning for {}; it is for laws over several scalars that read a direction",
                                name_of(invariant)));
  if (direction && !check.reads_direction())
    direction->fail("has no meaning for these laws, which are the same in all directions; remove it");
  const Vector3 along = direction ? direction->vector() : Vector3::Zero();

  const std::array<std::optional<Value>, 3> own{table.find("references"), table.find("rests"),
                                                table.find("directions")};
  if (own[0]) refuse_beside(table, {"reference", "reference_scale", "select"}, "references");
  if (own[1]) refuse_beside(table, {"reference_scale", "select"}, "rests");
  if (own[2]) refuse_beside(table, {"direction", "select"}, "directions");
  if (own[0] && several) own[0]->fail("has no meaning for laws over several scalars; write 'rests'");
  for (const auto& each : {own[1], own[2]})
    if (each && !several) each->fail(fmt::format("has no meaning for {}", name_of(invariant)));
  if (own[2] && !check.reads_direction())
    own[2]->fail("has no meaning for these laws, which are the same in all directions; remove it");

  const NodeLists elements =
      lists ? read_lists(*lists, table, network) : find_elements(*selection, invariant, network, shapes);
  const MaterialIndex index = network.add_material(material);
  ElementValues values;
  const auto table_of_values = table.find("values");
  if (table_of_values) values = read_element_values(*table_of_values, plugins, files, elements.size(), index, network);
  const auto first = static_cast<ElementIndex>(network.elements().size());
  const std::vector<Value> places = lists ? lists->elements() : std::vector<Value>();
  const std::vector<double> references =
      own[0] ? numbers_for(*own[0], elements.size(), "element") : std::vector<double>();
  for (const auto& each : {own[1], own[2]})
    if (each) static_cast<void>(each->elements(elements.size()));
  for (std::size_t k = 0; k < elements.size(); ++k) {
    const Value& place = lists ? places[k] : *selection;
    const auto number = static_cast<ElementIndex>(network.elements().size());
    const MaterialIndex own_material = table_of_values ? values.materials[k] : index;
    const std::optional<double> own_reference = table_of_values ? values.references[k] : std::nullopt;
    if (several && own_reference)
      table_of_values->fail(
          fmt::format("column '{}' has no meaning for a {}, which has a reference value for each scalar",
                      reference_column, name_of(invariant)));
    place.at_this_place([&] {
      if (several) {
        add_several(network, invariant, elements[k], own_material, factor, own[2] ? own[2]->element(k).vector() : along,
                    own[1] ? own[1]->element(k).elements(elements[k].size()) : std::vector<Value>());
        return;
      }
      const std::optional<double> listed = own[0] ? std::optional<double>(references[k]) : given;
      const ElementIndex element =
          network.add_element(invariant, elements[k], own_material, own_reference ? own_reference : listed);
      if (scale && !own_reference) network.set_reference(element, factor * network.elements()[element].reference);
    });
    check(place, network, number);
  }
  (lists ? *lists : *selection).at_this_place([&] {
    check_spacing(network, {network.springs().size(), first, network.rigids().size()});
  });
  if (selection && invariant == Invariant::enclosed_volume && elements.size() == 1) {
    const std::size_t parts = count_parts(elements[0]);
    if (parts > 1) {
      scene.notes.push_back(fmt::format(
          "Element {} encloses {} closed surfaces that do not touch, as one volume with one pressure; where each is a "
          "filling of its own, give each an [[element]].",
          first, parts));
    }
  }
  scene.elements.push_back({name ? name->text() : "", first, static_cast<ElementIndex>(elements.size())});
}

}  // namespace

void read_elements(const Table& root, const PluginHost& plugins, const Files& files, const std::vector<Shape>& shapes,
                   Scene& scene) {
  std::set<std::string> names;
  for (const Value& value : root.tables("element")) {
    read_element(value.table("element"), plugins, files, shapes, names, scene);
  }
}

}  // namespace springnet::scene
