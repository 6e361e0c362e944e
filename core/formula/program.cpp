#include "formula/program.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace springnet::formula::detail {
namespace {

// A step of the program whose arguments are nodes still.
struct Work {
  Node node;
  Code code;
  std::array<Node, 3> arguments;
};

class Scheduler {
 public:
  Scheduler(const Graph& graph, std::span<const Node> outputs, const std::vector<bool>& often_same)
      : graph_(graph), outputs_(outputs), same_(often_same), needed_(graph.size()), lasts_(graph.size()) {
    find_needed();
    for (Node node = 0; node < graph.size(); ++node) {
      if (graph[node].code == Code::input) continue;
      const auto is_same = [&](Node a) { return a == no_node || same_[a]; };
      const auto all = arguments(node);
      same_[node] = std::all_of(all.begin(), all.end(), is_same);
    }
    list_work();
  }

  Program program() {
    Program program;
    std::vector<Place> place(graph_.size(), 0);
    std::map<std::uint32_t, Node> inputs;
    for (Node node = 0; node < graph_.size(); ++node)
      if (needed_[node] && graph_[node].code == Code::input) inputs.emplace(graph_[node].index, node);
    for (const auto& [index, node] : inputs) {
      place[node] = static_cast<Place>(program.inputs.size());
      program.inputs.push_back(index);
    }
    for (Node node = 0; node < graph_.size(); ++node) {
      if (!needed_[node] || graph_[node].code != Code::constant) continue;
      place[node] = program.first_slot();
      program.constants.push_back(graph_[node].number);
    }
    std::vector<std::size_t> last_use(graph_.size(), 0);
    for (std::size_t k = 0; k < work_.size(); ++k)
      for (const Node a : work_[k].arguments)
        if (a != no_node) last_use[a] = k;
    std::vector<Place> free;
    const Place first = program.first_slot();
    for (std::size_t k = 0; k < work_.size(); ++k) {
      const Work& work = work_[k];
      Place to = first + program.slots;
      if (!keeps(work.node) && !free.empty()) {
        to = free.back();
        free.pop_back();
      } else {
        ++program.slots;
      }
      place[work.node] = to;
      const auto of = [&](std::size_t i) { return work.arguments[i] == no_node ? Place{0} : place[work.arguments[i]]; };
      program.steps.push_back({work.code, to, of(0), of(1), of(2), graph_[work.node].index});
      // A step may not write where it reads, so its own arguments are free after it.
      for (const Node a : work.arguments) {
        if (a == no_node || last_use[a] != k || keeps(a) || place[a] < first) continue;
        if (std::find(free.begin(), free.end(), place[a]) == free.end()) free.push_back(place[a]);
      }
    }
    for (const Node node : outputs_) program.outputs.push_back(place[node]);
    return program;
  }

 private:
  [[nodiscard]] std::array<Node, 3> arguments(Node node) const {
    const Step& step = graph_[node];
    return {step.a, step.b, step.c};
  }
  // What is the same for all is computed once, and outputs are read at the end.
  [[nodiscard]] bool keeps(Node node) const { return same_[node] || lasts_[node]; }

  void find_needed() {
    for (const Node node : outputs_) needed_[node] = lasts_[node] = true;
    for (std::size_t i = graph_.size(); i-- > 0;)
      if (needed_[i])
        for (const Node a : arguments(static_cast<Node>(i)))
          if (a != no_node) needed_[a] = true;
  }

  // In the order of the graph. A product that one sum or difference alone reads is done with it.
  void list_work() {
    std::vector<unsigned> uses(graph_.size(), 0);
    for (Node node = 0; node < graph_.size(); ++node)
      if (needed_[node])
        for (const Node a : arguments(node))
          if (a != no_node) ++uses[a];
    const auto can_join = [&](Node a) { return graph_[a].code == Code::product && uses[a] == 1 && !keeps(a); };
    std::vector<Work> reversed;
    std::vector<bool> is_joined(graph_.size(), false);
    for (std::size_t i = graph_.size(); i-- > 0;) {
      const auto node = static_cast<Node>(i);
      const Step& step = graph_[node];
      if (!needed_[node] || is_joined[node] || step.code == Code::constant || step.code == Code::input) continue;
      Work work{node, step.code, arguments(node)};
      const bool is_sum = step.code == Code::sum;
      if ((is_sum || step.code == Code::difference) && !same_[node]) {
        const Node product = can_join(step.a) ? step.a : can_join(step.b) ? step.b : no_node;
        if (product != no_node) {
          const Node other = product == step.a ? step.b : step.a;
          is_joined[product] = true;
          work.code = is_sum              ? Code::product_sum
                      : product == step.a ? Code::product_difference
                                          : Code::difference_product;
          work.arguments = {graph_[product].a, graph_[product].b, other};
          // The one that varies first, if only one does.
          if (same_[work.arguments[0]]) std::swap(work.arguments[0], work.arguments[1]);
        }
      }
      reversed.push_back(work);
    }
    work_.assign(reversed.rbegin(), reversed.rend());
  }

  const Graph& graph_;
  std::span<const Node> outputs_;
  std::vector<bool> same_, needed_, lasts_;
  std::vector<Work> work_;
};

}  // namespace

Program schedule(const Graph& graph, std::span<const Node> outputs, const std::vector<bool>& often_same) {
  return Scheduler(graph, outputs, often_same).program();
}

}  // namespace springnet::formula::detail
