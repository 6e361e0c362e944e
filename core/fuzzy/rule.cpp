#include <algorithm>

#include <springnet/fuzzy.hpp>

namespace springnet::fuzzy {

bool reads(const Rule& rule, std::size_t input) {
  return std::any_of(rule.condition.begin(), rule.condition.end(), [&](const ConditionNode& node) {
    return node.kind == ConditionNode::Kind::proposition && node.proposition.input == input;
  });
}

bool concludes(const Rule& rule, std::size_t output) {
  return std::any_of(rule.conclusions.begin(), rule.conclusions.end(),
                     [&](const Conclusion& each) { return each.output == output; });
}

}  // namespace springnet::fuzzy
