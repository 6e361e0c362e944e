#include "guess_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <springnet/printable.hpp>

namespace springnet::tool {

namespace {

using fuzzy::RuleBase;

// A rule that concludes the guess's output and applies.
struct Applied {
  const fuzzy::RuleBlock* block;
  const fuzzy::Rule* rule;
  double activation;
};

std::vector<Applied> rules_of(const SceneGuess& guess) {
  std::vector<Applied> applied;
  if (guess.term) return applied;
  for (const fuzzy::RuleActivation& each : evaluate(*guess.rules, guess.inputs).rules) {
    const fuzzy::RuleBlock& block = guess.rules->blocks[each.block];
    const fuzzy::Rule& rule = block.rules[each.rule];
    const bool concludes = std::any_of(rule.conclusions.begin(), rule.conclusions.end(),
                                       [&](const fuzzy::Conclusion& one) { return one.output == guess.output; });
    if (each.activation > 0.0 && concludes) applied.push_back({&block, &rule, each.activation});
  }
  return applied;
}

std::string rule_name(const Applied& applied) {
  return applied.block->name.empty() ? applied.rule->name
                                     : fmt::format("{} {}", applied.block->name, applied.rule->name);
}

const fuzzy::Output& output_of(const SceneGuess& guess) { return guess.rules->outputs[guess.output]; }

// Terms of the output with what they count for: 1 for the term that the scene names itself.
std::vector<std::pair<std::string, double>> terms_of(const SceneGuess& guess) {
  std::vector<std::pair<std::string, double>> terms;
  const fuzzy::Output& output = output_of(guess);
  if (guess.term) {
    terms.emplace_back(output.terms[*guess.term].name, 1.0);
    return terms;
  }
  const std::optional<fuzzy::Guess> found = evaluate(*guess.rules, guess.inputs).outputs[guess.output];
  for (std::size_t i = 0; found && i < output.terms.size(); ++i)
    if (found->activations[i] > 0.0) terms.emplace_back(output.terms[i].name, found->activations[i]);
  return terms;
}

// The number that the rules make: the guess's, or its logarithm.
double defuzzified(const SceneGuess& guess) { return guess.is_logarithmic ? std::log10(guess.value) : guess.value; }

constexpr std::size_t curve_points = 400;
constexpr double not_drawn = 1e-3;  // memberships below it, where curves would lie on each other

struct Interval {
  double from, to;
};

figure::FigureCurve curve_of(const fuzzy::Term& term, const Interval& range, double degree) {
  figure::FigureCurve curve;
  curve.dashed = !(degree > 0.0);
  if (degree > 0.0) curve.label = fmt::format("{} {:.2g}", term.name, degree);
  for (std::size_t i = 0; i <= curve_points; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(curve_points);
    const double x = range.from + (range.to - range.from) * share, y = degree_of(term, x);
    curve.x.push_back(x);
    curve.y.push_back(y < not_drawn ? std::nan("") : y);
  }
  return curve;
}

bool has_degrees(const fuzzy::Term& term) {
  return term.shape != fuzzy::Shape::singleton && term.shape != fuzzy::Shape::linear;
}

figure::FigurePanel panel_of(const fuzzy::Variable& variable) {
  figure::FigurePanel panel;
  panel.x_label = variable.name;
  panel.y_label = "membership";
  panel.has_plain_lines = true;
  return panel;
}

figure::FigurePanel input_panel(const fuzzy::Variable& input, double value) {
  figure::FigurePanel panel = panel_of(input);
  for (const fuzzy::Term& term : input.terms)
    panel.curves.push_back(curve_of(term, {input.smallest, input.largest}, degree_of(term, value)));
  panel.marks.push_back({value, value, fmt::format("{:.3g}", value)});
  return panel;
}

// The output's set, or the term that the scene names.
figure::FigureCurve set_of(const SceneGuess& guess) {
  const fuzzy::Output& output = output_of(guess);
  figure::FigureCurve set;
  set.label = "what the rules conclude";
  const double size = (output.largest - output.smallest) / static_cast<double>(fuzzy::resolution);
  for (std::size_t i = 0; i < fuzzy::resolution; ++i)
    set.x.push_back(output.smallest + (static_cast<double>(i) + 0.5) * size);
  if (!guess.term)
    set.y = fuzzy_set_of(*guess.rules, guess.inputs, guess.output);
  else if (has_degrees(output.terms[*guess.term]))
    for (const double x : set.x) set.y.push_back(degree_of(output.terms[*guess.term], x));
  for (double& y : set.y)
    if (y < not_drawn) y = std::nan("");
  return set;
}

// Where the set is, with as much again around it.
Interval shown_range(const fuzzy::Output& output, const figure::FigureCurve& set) {
  double from = output.largest, to = output.smallest;
  for (std::size_t i = 0; i < set.y.size(); ++i) {
    if (std::isnan(set.y[i])) continue;
    from = std::min(from, set.x[i]);
    to = std::max(to, set.x[i]);
  }
  if (!(from < to)) return {output.smallest, output.largest};
  const double margin = 0.5 * (to - from);
  return {std::max(output.smallest, from - margin), std::min(output.largest, to + margin)};
}

figure::FigurePanel output_panel(const SceneGuess& guess) {
  const fuzzy::Output& output = output_of(guess);
  figure::FigurePanel panel = panel_of(output);
  figure::FigureCurve set = set_of(guess);
  const Interval range = shown_range(output, set);
  const auto counts = terms_of(guess);
  for (const fuzzy::Term& term : output.terms) {
    if (!has_degrees(term)) continue;
    const auto found =
        std::find_if(counts.begin(), counts.end(), [&](const auto& each) { return each.first == term.name; });
    panel.curves.push_back(curve_of(term, range, found == counts.end() ? 0.0 : found->second));
  }
  if (!guess.term && !set.y.empty()) panel.curves.push_back(std::move(set));
  const double value = defuzzified(guess);
  if (guess.width > 0.0) panel.marks.push_back({value - guess.width, value + guess.width, "width"});
  panel.marks.push_back({value, value, fmt::format("{:.4g}", value)});
  return panel;
}

// Whether a rule that applies is about the input.
bool is_read(const std::vector<Applied>& applied, std::size_t input) {
  return std::any_of(applied.begin(), applied.end(), [&](const Applied& each) {
    return std::any_of(each.rule->condition.begin(), each.rule->condition.end(), [&](const fuzzy::ConditionNode& node) {
      return node.kind == fuzzy::ConditionNode::Kind::proposition && node.proposition.input == input;
    });
  });
}

}  // namespace

std::string guesses_text(const std::vector<SceneGuess>& guesses) {
  std::string text;
  for (const SceneGuess& guess : guesses) {
    text += fmt::format("  {} = {}, from '{}' by {}\n", guess.key, text_of(guess), guess.words,
                        printable(guess.rules_name));
    if (guess.term)
      text += fmt::format("      {} is {}\n", output_of(guess).name, output_of(guess).terms[*guess.term].name);
    for (const Applied& applied : rules_of(guess))
      text += fmt::format("      rule {}, activation {:.3g}: {}\n", rule_name(applied), applied.activation,
                          text_of(*guess.rules, *applied.rule));
  }
  return text.empty() ? text : "\nFirst guesses from words:\n" + text;
}

nlohmann::ordered_json guesses_json(const std::vector<SceneGuess>& guesses) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const SceneGuess& guess : guesses) {
    nlohmann::ordered_json terms = nlohmann::ordered_json::object(), rules = nlohmann::ordered_json::array();
    for (const auto& [name, activation] : terms_of(guess)) terms[name] = activation;
    for (const Applied& applied : rules_of(guess))
      rules.push_back({{"rule", rule_name(applied)},
                       {"activation", applied.activation},
                       {"text", text_of(*guess.rules, *applied.rule)}});
    all.push_back({{"key", guess.key},
                   {"words", guess.words},
                   {"value", guess.value},
                   {"width", guess.width},
                   {"width_is_of", guess.is_logarithmic ? "decimal logarithm" : "value"},
                   {"rule_base", guess.rules_name},
                   {"output", output_of(guess).name},
                   {"terms", terms},
                   {"rules", rules}});
  }
  return all;
}

std::vector<figure::Figure> guess_figures(const std::vector<SceneGuess>& guesses) {
  std::vector<figure::Figure> figures;
  for (const SceneGuess& guess : guesses) {
    figure::Figure drawn;
    drawn.title = guess.key;
    drawn.notes = {fmt::format("'{}' stands for {}", guess.words, text_of(guess))};
    const std::vector<Applied> rules = rules_of(guess);
    for (const Applied& applied : rules)
      drawn.notes.push_back(fmt::format("rule {}, activation {:.3g}: {}", rule_name(applied), applied.activation,
                                        text_of(*guess.rules, *applied.rule)));
    for (std::size_t i = 0; i < guess.inputs.size(); ++i)
      if (guess.inputs[i] && is_read(rules, i))
        drawn.panels.push_back(input_panel(guess.rules->inputs[i], *guess.inputs[i]));
    figure::FigurePanel result = output_panel(guess);
    if (!result.curves.empty()) drawn.panels.push_back(std::move(result));
    figures.push_back(std::move(drawn));
  }
  return figures;
}

}  // namespace springnet::tool
