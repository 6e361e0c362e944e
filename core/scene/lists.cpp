#include "scene/lists.hpp"

#include <fmt/format.h>

#include "scene/select.hpp"

namespace springnet::scene {

std::vector<double> numbers_for(const Value& list, std::size_t count, std::string_view what) {
  std::vector<double> numbers = list.numbers(std::numeric_limits<std::size_t>::max());
  if (numbers.size() != count)
    list.fail(fmt::format("has {} numbers, needs {}, one for each {}", numbers.size(), count, what));
  return numbers;
}

Face read_face(const Value& face, const Body* body, const Network& network) {
  const std::vector<Value> corners = face.elements(3);
  return {read_node(corners[0], body, network), read_node(corners[1], body, network),
          read_node(corners[2], body, network)};
}

void read_own_lists(const Table& table, Network& network) {
  Body body = network.bodies().back();
  body.node_count = static_cast<NodeIndex>(network.nodes().size() - body.first_node);
  const std::size_t springs = network.springs().size() - body.first_spring;
  const auto change_nodes = [&](const Value& list, const auto& set) {
    const std::vector<Value> values = list.elements(body.node_count);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const auto number = body.first_node + static_cast<NodeIndex>(k);
      Node node = network.nodes()[number];
      set(node, values[k]);
      values[k].at_this_place([&] { network.set_node(number, node); });
    }
  };
  if (const auto masses = table.find("masses"))
    change_nodes(*masses, [](Node& node, const Value& value) { node.mass = value.number_above_0("kg"); });
  if (const auto velocities = table.find("velocities")) {
    if (table.has("velocity")) velocities->fail("cannot be combined with 'velocity'; remove one of them");
    change_nodes(*velocities, [](Node& node, const Value& value) { node.velocity = value.vector(); });
  }
  if (const auto lengths = table.find("rest_lengths")) {
    if (table.has("rest_length_scale"))
      lengths->fail("cannot be combined with 'rest_length_scale'; remove one of them");
    const std::vector<double> numbers = numbers_for(*lengths, springs, "spring");
    for (std::size_t k = 0; k < numbers.size(); ++k)
      lengths->element(k).at_this_place(
          [&] { network.set_rest_length(body.first_spring + static_cast<SpringIndex>(k), numbers[k]); });
  }
  if (const auto faces = table.find("faces"))
    for (const Value& face : faces->elements())
      face.at_this_place([&] { network.add_face(read_face(face, &body, network)); });
  for (const Value& value : table.tables("groups")) {
    const Table group = value.table("body.groups");
    std::vector<NodeIndex> nodes;
    for (const Value& node : group.need("nodes").elements()) nodes.push_back(read_node(node, &body, network));
    const Value name = group.need("name");
    name.at_this_place([&] { network.add_group(name.text(), nodes); });
  }
}

}  // namespace springnet::scene
