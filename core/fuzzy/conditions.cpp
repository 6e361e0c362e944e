#include "fuzzy/conditions.hpp"

#include <cmath>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "fuzzy/problems.hpp"

namespace springnet::fuzzy {

Conditions::Conditions(const RuleBase& base, const Inputs& inputs) : base_(base), inputs_(inputs) {
  if (inputs.size() != base.inputs.size())
    throw Error(ErrorKind::input, fmt::format("rule base: there are {} values for {} inputs; give one each, or nothing "
                                              "for what is not known",
                                              inputs.size(), base.inputs.size()));
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const Variable& input = base.inputs[i];
    if (inputs[i])
      if (const std::string problem = problem_of(*inputs[i]); !problem.empty())
        throw Error(ErrorKind::input, fmt::format("rule base: input '{}': {}", input.name, problem));
    std::vector<double>& own = degrees_.emplace_back(input.terms.size());
    for (std::size_t term = 0; inputs[i] && term < own.size(); ++term)
      own[term] = membership(input.terms[term], *inputs[i]).value;
  }
  using Kind = ConditionNode::Kind;
  for (std::size_t block = 0; block < base.blocks.size(); ++block) {
    const RuleBlock& own = base.blocks[block];
    for (std::size_t rule = 0; rule < own.rules.size(); ++rule) {
      std::vector<OfTwo>& nodes = nodes_.emplace_back();
      for (const ConditionNode& node : own.rules[rule].condition) {
        if (node.kind == Kind::both) {
          nodes.push_back(combine(own.conjunction, nodes[node.left].value, nodes[node.right].value));
        } else if (node.kind == Kind::either) {
          nodes.push_back(combine(own.disjunction, nodes[node.left].value, nodes[node.right].value));
        } else if (node.kind == Kind::negation) {
          nodes.push_back({1.0 - nodes[node.left].value, -1.0, 0.0});
        } else {
          const Proposition& is = node.proposition;
          const bool is_any = !is.hedges.empty() && is.hedges.back() == Hedge::any;
          OfOne degree;
          if (is_any || inputs[is.input]) degree = hedged(is.hedges, is_any ? 1.0 : degrees_[is.input][is.term]);
          nodes.push_back({degree.value, degree.derivative, 0.0});
        }
      }
      rules_.push_back({block, rule, own.rules[rule].weight * nodes.back().value});
    }
  }
}

void Conditions::add_backwards(std::size_t rule, double by_activation,
                               std::vector<std::vector<double>>& by_degree) const {
  using Kind = ConditionNode::Kind;
  const Rule& own = base_.blocks[rules_[rule].block].rules[rules_[rule].rule];
  const std::vector<OfTwo>& nodes = nodes_[rule];
  std::vector<double> by_node(nodes.size());
  by_node.back() = by_activation * own.weight;
  for (std::size_t i = nodes.size(); i-- > 0;) {
    const ConditionNode& node = own.condition[i];
    if (node.kind == Kind::proposition) {
      const Proposition& is = node.proposition;
      const bool is_any = !is.hedges.empty() && is.hedges.back() == Hedge::any;
      if (!is_any && inputs_[is.input]) by_degree[is.input][is.term] += by_node[i] * nodes[i].by_first;
      continue;
    }
    by_node[node.left] += by_node[i] * nodes[i].by_first;
    if (node.kind != Kind::negation) by_node[node.right] += by_node[i] * nodes[i].by_second;
  }
}

}  // namespace springnet::fuzzy
