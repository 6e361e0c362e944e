#include "formula/program.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace springnet::formula::detail {

// Steps in the order of the graph, as far as outputs need them. Memory is reused after the last step that reads it.
Program schedule(const Graph& graph, std::span<const Node> outputs, const std::vector<bool>& often_same) {
  const std::size_t size = graph.size();
  std::vector<bool> needed(size, false), same(often_same), lasts(size, false);
  for (const Node node : outputs) needed[node] = lasts[node] = true;
  const auto arguments = [&](Node node) {
    const Step& step = graph[node];
    return std::array{step.a, step.b, step.c};
  };
  std::vector<std::size_t> last_use(size, 0);
  for (std::size_t i = size; i-- > 0;) {
    if (!needed[i]) continue;
    for (const Node a : arguments(static_cast<Node>(i))) {
      if (a == no_node) continue;
      needed[a] = true;
      last_use[a] = std::max(last_use[a], i);
    }
  }
  Program program;
  std::vector<Place> place(size, 0);
  std::map<std::uint32_t, Node> inputs;
  for (Node node = 0; node < size; ++node)
    if (needed[node] && graph[node].code == Code::input) inputs.emplace(graph[node].index, node);
  for (const auto& [index, node] : inputs) {
    place[node] = static_cast<Place>(program.inputs.size());
    program.inputs.push_back(index);
  }
  for (Node node = 0; node < size; ++node) {
    if (!needed[node] || graph[node].code != Code::constant) continue;
    place[node] = program.first_constant() + static_cast<Place>(program.constants.size());
    program.constants.push_back(graph[node].number);
    same[node] = true;
  }
  std::vector<Place> free;
  const Place first = program.first_slot();
  for (Node node = 0; node < size; ++node) {
    const Step& step = graph[node];
    if (!needed[node] || step.code == Code::constant || step.code == Code::input) continue;
    bool is_same = true;
    for (const Node a : arguments(node)) is_same = is_same && (a == no_node || same[a]);
    same[node] = is_same;
    const bool keeps = is_same || lasts[node];
    Place to = first + program.slots;
    if (!keeps && !free.empty()) {
      to = free.back();
      free.pop_back();
    } else {
      ++program.slots;
    }
    place[node] = to;
    const auto of = [&](Node a) { return a == no_node ? Place{0} : place[a]; };
    program.steps.push_back({step.code, to, of(step.a), of(step.b), of(step.c), step.index});
    // A step may not write where it reads, so its own arguments are free after it.
    for (const Node a : arguments(node)) {
      if (a == no_node || last_use[a] != node || same[a] || lasts[a] || graph[a].code == Code::input) continue;
      if (std::find(free.begin(), free.end(), place[a]) == free.end()) free.push_back(place[a]);
    }
  }
  for (const Node node : outputs) program.outputs.push_back(place[node]);
  return program;
}

}  // namespace springnet::formula::detail
