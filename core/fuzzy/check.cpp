#include <algorithm>
#include <set>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "fuzzy/condition.hpp"
#include "fuzzy/functions.hpp"
#include "fuzzy/names.hpp"
#include "fuzzy/problems.hpp"

namespace springnet::fuzzy {
namespace {

[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw Error(ErrorKind::input, fmt::format("rule base: {}: {}", where, what));
}

void check_name(const std::string& kind, const std::string& name, std::set<std::string>& known) {
  if (!is_name(name)) fail(fmt::format("{} '{}'", kind, printable(name)), "this is no name that FCL can have");
  if (!known.insert(name).second) fail(fmt::format("{} '{}'", kind, name), "the name is there twice");
}

void check_count(const std::string& where, std::size_t count, std::size_t most, std::string_view what) {
  if (count > most) fail(where, fmt::format("has more than {} {}", most, what));
}

void check_variable(const std::string& where, const Variable& variable, std::size_t inputs) {
  if (const std::string problem = problem_of_range(variable.smallest, variable.largest); !problem.empty())
    fail(where, problem);
  check_count(where, variable.terms.size(), Limits::terms, "terms");
  std::set<std::string> names;
  for (const Term& term : variable.terms) {
    check_name(where + ": term", term.name, names);
    if (const std::string problem = problem_of(term, inputs); !problem.empty())
      fail(fmt::format("{}: term '{}'", where, term.name), problem);
  }
}

void check_term_of(const std::string& where, const std::vector<Hedge>& hedges, std::size_t term,
                   const Variable& variable) {
  check_count(where, hedges.size(), Limits::hedges, "hedges");
  for (std::size_t i = 0; i < hedges.size(); ++i)
    if (hedges[i] == Hedge::any && i + 1 < hedges.size()) fail(where, "has hedges after 'any'");
  const bool is_any = !hedges.empty() && hedges.back() == Hedge::any;
  if (!is_any && term >= variable.terms.size())
    fail(where, fmt::format("names term {} of '{}', which has {}", term, variable.name, variable.terms.size()));
}

// Each node combines earlier ones, and each but the last is combined once: a tree.
void check_condition(const std::string& where, const Rule& rule, const RuleBase& base) {
  using Kind = ConditionNode::Kind;
  const std::vector<ConditionNode>& nodes = rule.condition;
  if (nodes.empty()) fail(where, "has no condition");
  check_count(where, nodes.size(), Limits::nodes, "parts of its condition");
  std::vector<std::size_t> uses(nodes.size()), brackets(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ConditionNode& node = nodes[i];
    if (node.kind == Kind::proposition) {
      if (node.proposition.input >= base.inputs.size())
        fail(where, fmt::format("names input {}; there are {}", node.proposition.input, base.inputs.size()));
      check_term_of(where, node.proposition.hedges, node.proposition.term, base.inputs[node.proposition.input]);
      continue;
    }
    const auto combine = [&](std::size_t part, bool is_right) {
      if (part >= i) fail(where, "has a part of its condition that combines a later one");
      ++uses[part];
      const std::size_t own = needs_brackets(node.kind, nodes[part].kind, is_right) ? 1 : 0;
      brackets[i] = std::max(brackets[i], brackets[part] + own);
    };
    combine(node.left, false);
    if (node.kind != Kind::negation) combine(node.right, true);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (uses[i] != (i + 1 < nodes.size() ? 1u : 0u)) fail(where, "has a condition that is no tree");
  check_count(where, brackets.back(), Limits::depth, "brackets within each other");
}

void check_rule(const std::string& where, const Rule& rule, const RuleBase& base) {
  check_condition(where, rule, base);
  if (rule.conclusions.empty()) fail(where, "concludes nothing");
  check_count(where, rule.conclusions.size(), Limits::variables, "conclusions");
  for (const Conclusion& conclusion : rule.conclusions) {
    if (conclusion.output >= base.outputs.size())
      fail(where, fmt::format("concludes output {}; there are {}", conclusion.output, base.outputs.size()));
    check_term_of(where, conclusion.hedges, conclusion.term, base.outputs[conclusion.output]);
    if (!conclusion.hedges.empty() && conclusion.hedges.back() == Hedge::any) fail(where, "concludes 'any'");
  }
  if (const std::string problem = problem_of_weight(rule.weight); !problem.empty()) fail(where, problem);
}

}  // namespace

void check(const RuleBase& base) {
  const std::string whole = "the whole";
  std::set<std::string> none, names;
  if (!base.name.empty()) check_name("name", base.name, none);
  if (base.outputs.empty()) fail(whole, "there is no output");
  check_count(whole, base.inputs.size() + base.outputs.size(), Limits::variables, "variables");
  for (const Variable& input : base.inputs) {
    check_name("input", input.name, names);
    const std::string where = fmt::format("input '{}'", input.name);
    check_variable(where, input, base.inputs.size());
    for (const Term& term : input.terms)
      if (const std::string problem = problem_of_input_term(term); !problem.empty())
        fail(fmt::format("{}: term '{}'", where, term.name), problem);
  }
  for (const Output& output : base.outputs) {
    check_name("output", output.name, names);
    const std::string where = fmt::format("output '{}'", output.name);
    check_variable(where, output, base.inputs.size());
    if (output.terms.empty()) fail(where, "has no terms");
    if (is_mamdani(output.method) && !output.has_range) fail(where, "has no range to integrate over; set has_range");
    for (const Term& term : output.terms)
      if (const std::string problem = problem_of_output_term(term, output.method); !problem.empty())
        fail(fmt::format("{}: term '{}'", where, term.name), problem);
    if (output.otherwise)
      if (const std::string problem = problem_of(*output.otherwise); !problem.empty()) fail(where, problem);
  }
  check_count(whole, base.blocks.size(), Limits::blocks, "rule blocks");
  std::size_t rules = 0;
  for (const RuleBlock& block : base.blocks) {
    std::set<std::string> unnamed, rule_names;
    if (!block.name.empty()) check_name("rule block", block.name, unnamed);
    rules += block.rules.size();
    check_count(whole, rules, Limits::rules, "rules");
    for (const Rule& rule : block.rules) {
      const bool is_number =
          !rule.name.empty() && rule.name.size() <= Limits::name &&
          std::all_of(rule.name.begin(), rule.name.end(), [](char c) { return c >= '0' && c <= '9'; });
      if (!is_number && !is_name(rule.name))
        fail(fmt::format("rule '{}'", printable(rule.name)), "its name must be a number, or a name that FCL can have");
      if (!rule_names.insert(rule.name).second)
        fail(fmt::format("rule '{}'", rule.name), "its block has two of this name");
      check_rule(fmt::format("rule '{}'", rule.name), rule, base);
    }
  }
}

}  // namespace springnet::fuzzy
