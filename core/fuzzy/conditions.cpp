#include "fuzzy/conditions.hpp"

#include <cmath>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "fuzzy/problems.hpp"

namespace springnet::fuzzy {

namespace {

bool is_any(const Proposition& is) { return !is.hedges.empty() && is.hedges.back() == Hedge::any; }

// Of one node, whose parts are known.
class Combination {
 public:
  Combination(const RuleBlock& block, const std::vector<Bounds>& parts) : block_(block), parts_(parts) {}

  [[nodiscard]] Bounds of(const ConditionNode& node) const {
    const Bounds& left = parts_[node.left];
    if (node.kind == ConditionNode::Kind::negation)
      return {{1.0 - left.most.value, -1.0, 0.0}, {1.0 - left.least.value, -1.0, 0.0}};
    const Bounds& right = parts_[node.right];
    return node.kind == ConditionNode::Kind::both ? of(block_.conjunction, left, right)
                                                  : of(block_.disjunction, left, right);
  }

 private:
  template <class Norm>
  [[nodiscard]] static Bounds of(Norm norm, const Bounds& left, const Bounds& right) {
    return {combine(norm, left.least.value, right.least.value), combine(norm, left.most.value, right.most.value)};
  }

  const RuleBlock& block_;
  const std::vector<Bounds>& parts_;
};

Bounds known(const OfOne& degree) {
  const OfTwo both{degree.value, degree.derivative, 0.0};
  return {both, both};
}

}  // namespace

void check_inputs(const RuleBase& base, const Inputs& inputs) {
  if (inputs.size() != base.inputs.size())
    throw Error(ErrorKind::input, fmt::format("rule base: there are {} values for {} inputs; give one each, or nothing "
                                              "for what is not known",
                                              inputs.size(), base.inputs.size()));
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (!inputs[i]) continue;
    if (const std::string problem = problem_of(*inputs[i]); !problem.empty())
      throw Error(ErrorKind::input, fmt::format("rule base: input '{}': {}", base.inputs[i].name, problem));
  }
}

Conditions::Conditions(const RuleBase& base, const Inputs& inputs) : base_(base), inputs_(inputs) {
  check_inputs(base, inputs);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const Variable& input = base.inputs[i];
    std::vector<double>& own = degrees_.emplace_back(input.terms.size());
    for (std::size_t term = 0; inputs[i] && term < own.size(); ++term)
      own[term] = membership(input.terms[term], *inputs[i]).value;
  }
  const auto bounds_of = [&](const Proposition& is) -> Bounds {
    if (is_any(is)) return known(hedged(is.hedges, 1.0));
    if (inputs[is.input]) return known(hedged(is.hedges, degrees_[is.input][is.term]));
    return {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  };
  for (std::size_t block = 0; block < base.blocks.size(); ++block) {
    const RuleBlock& own = base.blocks[block];
    for (std::size_t rule = 0; rule < own.rules.size(); ++rule) {
      std::vector<Bounds>& nodes = nodes_.emplace_back();
      const Combination combination(own, nodes);
      for (const ConditionNode& node : own.rules[rule].condition)
        nodes.push_back(node.kind == ConditionNode::Kind::proposition ? bounds_of(node.proposition)
                                                                      : combination.of(node));
      rules_.push_back({block, rule, own.rules[rule].weight * nodes.back().least.value});
    }
  }
}

void Conditions::add_backwards(std::size_t rule, double by_activation,
                               std::vector<std::vector<double>>& by_degree) const {
  using Kind = ConditionNode::Kind;
  struct Derivatives {
    double by_least = 0.0, by_most = 0.0;
  };
  const Rule& own = base_.blocks[rules_[rule].block].rules[rules_[rule].rule];
  const std::vector<Bounds>& nodes = nodes_[rule];
  std::vector<Derivatives> by_node(nodes.size());
  by_node.back().by_least = by_activation * own.weight;
  for (std::size_t i = nodes.size(); i-- > 0;) {
    const ConditionNode& node = own.condition[i];
    const auto [by_least, by_most] = by_node[i];
    const auto& [least, most] = nodes[i];
    if (node.kind == Kind::proposition) {
      const Proposition& is = node.proposition;
      // Both degrees of a known input are one.
      if (!is_any(is) && inputs_[is.input]) by_degree[is.input][is.term] += (by_least + by_most) * least.by_first;
    } else if (node.kind == Kind::negation) {
      by_node[node.left].by_most += by_least * least.by_first;
      by_node[node.left].by_least += by_most * most.by_first;
    } else {
      by_node[node.left].by_least += by_least * least.by_first;
      by_node[node.left].by_most += by_most * most.by_first;
      by_node[node.right].by_least += by_least * least.by_second;
      by_node[node.right].by_most += by_most * most.by_second;
    }
  }
}

}  // namespace springnet::fuzzy
