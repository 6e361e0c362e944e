// RULE name : IF condition THEN output IS [hedges] term {AND output IS ...} [WITH weight];
// A condition is made of "input IS [hedges] term", NOT, AND, OR and brackets; AND binds stronger than OR.
#include <algorithm>

#include "fuzzy/problems.hpp"
#include "fuzzy/reader.hpp"

namespace springnet::fuzzy {

void Reader::read_rule_block() {
  if (base_.blocks.size() == Limits::blocks)
    scanner_.fail(last_, fmt::format("there are more than {} rule blocks", Limits::blocks));
  RuleBlock& block = base_.blocks.emplace_back();
  if (scanner_.peek().kind == Token::Kind::word && !is_language_word(scanner_.peek().text))
    block.name = read_new_name("a rule block").text;
  std::optional<SNorm> accumulation;
  Token accumulation_place;
  std::set<std::string_view> names;
  while (!take("END_RULEBLOCK")) {
    if (take("AND")) {
      block.conjunction = read_choice(t_norms, "AND");
    } else if (take("OR")) {
      block.disjunction = read_choice(s_norms, "OR");
    } else if (take("ACT")) {
      block.activation = read_choice(t_norms, "ACT");
    } else if (take("ACCU")) {
      accumulation_place = last_;
      accumulation = read_choice(s_norms, "ACCU");
    } else if (take("RULE")) {
      read_rule(block, names);
    } else {
      fail_unexpected("AND, OR, ACT, ACCU, RULE or END_RULEBLOCK");
    }
  }
  if (!accumulation) return;
  // As the standard has it, ACCU is of a rule block; it is of the outputs that the block concludes.
  for (const Rule& rule : block.rules) {
    for (const Conclusion& conclusion : rule.conclusions) {
      std::optional<SNorm>& known = accumulation_[conclusion.output];
      Output& output = base_.outputs[conclusion.output];
      if (known && *known != *accumulation)
        scanner_.fail(accumulation_place, fmt::format("output '{}' has ACCU : {} already; remove one of them",
                                                      output.name, word_of(s_norms, *known)));
      known = accumulation;
      output.accumulation = *accumulation;
    }
  }
}

void Reader::read_rule(RuleBlock& block, std::set<std::string_view>& names) {
  std::size_t rules = 0;
  for (const RuleBlock& each : base_.blocks) rules += each.rules.size();
  if (rules == Limits::rules) scanner_.fail(last_, fmt::format("there are more than {} rules", Limits::rules));
  const Token name = scanner_.take();
  const bool is_number = name.kind == Token::Kind::number &&
                         std::all_of(name.text.begin(), name.text.end(), [](char c) { return c >= '0' && c <= '9'; });
  if ((name.kind != Token::Kind::word && !is_number) || name.text.size() > Limits::name)
    scanner_.fail(name, fmt::format("a rule needs a number or a name, not {}", shown(name)));
  if (!names.insert(name.text).second)
    scanner_.fail(name, fmt::format("the block has a rule {} already; choose another number", shown(name)));
  Rule& rule = block.rules.emplace_back();
  rule.name = name.text;
  expect(":", "the number of a rule");
  expect("IF", "a rule's ':'");
  read_disjunction(rule, 0);
  expect("THEN", "a condition");
  do read_conclusion(rule);
  while (take("AND") || take(","));
  if (take("WITH")) {
    const Token place = scanner_.peek();
    rule.weight = read_number("a weight");
    if (const std::string problem = problem_of_weight(rule.weight); !problem.empty()) scanner_.fail(place, problem);
  }
  expect(";", "a rule");
}

std::size_t Reader::add(Rule& rule, ConditionNode node) {
  if (rule.condition.size() == Limits::nodes)
    scanner_.fail(scanner_.peek(), fmt::format("a condition has more than {} parts", Limits::nodes));
  rule.condition.push_back(std::move(node));
  return rule.condition.size() - 1;
}

std::size_t Reader::read_disjunction(Rule& rule, std::size_t depth) {
  if (depth > Limits::depth)
    scanner_.fail(scanner_.peek(),
                  fmt::format("a condition has more than {} brackets within each other", Limits::depth));
  std::size_t left = read_conjunction(rule, depth);
  while (take("OR")) {
    const std::size_t right = read_conjunction(rule, depth);
    left = add(rule, {ConditionNode::Kind::either, {}, left, right});
  }
  return left;
}

std::size_t Reader::read_conjunction(Rule& rule, std::size_t depth) {
  std::size_t left = read_primary(rule, depth);
  while (take("AND")) {
    const std::size_t right = read_primary(rule, depth);
    left = add(rule, {ConditionNode::Kind::both, {}, left, right});
  }
  return left;
}

std::size_t Reader::read_primary(Rule& rule, std::size_t depth) {
  bool is_negated = false;
  while (take("NOT")) is_negated = !is_negated;
  std::size_t node = 0;
  if (take("(")) {
    node = read_disjunction(rule, depth + 1);
    expect(")", "a condition in brackets");
  } else {
    node = read_proposition(rule);
  }
  if (!is_negated) return node;
  // "NOT x IS low" is "x IS NOT low".
  if (rule.condition[node].kind == ConditionNode::Kind::proposition) {
    std::vector<Hedge>& own = rule.condition[node].proposition.hedges;
    if (own.size() == Limits::hedges)
      scanner_.fail(last_, fmt::format("there are more than {} hedges", Limits::hedges));
    own.insert(own.begin(), Hedge::negation);
    return node;
  }
  return add(rule, {ConditionNode::Kind::negation, {}, node, node});
}

std::size_t Reader::read_proposition(Rule& rule) {
  const Token name = scanner_.take();
  const Variable* const input = find_name(base_.inputs, name.text);
  if (input == nullptr && find_name(base_.outputs, name.text) != nullptr)
    scanner_.fail(name, fmt::format("{} is an output; conditions are about inputs", shown(name)));
  if (input == nullptr)
    scanner_.fail(name, fmt::format("{} is not an input; {}", shown(name), remedy(name.text, names_of(base_.inputs))));
  expect("IS", "an input");
  ConditionNode node;
  node.proposition.input = static_cast<std::size_t>(input - base_.inputs.data());
  node.proposition.hedges = read_hedges();
  const std::vector<Hedge>& read = node.proposition.hedges;
  if (read.empty() || read.back() != Hedge::any) node.proposition.term = read_term_name(*input);
  return add(rule, std::move(node));
}

std::vector<Hedge> Reader::read_hedges() {
  std::vector<Hedge> read;
  while (scanner_.peek().kind == Token::Kind::word) {
    const Hedge* const hedge = find_word(hedges, scanner_.peek().text);
    if (hedge == nullptr) break;
    if (read.size() == Limits::hedges)
      scanner_.fail(scanner_.peek(), fmt::format("there are more than {} hedges", Limits::hedges));
    scanner_.take();
    read.push_back(*hedge);
    if (*hedge == Hedge::any) break;  // whatever the term
  }
  return read;
}

std::size_t Reader::read_term_name(const Variable& variable) {
  const Token name = scanner_.take();
  const Term* const term = find_name(variable.terms, name.text);
  if (term == nullptr)
    scanner_.fail(name, fmt::format("'{}' has no term {}; {}", variable.name, shown(name),
                                    remedy(name.text, names_of(variable.terms))));
  return static_cast<std::size_t>(term - variable.terms.data());
}

void Reader::read_conclusion(Rule& rule) {
  const Token name = scanner_.take();
  const Output* const output = find_name(base_.outputs, name.text);
  if (output == nullptr)
    scanner_.fail(name,
                  fmt::format("{} is not an output; {}", shown(name), remedy(name.text, names_of(base_.outputs))));
  if (rule.conclusions.size() == Limits::variables)
    scanner_.fail(name, fmt::format("a rule has more than {} conclusions", Limits::variables));
  expect("IS", "an output");
  Conclusion conclusion;
  conclusion.output = static_cast<std::size_t>(output - base_.outputs.data());
  const Token first = scanner_.peek();
  conclusion.hedges = read_hedges();
  if (!conclusion.hedges.empty() && conclusion.hedges.back() == Hedge::any)
    scanner_.fail(first, "'any' concludes nothing; write a term");
  conclusion.term = read_term_name(*output);
  rule.conclusions.push_back(std::move(conclusion));
}

}  // namespace springnet::fuzzy
