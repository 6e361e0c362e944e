#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "network/spacing.hpp"
#include "scene/component.hpp"
#include "scene/lists.hpp"
#include "scene/pairs.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"
#include "scene/time_table.hpp"
#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

// A few words of a scene can request more springs than fit into memory.
constexpr std::size_t max_springs_found = 10'000'000;
// Far above the 13 of a lattice with all diagonals.
constexpr std::size_t max_rigid_a_node = 20;

// `found` counts the springs found by all tables.
void read_connection(const Table& connect, const PluginHost& plugins, const Files& files, std::size_t& found,
                     Network& network) {
  const Material material = read_material(connect, plugins, files);
  if (!material.spring && !material.viscosity) {
    connect.fail("neither 'spring' nor 'viscosity' says what the springs are made of; add spring = { type = …, … }");
  }
  const auto length = connect.find("rest_length");
  const auto scale = connect.find("rest_length_scale");
  if (length && scale) scale->fail("cannot be combined with 'rest_length'; remove one of them");
  const double factor = scale ? scale->number_above_0("") : 1.0;
  std::optional<double> given;
  if (length) given = length->number_from_0("m");
  const auto lengths = connect.find("rest_lengths");
  if (lengths) refuse_beside(connect, {"rest_length", "rest_length_scale", "within", "nearest"}, "rest_lengths");

  const auto limit = [&](std::size_t, std::size_t) -> PairLimit {
    return {max_springs_found - found,
            fmt::format("all [[connect]] together find at most {} by 'within'", grouped(max_springs_found))};
  };
  const std::vector<Pair> pairs = find_pairs(connect, network, limit);
  if (connect.has("within")) found += pairs.size();
  const Checked before{.springs = network.springs().size()};
  const MaterialIndex index = network.add_material(material);
  const std::vector<double> each = lengths ? numbers_for(*lengths, pairs.size(), "pair") : std::vector<double>();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    (lengths ? lengths->element(k) : connect.value()).at_this_place([&] {
      if (lengths) given = each[k];
      const SpringIndex spring = network.add_spring(pairs[k].first, pairs[k].second, index, given);
      if (scale) network.set_rest_length(spring, factor * network.springs()[spring].rest_length);
    });
  }
  connect.value().at_this_place([&] { check_spacing(network, before); });
}

// The ends of springs, each pair once.
std::vector<Pair> ends_of(const std::vector<SpringIndex>& springs, const Network& network) {
  std::vector<Pair> pairs;
  std::set<Pair> known;
  for (const SpringIndex index : springs) {
    const Spring& spring = network.springs()[index];
    if (known.insert(std::minmax(spring.first, spring.second)).second) pairs.emplace_back(spring.first, spring.second);
  }
  return pairs;
}

std::size_t count_nodes(const std::vector<Pair>& pairs) {
  std::vector<NodeIndex> nodes;
  nodes.reserve(2 * pairs.size());
  for (const auto& [first, second] : pairs) nodes.insert(nodes.end(), {first, second});
  std::sort(nodes.begin(), nodes.end());
  return static_cast<std::size_t>(std::unique(nodes.begin(), nodes.end()) - nodes.begin());
}

// Large rigid bodies are expensive.
void note_cost(const Table& rigid, const std::vector<Pair>& pairs, std::vector<std::string>& notes) {
  constexpr std::size_t many_nodes = 500;
  const std::size_t nodes = count_nodes(pairs);
  if (nodes < many_nodes || pairs.size() < 2 * nodes) return;
  notes.push_back(
      fmt::format("{} joins {} nodes by {} connections: rigid bodies of so many nodes take seconds per time step; "
                  "join fewer nodes (the outer ones, say), or make their springs stiff instead.",
                  rigid.value().path(), grouped(nodes), grouped(pairs.size())));
}

void read_rigid(const Table& rigid, Network& network, std::vector<std::string>& notes) {
  const auto limit = [](std::size_t from, std::size_t to) -> PairLimit {
    return {max_rigid_a_node * (from + to),
            fmt::format("a [[rigid]] has at most {} a node: three are enough", max_rigid_a_node)};
  };
  std::vector<Pair> pairs;
  if (const auto springs = rigid.find("springs")) {
    for (const char* key : {"pairs", "from", "to", "within", "nearest"}) {
      if (rigid.has(key)) rigid.find(key)->fail("cannot be combined with 'springs'; remove one of them");
    }
    pairs = ends_of(select_springs(*springs, network), network);
    if (const std::size_t nodes = count_nodes(pairs); pairs.size() > max_rigid_a_node * nodes) {
      springs->fail(
          fmt::format("makes {} connections between {} nodes, but a [[rigid]] has at most {} a node: three are enough; "
                      "select fewer springs",
                      grouped(pairs.size()), grouped(nodes), max_rigid_a_node));
    }
  } else {
    pairs = find_pairs(rigid, network, limit);
  }
  const auto length = rigid.find("length");
  std::optional<double> given;
  if (length) given = length->number_above_0("m");
  const auto lengths = rigid.find("lengths");
  if (lengths) refuse_beside(rigid, {"length", "within", "nearest", "springs"}, "lengths");
  const std::vector<double> each = lengths ? numbers_for(*lengths, pairs.size(), "pair") : std::vector<double>();
  const Checked before{network.springs().size(), network.elements().size(), network.rigids().size()};
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Value place = lengths ? lengths->element(k) : length ? *length : rigid.value();
    place.at_this_place(
        [&] { network.add_rigid(pairs[k].first, pairs[k].second, lengths ? std::optional<double>(each[k]) : given); });
  }
  rigid.value().at_this_place([&] { check_spacing(network, before); });
  note_cost(rigid, pairs, notes);
}

}  // namespace

void read_connections(const Table& root, const PluginHost& plugins, const Files& files, Scene& scene) {
  std::size_t found = 0;
  for (const Value& connection : root.tables("connect")) {
    read_connection(connection.table("connect"), plugins, files, found, scene.network);
  }
  for (const Value& rigid : root.tables("rigid")) read_rigid(rigid.table("rigid"), scene.network, scene.notes);
}

}  // namespace springnet::scene
