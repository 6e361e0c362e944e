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
  std::array<Node, 5> arguments;
};

// What takes much longer than to read and to write its numbers.
bool is_function(Code code) {
  return (code >= Code::sqrt && code <= Code::curve_bend) || code == Code::quotient || code == Code::expm1_and_slope;
}

class Scheduler {
 public:
  Scheduler(const Graph& graph, std::span<const Node> outputs, const std::vector<bool>& often_same)
      : graph_(graph),
        outputs_(outputs),
        same_(often_same),
        needed_(graph.size()),
        lasts_(graph.size()),
        is_joined_(graph.size()),
        uses_(graph.size()) {
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
      ProgramStep& step = program.steps.emplace_back(ProgramStep{work.code, 0, {}, to, also, graph_[work.node].index});
      for (const Node a : work.arguments)
        if (a != no_node) step.from[step.arguments++] = place[a];
      program.has_functions = program.has_functions || is_function(work.code);
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
    std::map<Node, Node> slopes;  // of e^x - 1, by x
    for (Node node = 0; node < graph_.size(); ++node) {
      if (!needed_[node]) continue;
      for (const Node a : arguments(node))
        if (a != no_node) ++uses_[a];
      if (graph_[node].code == Code::expm1_slope) slopes.emplace(graph_[node].a, node);
    }
    std::map<Node, Node> pairs;  // the later one by the earlier one
    for (Node node = 0; node < graph_.size(); ++node) {
      if (!needed_[node] || graph_[node].code != Code::expm1) continue;
      if (const auto slope = slopes.find(graph_[node].a); slope != slopes.end()) {
        const auto [first, second] = std::minmax(node, slope->second);
        pairs.emplace(first, second);
        is_joined_[second] = true;
      }
    }
    std::vector<Work> reversed;
    for (std::size_t i = graph_.size(); i-- > 0;) {
      const auto node = static_cast<Node>(i);
      const Step& step = graph_[node];
      if (!needed_[node] || is_joined_[node] || step.code == Code::constant || step.code == Code::input) continue;
      Work work{node, no_node, step.code, {step.a, step.b, step.c, no_node, no_node}};
      if (const auto pair = pairs.find(node); pair != pairs.end()) {
        const bool is_slope = step.code == Code::expm1_slope;
        work.node = is_slope ? pair->second : node;
        work.also = is_slope ? node : pair->second;
        work.code = Code::expm1_and_slope;
      }
      if (!same_[node]) join_products(step, work);
      reversed.push_back(work);
    }
    work_.assign(reversed.rbegin(), reversed.rend());
  }
  [[nodiscard]] bool can_join(Node a, Code code) const {
    return a != no_node && graph_[a].code == code && uses_[a] == 1 && !keeps(a);
  }
  // One of the arguments of a step, and the other one: that which can be joined, if one can.
  struct Joined {
    Node node = no_node, other = no_node;
  };
  [[nodiscard]] Joined joined(const Step& step, Code code) const {
    if (can_join(step.a, code)) return {step.a, step.b};
    if (can_join(step.b, code)) return {step.b, step.a};
    return {};
  }
  // Its factors become arguments of the work, from this one on.
  void take(Node product, std::size_t at, Work& work) {
    is_joined_[product] = true;
    work.arguments[at] = graph_[product].a;
    work.arguments[at + 1] = graph_[product].b;
  }
  void join_products(const Step& step, Work& work) {
    const bool is_sum = step.code == Code::sum;
    if (!is_sum && step.code != Code::product && step.code != Code::difference) return;
    if (step.code == Code::product) {
      if (const Joined sum = joined(step, Code::sum); sum.node != no_node) {
        const Joined product = joined(graph_[sum.node], Code::product);
        if (product.node == no_node || can_join(product.other, Code::product)) return;
        is_joined_[sum.node] = true;
        take(product.node, 0, work);
        work.arguments[2] = product.other;
        work.arguments[3] = sum.other;
        work.code = Code::product_sum_product;
        return;
      }
    }
    const Joined product = joined(step, Code::product);
    if (product.node == no_node) return;
    take(product.node, 0, work);
    work.arguments[2] = product.other;
    if (step.code == Code::product) {
      work.code = Code::product_product;
    } else if (can_join(product.other, Code::product)) {
      join_two_products(product.node, product.other, is_sum, work);
    } else if (!is_sum) {
      work.code = product.node == step.a ? Code::product_difference : Code::difference_product;
    } else if (const Joined inner = joined(graph_[product.node], Code::product); inner.node != no_node) {
      work.code = Code::product_product_sum;
      take(inner.node, 0, work);
      work.arguments[2] = inner.other;
      work.arguments[3] = product.other;
    } else {
      work.code = Code::product_sum;
    }
  }

  void join_two_products(Node one, Node other, bool is_sum, Work& work) {
    if (is_sum) {
      for (const auto& [longer, shorter] : {std::pair(one, other), std::pair(other, one)}) {
        const Joined inner = joined(graph_[longer], Code::product);
        if (inner.node == no_node) continue;
        is_joined_[longer] = true;
        take(inner.node, 0, work);
        work.arguments[2] = inner.other;
        take(shorter, 3, work);
        work.code = Code::sum_of_longer_products;
        return;
      }
    }
    take(one, 0, work);
    take(other, 2, work);
    work.code = is_sum ? Code::sum_of_products : Code::products_difference;
  }

  const Graph& graph_;
  std::span<const Node> outputs_;
  std::vector<bool> same_, needed_, lasts_, is_joined_;
  std::vector<unsigned> uses_;
  std::vector<Work> work_;
};

}  // namespace

Program schedule(const Graph& graph, std::span<const Node> outputs, const std::vector<bool>& often_same) {
  return Scheduler(graph, outputs, often_same).program();
}

}  // namespace springnet::formula::detail
