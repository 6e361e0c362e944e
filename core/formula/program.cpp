#include "formula/program.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace springnet::formula::detail {
namespace {

// A step of the program whose arguments are nodes still.
struct Work {
  Node node, also;
  Code code;
  std::array<Node, 4> arguments;
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
    const auto take = [&](Node node) {
      Place to = first + program.slots;
      if (!keeps(node) && !free.empty()) {
        to = free.back();
        free.pop_back();
      } else {
        ++program.slots;
      }
      return place[node] = to;
    };
    for (std::size_t k = 0; k < work_.size(); ++k) {
      const Work& work = work_[k];
      const Place to = take(work.node), also = work.also == no_node ? to : take(work.also);
      const auto of = [&](std::size_t i) { return work.arguments[i] == no_node ? Place{0} : place[work.arguments[i]]; };
      program.steps.push_back({work.code, to, of(0), of(1), of(2), of(3), also, graph_[work.node].index});
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

  // In the order of the graph. A product that one sum, difference or product alone reads is done with it, and so are
  // e^x - 1 and its slope.
  void list_work() {
    std::vector<unsigned> uses(graph_.size(), 0);
    std::map<Node, Node> slopes;  // of e^x - 1, by x
    for (Node node = 0; node < graph_.size(); ++node) {
      if (!needed_[node]) continue;
      for (const Node a : arguments(node))
        if (a != no_node) ++uses[a];
      if (graph_[node].code == Code::expm1_slope) slopes.emplace(graph_[node].a, node);
    }
    const auto can_join = [&](Node a) { return graph_[a].code == Code::product && uses[a] == 1 && !keeps(a); };
    std::vector<Work> reversed;
    std::vector<bool> is_joined(graph_.size(), false);
    std::map<Node, Node> pairs;  // the later one by the earlier one
    for (Node node = 0; node < graph_.size(); ++node) {
      if (!needed_[node] || graph_[node].code != Code::expm1) continue;
      if (const auto slope = slopes.find(graph_[node].a); slope != slopes.end()) {
        const auto [first, second] = std::minmax(node, slope->second);
        pairs.emplace(first, second);
        is_joined[second] = true;
      }
    }
    for (std::size_t i = graph_.size(); i-- > 0;) {
      const auto node = static_cast<Node>(i);
      const Step& step = graph_[node];
      if (!needed_[node] || is_joined[node] || step.code == Code::constant || step.code == Code::input) continue;
      Work work{node, no_node, step.code, {step.a, step.b, step.c, no_node}};
      if (const auto pair = pairs.find(node); pair != pairs.end()) {
        const bool is_slope = step.code == Code::expm1_slope;
        work.node = is_slope ? pair->second : node;
        work.also = is_slope ? node : pair->second;
        work.code = Code::expm1_and_slope;
      }
      if (!same_[node]) join_products(step, can_join, work, is_joined);
      reversed.push_back(work);
    }
    work_.assign(reversed.rbegin(), reversed.rend());
  }
  template <class CanJoin>
  void join_products(const Step& step, const CanJoin& can_join, Work& work, std::vector<bool>& is_joined) const {
    const bool is_sum = step.code == Code::sum, is_product = step.code == Code::product;
    if (!is_sum && !is_product && step.code != Code::difference) return;
    const Node joined = can_join(step.a) ? step.a : can_join(step.b) ? step.b : no_node;
    if (joined == no_node) return;
    const Node other = joined == step.a ? step.b : step.a;
    const auto take = [&](Node product, std::size_t at) {
      is_joined[product] = true;
      work.arguments[at] = graph_[product].a;
      work.arguments[at + 1] = graph_[product].b;
      // The one that varies first, if only one does.
      if (same_[work.arguments[at]]) std::swap(work.arguments[at], work.arguments[at + 1]);
    };
    take(joined, 0);
    work.arguments[2] = other;
    if (is_product) {
      work.code = Code::product_product;
    } else if (other != joined && can_join(other)) {
      work.code = is_sum ? Code::sum_of_products : Code::products_difference;
      take(other, 2);
    } else {
      work.code = is_sum ? Code::product_sum : joined == step.a ? Code::product_difference : Code::difference_product;
    }
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
