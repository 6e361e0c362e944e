#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fuzzy/condition.hpp"
#include "fuzzy/functions.hpp"
#include "fuzzy/names.hpp"

namespace springnet::fuzzy {
namespace {

using Text = std::back_insert_iterator<std::string>;

// Numbers as the shortest text that reads as the same double.
std::string text_of(const Term& term) {
  switch (term.shape) {
    case Shape::singleton:
      return fmt::format("{}", term.numbers[0]);
    case Shape::points: {
      std::string points;
      for (std::size_t i = 0; i < term.numbers.size(); i += 2)
        points += fmt::format("{}({}, {})", i == 0 ? "" : " ", term.numbers[i], term.numbers[i + 1]);
      return points;
    }
    default:
      return fmt::format("{} {}", word_of(shapes, term.shape), fmt::join(term.numbers, " "));
  }
}

std::string text_of(const std::vector<Hedge>& hedges_of_term, std::size_t term, const Variable& variable) {
  std::string text;
  for (const Hedge hedge : hedges_of_term) text += fmt::format("{}{}", text.empty() ? "" : " ", word_of(hedges, hedge));
  if (!hedges_of_term.empty() && hedges_of_term.back() == Hedge::any) return text;
  return fmt::format("{}{}{}", text, text.empty() ? "" : " ", variable.terms[term].name);
}

std::string text_of(const RuleBase& base, const Rule& rule, std::size_t index) {
  using Kind = ConditionNode::Kind;
  const ConditionNode& node = rule.condition[index];
  if (node.kind == Kind::proposition) {
    const Variable& input = base.inputs[node.proposition.input];
    return fmt::format("{} is {}", input.name, text_of(node.proposition.hedges, node.proposition.term, input));
  }
  const auto part = [&](std::size_t at, bool is_right) {
    const std::string text = text_of(base, rule, at);
    return needs_brackets(node.kind, rule.condition[at].kind, is_right) ? fmt::format("({})", text) : text;
  };
  if (node.kind == Kind::negation) return "not " + part(node.left, false);
  return fmt::format("{} {} {}", part(node.left, false), node.kind == Kind::both ? "and" : "or",
                     part(node.right, true));
}

void write_variables(Text out, std::string_view word, const std::vector<std::string>& names) {
  fmt::format_to(out, "\n{}\n", word);
  for (const std::string& name : names) fmt::format_to(out, "  {} : REAL;\n", name);
  fmt::format_to(out, "END_VAR\n");
}

void write_terms(Text out, const Variable& variable) {
  if (variable.has_range) fmt::format_to(out, "  RANGE := ({} .. {});\n", variable.smallest, variable.largest);
  for (const Term& term : variable.terms) fmt::format_to(out, "  TERM {} := {};\n", term.name, text_of(term));
}

}  // namespace

std::string text_of(const RuleBase& base, const Rule& rule) {
  std::string text = fmt::format("if {} then ", text_of(base, rule, rule.condition.size() - 1));
  for (std::size_t i = 0; i < rule.conclusions.size(); ++i) {
    const Conclusion& conclusion = rule.conclusions[i];
    const Output& output = base.outputs[conclusion.output];
    text += fmt::format("{}{} is {}", i == 0 ? "" : " and ", output.name,
                        text_of(conclusion.hedges, conclusion.term, output));
  }
  if (rule.weight != 1.0) text += fmt::format(" with {}", rule.weight);
  return text;
}

std::string to_fcl(const RuleBase& base) {
  check(base);
  std::string text;
  const Text out(text);
  fmt::format_to(out, "FUNCTION_BLOCK{}{}\n", base.name.empty() ? "" : " ", base.name);
  if (!base.inputs.empty()) write_variables(out, "VAR_INPUT", names_of(base.inputs));
  write_variables(out, "VAR_OUTPUT", names_of(base.outputs));
  for (const Variable& input : base.inputs) {
    fmt::format_to(out, "\nFUZZIFY {}\n", input.name);
    write_terms(out, input);
    fmt::format_to(out, "END_FUZZIFY\n");
  }
  for (const Output& output : base.outputs) {
    fmt::format_to(out, "\nDEFUZZIFY {}\n", output.name);
    write_terms(out, output);
    fmt::format_to(out, "  METHOD : {};\n", word_of(methods, output.method));
    if (is_mamdani(output.method)) fmt::format_to(out, "  ACCU : {};\n", word_of(s_norms, output.accumulation));
    if (output.otherwise) fmt::format_to(out, "  DEFAULT := {};\n", *output.otherwise);
    fmt::format_to(out, "END_DEFUZZIFY\n");
  }
  for (const RuleBlock& block : base.blocks) {
    fmt::format_to(out, "\nRULEBLOCK{}{}\n  AND : {};\n  OR : {};\n  ACT : {};\n", block.name.empty() ? "" : " ",
                   block.name, word_of(t_norms, block.conjunction), word_of(s_norms, block.disjunction),
                   word_of(t_norms, block.activation));
    for (const Rule& rule : block.rules) fmt::format_to(out, "  RULE {} : {};\n", rule.name, text_of(base, rule));
    fmt::format_to(out, "END_RULEBLOCK\n");
  }
  fmt::format_to(out, "\nEND_FUNCTION_BLOCK\n");
  return text;
}

}  // namespace springnet::fuzzy
