#include <set>

#include <fmt/format.h>

#include "scene/component.hpp"
#include "scene/pairs.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"

namespace springnet::scene {
namespace {

void read_connection(const Table& connect, const PluginHost& plugins, Network& network) {
  const Material material = read_material(connect, plugins);
  if (!material.spring && !material.viscosity) {
    connect.fail("neither 'spring' nor 'viscosity' says what the springs are made of; add spring = { type = …, … }");
  }
  const auto length = connect.find("rest_length");
  const auto scale = connect.find("rest_length_scale");
  if (length && scale) scale->fail("has no meaning beside 'rest_length'; remove one of them");
  const double factor = scale ? scale->number_above_0("") : 1.0;
  std::optional<double> given;
  if (length) given = length->number_from_0("m");

  const MaterialIndex index = network.add_material(material);
  for (const auto& [first, second] : find_pairs(connect, network)) {
    connect.value().at_this_place([&, a = first, b = second] {
      const SpringIndex spring = network.add_spring(a, b, index, given);
      if (scale) network.set_rest_length(spring, factor * network.springs()[spring].rest_length);
    });
  }
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

void read_rigid(const Table& rigid, Network& network) {
  std::vector<Pair> pairs;
  if (const auto springs = rigid.find("springs")) {
    for (const char* key : {"pairs", "from", "to", "within", "nearest"}) {
      if (rigid.has(key)) rigid.find(key)->fail("has no meaning beside 'springs'; remove one of them");
    }
    pairs = ends_of(select_springs(*springs, network), network);
  } else {
    pairs = find_pairs(rigid, network);
  }
  const auto length = rigid.find("length");
  std::optional<double> given;
  if (length) given = length->number_above_0("m");
  for (const auto& [first, second] : pairs) {
    (length ? *length : rigid.value()).at_this_place([&, a = first, b = second] { network.add_rigid(a, b, given); });
  }
}

}  // namespace

void read_connections(const Table& root, const PluginHost& plugins, Network& network) {
  for (const Value& connection : root.tables("connect")) {
    read_connection(connection.table("connect"), plugins, network);
  }
  for (const Value& rigid : root.tables("rigid")) read_rigid(rigid.table("rigid"), network);
}

}  // namespace springnet::scene
