#include "guess_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <springnet/printable.hpp>

namespace springnet::tool {

namespace {

const fuzzy::Rule& rule_of(const SceneGuess& guess, const fuzzy::RuleActivation& applied) {
  return guess.rules->blocks[applied.block].rules[applied.rule];
}

std::string rule_name(const SceneGuess& guess, const fuzzy::RuleActivation& applied) {
  const std::string &block = guess.rules->blocks[applied.block].name, &rule = rule_of(guess, applied).name;
  return block.empty() ? rule : fmt::format("{} {}", block, rule);
}

// "rule words 4, activation 0.2: if feel is hard then …"
std::string text_of(const SceneGuess& guess, const fuzzy::RuleActivation& applied) {
  return fmt::format("rule {}, activation {:.3g}: {}", rule_name(guess, applied), applied.activation,
                     text_of(*guess.rules, rule_of(guess, applied)));
}

const fuzzy::Output& output_of(const SceneGuess& guess) { return guess.rules->outputs[guess.output]; }

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
  const Interval range{std::min(input.smallest, value), std::max(input.largest, value)};
  for (const fuzzy::Term& term : input.terms) panel.curves.push_back(curve_of(term, range, degree_of(term, value)));
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
  for (std::size_t i = 0; i < output.terms.size(); ++i)
    if (has_degrees(output.terms[i]))
      panel.curves.push_back(curve_of(output.terms[i], range, guess.number.activations[i]));
  if (!guess.term && !set.y.empty()) panel.curves.push_back(std::move(set));
  const double value = guess.number.value;
  if (guess.width > 0.0) panel.marks.push_back({value - guess.width, value + guess.width, "width"});
  panel.marks.push_back({value, value, fmt::format("{:.4g}", value)});
  return panel;
}

// Whether a rule that applies is about the input.
bool is_read(const SceneGuess& guess, std::size_t input) {
  return std::any_of(guess.number.rules.begin(), guess.number.rules.end(),
                     [&](const fuzzy::RuleActivation& each) { return reads(rule_of(guess, each), input); });
}

}  // namespace

std::string guesses_text(const std::vector<SceneGuess>& guesses) {
  std::string text;
  for (const SceneGuess& guess : guesses) {
    text += fmt::format("  {} = {}, from '{}' by {}\n", guess.key, text_of(guess), guess.words,
                        printable(guess.rules_name));
    if (guess.term)
      text += fmt::format("      {} is {}\n", output_of(guess).name, output_of(guess).terms[*guess.term].name);
    for (const fuzzy::RuleActivation& applied : guess.number.rules)
      text += fmt::format("      {}\n", text_of(guess, applied));
    if (guess.number.is_otherwise) text += "      DEFAULT, because no rule applies\n";
  }
  return text.empty() ? text : "\nFirst guesses from words:\n" + text;
}

nlohmann::ordered_json guesses_json(const std::vector<SceneGuess>& guesses) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const SceneGuess& guess : guesses) {
    nlohmann::ordered_json terms = nlohmann::ordered_json::object(), rules = nlohmann::ordered_json::array();
    const std::vector<double>& activations = guess.number.activations;
    for (std::size_t i = 0; i < activations.size(); ++i)
      if (activations[i] > 0.0) terms[output_of(guess).terms[i].name] = activations[i];
    for (const fuzzy::RuleActivation& applied : guess.number.rules)
      rules.push_back({{"rule", rule_name(guess, applied)},
                       {"activation", applied.activation},
                       {"text", text_of(*guess.rules, rule_of(guess, applied))}});
    all.push_back({{"key", guess.key},
                   {"words", guess.words},
                   {"value", guess.value},
                   {"unit", guess.unit},
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
    for (const fuzzy::RuleActivation& applied : guess.number.rules) drawn.notes.push_back(text_of(guess, applied));
    for (std::size_t i = 0; i < guess.inputs.size(); ++i)
      if (guess.inputs[i] && is_read(guess, i))
        drawn.panels.push_back(input_panel(guess.rules->inputs[i], *guess.inputs[i]));
    figure::FigurePanel result = output_panel(guess);
    if (!result.curves.empty()) drawn.panels.push_back(std::move(result));
    figures.push_back(std::move(drawn));
  }
  return figures;
}

}  // namespace springnet::tool
