// Bodies, connections, rigid connections, and what differs within a body.
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "network/checks.hpp"
#include "scene/value_tables.hpp"
#include "scene/writing.hpp"

namespace springnet::scene {
namespace {

using namespace toml_text;

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorKind::input, "a scene cannot say this: " + what); }

std::vector<Block> blocks_of(const Network& network) {
  std::vector<Block> blocks;
  std::set<std::string> names;
  for (const Body& body : network.bodies()) names.insert(body.name);
  NodeIndex next = 0;
  const auto fill = [&](NodeIndex until) {
    if (next == until) return;
    std::string name = "nodes";
    for (int k = 2; !names.insert(name).second; ++k) name = fmt::format("nodes {}", k);
    blocks.push_back({name, next, until - next, 0, 0, 0, 0, nullptr});
  };
  for (const Body& body : network.bodies()) {
    fill(body.first_node);
    next = body.first_node + body.node_count;
    if (body.node_count == 0) refuse(fmt::format("body '{}' has no nodes", body.name));
    if (body.name.empty()) refuse("a body without a name");
    blocks.push_back({body.name, body.first_node, body.node_count, body.first_spring, body.spring_count,
                      body.first_face, body.face_count, &body});
  }
  fill(static_cast<NodeIndex>(network.nodes().size()));
  return blocks;
}

// The number of the first spring that is written as a connection, as all after it: it is of no body, joins other nodes
// than those of its body, or nodes at the same place.
SpringIndex first_connection(const Network& network, std::vector<Block>& blocks) {
  SpringIndex next = 0;
  for (Block& block : blocks) {
    if (block.spring_count == 0) continue;
    if (block.first_spring != next) block.spring_count = 0;
    const SpringIndex end = block.first_spring + block.spring_count;
    for (; next < end; ++next) {
      const Spring spring = network.springs()[next];
      const auto inside = [&](NodeIndex k) { return k >= block.first_node && k - block.first_node < block.node_count; };
      if (!inside(spring.first) || !inside(spring.second) ||
          network.nodes().positions()[spring.first] == network.nodes().positions()[spring.second])
        break;
    }
    if (next == end && block.spring_count > 0) continue;
    if (block.spring_count > 0) block.spring_count = next - block.first_spring;
    for (Block* later = &block + 1; later < blocks.data() + blocks.size(); ++later) later->spring_count = 0;
    break;
  }
  return next;
}

// Faces lie in the order of the bodies; those of none are given to the body that has their corners.
void give_faces(const Network& network, std::vector<Block>& blocks) {
  std::size_t at = 0;
  for (Block& block : blocks) block.first_face = block.face_count = 0;
  for (std::size_t f = 0; f < network.faces().size(); ++f) {
    const auto inside = [&](const Block& block) {
      const Face& face = network.faces()[f];
      return std::all_of(face.begin(), face.end(),
                         [&](NodeIndex k) { return k >= block.first_node && k - block.first_node < block.node_count; });
    };
    while (at < blocks.size() && !inside(blocks[at])) ++at;
    if (at == blocks.size())
      refuse(fmt::format("face {} has nodes of two bodies, or follows a face of a later body", f));
    if (blocks[at].face_count++ == 0) blocks[at].first_face = f;
  }
}

// In the order of the first of each list.
std::vector<std::pair<std::uint32_t, std::vector<std::uint32_t>>> by_first(
    const std::map<std::uint32_t, std::vector<std::uint32_t>>& lists) {
  std::vector<std::pair<std::uint32_t, std::vector<std::uint32_t>>> sorted(lists.begin(), lists.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const auto& a, const auto& b) { return a.second.front() < b.second.front(); });
  return sorted;
}

double distance_of(const Network& network, NodeIndex first, NodeIndex second) {
  return checks::distance(network.nodes().positions()[first], network.nodes().positions()[second]);
}

void write_springs(const Network& network, const Block& block, const PluginHost& plugins, Document& out) {
  if (block.spring_count == 0) return;
  std::vector<double> lengths;
  bool own_lengths = false;
  for (SpringIndex k = block.first_spring; k < block.first_spring + block.spring_count; ++k) {
    const Spring spring = network.springs()[k];
    lengths.push_back(spring.rest_length);
    own_lengths = own_lengths || !same_bits(spring.rest_length, distance_of(network, spring.first, spring.second));
  }
  out.add("springs", list(block.spring_count, [&](std::size_t k) {
            const Spring spring = network.springs()[block.first_spring + k];
            return fmt::format("[{}, {}]", spring.first - block.first_node, spring.second - block.first_node);
          }));
  if (own_lengths) out.add("rest_lengths", numbers(lengths));
  write_material(network.materials()[network.springs()[block.first_spring].material], plugins, false, out);
}

void write_nodes(const Network& network, const Block& block, const PluginHost& plugins, Document& out) {
  const NodeList& nodes = network.nodes();
  const Node first = nodes[block.first_node];
  const auto each = [&](std::size_t k) { return nodes[block.first_node + k]; };
  out.add("nodes", list(block.node_count, [&](std::size_t k) { return vector(each(k).position); }));
  bool same_mass = true, same_velocity = true;
  for (std::size_t k = 0; k < block.node_count; ++k) {
    same_mass = same_mass && same_bits(each(k).mass, first.mass);
    same_velocity = same_velocity && same_bits(each(k).velocity, first.velocity);
  }
  out.add("neuron", text_of(network.neurons()[first.neuron], ComponentKind::neuron, plugins, "type",
                            same_mass ? std::optional<double>(first.mass) : std::nullopt));
  if (!same_mass) out.add("masses", list(block.node_count, [&](std::size_t k) { return number(each(k).mass); }));
  if (!same_velocity)
    out.add("velocities", list(block.node_count, [&](std::size_t k) { return vector(each(k).velocity); }));
  else if (!same_bits(first.velocity, Vector3::Zero()))
    out.add("velocity", vector(first.velocity));
}

// The connections that are written as one, beginning with this one.
SpringIndex end_of_connection(const Network& network, SpringIndex first, const ValueFiles& values) {
  const SpringList& springs = network.springs();
  const MaterialIndex group = values.group_of(springs[first].material);
  SpringIndex end = first;
  while (end < springs.size() && values.group_of(springs[end].material) == group) ++end;
  return end;
}

void write_connections(const Network& network, SpringIndex first, const PluginHost& plugins, const ValueFiles& values,
                       Document& out) {
  const SpringList& springs = network.springs();
  while (first < springs.size()) {
    const SpringIndex end = end_of_connection(network, first, values);
    bool own_lengths = false;
    for (SpringIndex k = first; k < end; ++k)
      own_lengths =
          own_lengths || !same_bits(springs[k].rest_length, distance_of(network, springs[k].first, springs[k].second));
    out.begin("[[connect]]");
    out.add("pairs", list(end - first, [&](std::size_t k) {
              const Spring spring = springs[first + k];
              return fmt::format("[{{ node = {} }}, {{ node = {} }}]", spring.first, spring.second);
            }));
    if (own_lengths)
      out.add("rest_lengths", list(end - first, [&](std::size_t k) { return number(springs[first + k].rest_length); }));
    write_material(network.materials()[springs[first].material], plugins, false, out);
    first = end;
  }
}

void write_rigids(const Network& network, Document& out) {
  const std::vector<Rigid>& rigids = network.rigids();
  if (rigids.empty()) return;
  out.begin("[[rigid]]");
  out.add("pairs", list(rigids.size(), [&](std::size_t k) {
            return fmt::format("[{{ node = {} }}, {{ node = {} }}]", rigids[k].first, rigids[k].second);
          }));
  out.add("lengths", list(rigids.size(), [&](std::size_t k) { return number(rigids[k].length); }));
}

}  // namespace

void write_bodies(const Network& network, const PluginHost& plugins, const ValueFiles& values, Document& out) {
  std::vector<Block> blocks = blocks_of(network);
  const SpringIndex connections = first_connection(network, blocks);
  give_faces(network, blocks);
  for (const Block& block : blocks) {
    out.begin("[[body]]");
    out.add("name", in_quotes(block.name));
    write_nodes(network, block, plugins, out);
    write_springs(network, block, plugins, out);
    if (block.face_count > 0)
      out.add("faces", list(block.face_count, [&](std::size_t k) {
                const Face& face = network.faces()[block.first_face + k];
                return fmt::format("[{}, {}, {}]", face[0] - block.first_node, face[1] - block.first_node,
                                   face[2] - block.first_node);
              }));
    if (block.body != nullptr && block.body->thickness > 0.0)
      out.add("surface_thickness", number(block.body->thickness));
    if (block.body != nullptr && block.body->radius > 0.0) out.add("radius", number(block.body->radius));
    if (block.body == nullptr || block.body->groups.empty()) continue;
    out.add("groups", list(block.body->groups.size(), [&](std::size_t k) {
              const NodeGroup& group = block.body->groups[k];
              const std::string nodes = list(
                  group.nodes.size(), [&](std::size_t i) { return std::to_string(group.nodes[i] - block.first_node); });
              return Inline().add("name", in_quotes(group.name)).add("nodes", nodes).text();
            }));
  }
  write_connections(network, connections, plugins, values, out);
  write_rigids(network, out);
}

void write_node_changes(const Network& network, const PluginHost& plugins, ValueFiles& values, Document& out) {
  std::vector<Block> blocks = blocks_of(network);
  const SpringList& springs = network.springs();
  const SpringIndex connections = first_connection(network, blocks);
  std::map<std::uint32_t, std::vector<NodeIndex>> neurons;
  std::map<MaterialIndex, std::vector<SpringIndex>> materials;  // by their groups
  std::vector<MaterialIndex> written(springs.size());           // [spring]
  std::vector<NodeIndex> fixed;
  for (const Block& block : blocks) {
    for (NodeIndex k = block.first_node; k < block.first_node + block.node_count; ++k) {
      const Node node = network.nodes()[k];
      if (node.neuron != network.nodes()[block.first_node].neuron) neurons[node.neuron].push_back(k);
      if (node.fixed) fixed.push_back(k);
    }
    for (SpringIndex s = block.first_spring; s < block.first_spring + block.spring_count; ++s) {
      written[s] = springs[block.first_spring].material;
      if (const MaterialIndex own = values.group_of(springs[s].material); own != values.group_of(written[s]))
        materials[own].push_back(s);
    }
  }
  for (SpringIndex first = connections; first < springs.size();) {
    const SpringIndex end = end_of_connection(network, first, values);
    std::fill(written.begin() + first, written.begin() + end, springs[first].material);
    first = end;
  }
  const auto select = [&](const char* what, const std::string& numbers) {
    out.add("select", Inline().add(what, numbers).text());
  };
  for (const auto& [neuron, nodes] : by_first(neurons)) {
    out.begin("[[node]]");
    select("nodes", whole_numbers(nodes));
    out.add("neuron", text_of(network.neurons()[neuron], ComponentKind::neuron, plugins));
  }
  for (const auto& [group, members] : by_first(materials)) {
    const MaterialIndex first = springs[members.front()].material;
    out.begin("[[spring]]");
    select("springs", whole_numbers(members));
    write_material(network.materials()[first], plugins, true, out);
    for (const SpringIndex s : members) written[s] = first;
  }
  std::map<MaterialIndex, std::vector<ValueFiles::Row>> rows;  // by their groups
  for (SpringIndex s = 0; s < springs.size(); ++s)
    if (const MaterialIndex own = springs[s].material; own != written[s])
      rows[values.group_of(own)].push_back({s, written[s], own});
  for (const auto& [group, of_group] : rows) {
    out.begin("[[spring]]");
    out.add("values", in_quotes(values.add(spring_column, of_group)));
  }
  // Those that a [[move]] moves are fixed by it.
  std::vector<NodeIndex> moved;
  for (const Move& move : network.moves()) moved.insert(moved.end(), move.nodes.begin(), move.nodes.end());
  std::sort(moved.begin(), moved.end());
  std::erase_if(fixed, [&](NodeIndex k) { return std::binary_search(moved.begin(), moved.end(), k); });
  if (fixed.empty()) return;
  out.begin("[[fix]]");
  select("nodes", whole_numbers(fixed));
}

}  // namespace springnet::scene
