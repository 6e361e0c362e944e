#include "scene/words.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/printable.hpp>
#include <springnet/sdk/math.hpp>
#include <springnet/suggestion.hpp>

#include "scene/keys.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {
namespace {

using fuzzy::RuleBase;

constexpr std::string_view logarithm = "log10_";

// "very soft" and "Very-Soft" are the term very_soft.
std::string term_name(std::string_view words) {
  std::string name;
  for (const char c : words)
    name += c == ' ' || c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

// A text that may be meant as a term: not "3 N/m", nor a formula.
bool is_words(const toml::node& node) {
  const auto* const text = node.as_string();
  if (text == nullptr || text->get().empty()) return false;
  const auto is_letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  return is_letter(text->get()[0]) && std::all_of(text->get().begin(), text->get().end(), [&](char c) {
           return is_letter(c) || (c >= '0' && c <= '9') || c == ' ' || c == '-' || c == '_';
         });
}

std::optional<std::size_t> find_term(const fuzzy::Variable& variable, std::string_view words) {
  const std::string name = term_name(words);
  for (std::size_t i = 0; i < variable.terms.size(); ++i)
    if (term_name(variable.terms[i].name) == name) return i;
  return std::nullopt;
}

// Names of terms as a scene writes them.
std::vector<std::string> words_of(const fuzzy::Variable& variable) {
  std::vector<std::string> words;
  for (const fuzzy::Term& term : variable.terms) {
    std::string& name = words.emplace_back(term.name);
    std::replace(name.begin(), name.end(), '_', ' ');
  }
  return words;
}

std::string nearest_or_all(std::string_view words, const std::vector<std::string>& known) {
  const std::string nearest = suggestion(words, known);
  return nearest.empty() ? fmt::format("known: {}", fmt::join(known, ", ")) : nearest;
}

class Words {
 public:
  Words(toml::table& root, std::string_view document, const Files& files) : root_(root), document_(document) {
    const toml::node* const rules = root.get("rules");
    if (rules == nullptr) {
      name_ = "soft_tissue.fcl";
      base_ = std::shared_ptr<const RuleBase>(std::shared_ptr<void>(), &fuzzy::soft_tissue());
      return;
    }
    const Value file(*rules, "rules", document);
    name_ = file.text();
    const std::filesystem::path path = files.resolve(file);
    file.at_this_place([&] { base_ = std::make_shared<const RuleBase>(fuzzy::read_rules(path)); });
  }

  std::vector<SceneGuess> replace() {
    if (toml::array* const bodies = root_.get_as<toml::array>("body"))
      for (std::size_t i = 0; i < bodies->size(); ++i)
        if (toml::table* const body = bodies->get(i)->as_table()) replace_material(*body, fmt::format("body.{}", i));
    for (auto&& [key, node] : root_)
      if (key != "title" && key != "simulation" && key != "output" && key != "rules")
        replace_terms(node, std::string(key.str()));
    return std::move(guesses_);
  }

 private:
  // The output for a key, by its own name or as its logarithm.
  [[nodiscard]] std::optional<std::size_t> output_of(std::string_view key) const {
    for (std::size_t i = 0; i < base_->outputs.size(); ++i) {
      std::string_view name = base_->outputs[i].name;
      if (name.starts_with(logarithm)) name.remove_prefix(logarithm.size());
      if (name == key) return i;
    }
    return std::nullopt;
  }

  // Writes a guess to the table as a number whose place is that of the words.
  void insert(toml::table& table, std::string_view key, const std::string& path, const Value& place, SceneGuess guess,
              const fuzzy::Guess& number) {
    guess.key = path;
    guess.width = number.width;
    guess.is_logarithmic = base_->outputs[guess.output].name.starts_with(logarithm);
    guess.value = guess.is_logarithmic ? sdk::pow(10.0, number.value) : number.value;
    if (!std::isfinite(guess.value))
      place.fail(fmt::format("stands for 10^{} by the rules of {}; correct these", number.value, name_));
    guess.rules = base_;
    guess.rules_name = name_;
    const std::string where = place.where();
    toml::table made =
        toml::parse(std::string_view("value = 0.0"), where.substr(0, where.size() - place.path().size() - 2));
    *made.get_as<double>("value") = guess.value;
    table.insert_or_assign(key, std::move(*made.get_as<double>("value")));
    guesses_.push_back(std::move(guess));
  }

  // The number of an input: where its term lies, or as given.
  double read_input(const fuzzy::Variable& input, const Value& value) const {
    if (value.is_number()) {
      const double number = value.number();
      if (number < input.smallest || number > input.largest)
        value.fail(fmt::format("must be from {} to {} by the rules of {}, is {}", input.smallest, input.largest, name_,
                               number));
      return number;
    }
    const std::string words = value.text();
    const std::optional<std::size_t> term = find_term(input, words);
    if (!term)
      value.fail(fmt::format("'{}' is no term of it in {}; {}", printable(words), name_,
                             nearest_or_all(words, words_of(input))));
    return centre_of(input, input.terms[*term]);
  }

  void replace_material(toml::table& body, const std::string& path) {
    toml::table* const material = body.get_as<toml::table>("material");
    if (material == nullptr) return;
    const std::vector<std::string> keys = keys_in("body.material");
    SceneGuess guess;
    guess.inputs.resize(base_->inputs.size());
    std::vector<std::string> said;
    for (std::size_t i = 0; i < base_->inputs.size(); ++i) {
      const fuzzy::Variable& input = base_->inputs[i];
      const toml::node* const node = material->get(input.name);
      if (node == nullptr || std::find(keys.begin(), keys.end(), input.name) != keys.end()) continue;
      const Value value(*node, fmt::format("{}.material.{}", path, input.name), document_);
      guess.inputs[i] = read_input(input, value);
      said.push_back(fmt::format("{} = {}", input.name,
                                 value.is_text() ? printable(value.text()) : fmt::format("{}", *guess.inputs[i])));
    }
    check_words(*material, path, keys);
    if (said.empty()) return;
    guess.words = fmt::format("{}", fmt::join(said, ", "));
    const Value place(*material, path + ".material", document_);
    const fuzzy::Evaluation evaluation = fuzzy::evaluate(*base_, guess.inputs);
    const auto offer = [&](toml::table& table, std::string_view key, const std::string& owner) {
      const std::optional<std::size_t> output = output_of(key);
      if (table.contains(key) || !output || !evaluation.outputs[*output]) return;
      guess.output = *output;
      insert(table, key, fmt::format("{}.{}", owner, key), place, guess, *evaluation.outputs[*output]);
    };
    const std::string owner = path + ".material";
    for (const char* key : {"youngs_modulus", "poisson_ratio"}) offer(*material, key, owner);
    if (!body.contains("viscosity")) offer(*material, "damping_time", owner);
    const toml::table* const neuron = body.get_as<toml::table>("neuron");
    if (!body.contains("masses") && !(neuron != nullptr && neuron->contains("mass"))) offer(body, "density", path);
    if (!material->contains("youngs_modulus"))
      place.fail(
          fmt::format("{} says nothing of youngs_modulus by the rules of {}; add a word that does ({}), or the "
                      "number",
                      guess.words, name_, fmt::join(inputs_that_give("youngs_modulus"), ", ")));
    for (const fuzzy::Variable& input : base_->inputs)
      if (std::find(keys.begin(), keys.end(), input.name) == keys.end()) material->erase(input.name);
  }

  // A key with words that is neither of a material nor an input.
  void check_words(const toml::table& material, const std::string& path, std::vector<std::string> known) const {
    for (const fuzzy::Variable& input : base_->inputs) known.push_back(input.name);
    for (auto&& [key, node] : material) {
      if (!is_words(node) || std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      Value(node, fmt::format("{}.material.{}", path, printable(key.str())), document_)
          .fail(fmt::format("unknown key; {}", nearest_or_all(key.str(), known)));
    }
  }

  // Inputs that a rule about the output reads.
  [[nodiscard]] std::vector<std::string> inputs_that_give(std::string_view key) const {
    std::vector<std::string> names;
    const std::optional<std::size_t> output = output_of(key);
    for (std::size_t i = 0; output && i < base_->inputs.size(); ++i)
      if (gives(i, *output)) names.push_back(base_->inputs[i].name);
    return names;
  }
  static bool reads(const fuzzy::Rule& rule, std::size_t input) {
    return std::any_of(rule.condition.begin(), rule.condition.end(), [&](const fuzzy::ConditionNode& node) {
      return node.kind == fuzzy::ConditionNode::Kind::proposition && node.proposition.input == input;
    });
  }
  static bool concludes(const fuzzy::Rule& rule, std::size_t output) {
    return std::any_of(rule.conclusions.begin(), rule.conclusions.end(),
                       [&](const fuzzy::Conclusion& each) { return each.output == output; });
  }

  // Terms where a key has the name of an output, here and below.
  void replace_terms(toml::node& node, const std::string& path) {
    if (toml::array* const list = node.as_array()) {
      if (list->empty() || !list->get(0)->is_table()) return;
      for (std::size_t i = 0; i < list->size(); ++i) replace_terms(*list->get(i), fmt::format("{}.{}", path, i));
      return;
    }
    toml::table* const table = node.as_table();
    if (table == nullptr) return;
    std::vector<std::string> with_words;
    for (auto&& [key, value] : *table) {
      if (is_words(value) && output_of(key.str()))
        with_words.emplace_back(key.str());
      else
        replace_terms(value, fmt::format("{}.{}", path, key.str()));
    }
    for (const std::string& key : with_words)
      replace_term(*table, key, Value(*table->get(key), fmt::format("{}.{}", path, key), document_));
  }

  void replace_term(toml::table& table, const std::string& key, const Value& value) {
    SceneGuess guess;
    guess.output = *output_of(key);
    const fuzzy::Output& output = base_->outputs[guess.output];
    const std::string words = value.text();
    guess.words = printable(words);
    guess.inputs.resize(base_->inputs.size());
    std::optional<fuzzy::Guess> number;
    if ((guess.term = find_term(output, words))) {
      number = guess_of_term(*base_, guess.output, *guess.term);
      if (!number) value.fail(fmt::format("is no number whatever the inputs, by the rules of {}; write one", name_));
    } else {
      number = guess_by_input(guess, words, value);
    }
    insert(table, key, value.path(), value, guess, *number);
  }

  // A term of one input, by the rules that read it.
  fuzzy::Guess guess_by_input(SceneGuess& guess, const std::string& words, const Value& value) const {
    std::vector<std::string> meanings;
    std::optional<fuzzy::Guess> number;
    for (std::size_t i = 0; i < base_->inputs.size(); ++i) {
      const fuzzy::Variable& input = base_->inputs[i];
      const std::optional<std::size_t> term = gives(i, guess.output) ? find_term(input, words) : std::nullopt;
      if (!term) continue;
      fuzzy::Inputs alone(base_->inputs.size());
      alone[i] = centre_of(input, input.terms[*term]);
      const std::optional<fuzzy::Guess> of_term = fuzzy::evaluate(*base_, alone).outputs[guess.output];
      if (!of_term || of_term->is_otherwise) continue;
      meanings.push_back(input.name);
      number = of_term;
      guess.inputs = alone;
      guess.words = fmt::format("{} = {}", input.name, printable(words));
    }
    if (meanings.size() > 1)
      value.fail(fmt::format("'{}' may be {}; rename a term in {}, or write the number", printable(words),
                             fmt::join(meanings, " or "), name_));
    if (!number)
      value.fail(fmt::format("must be a number, or a term that {} has for it; '{}' is none; {}", name_,
                             printable(words), nearest_or_all(words, words_for(guess.output))));
    return *number;
  }

  // Whether a rule about the output reads the input.
  [[nodiscard]] bool gives(std::size_t input, std::size_t output) const {
    return std::any_of(base_->blocks.begin(), base_->blocks.end(), [&](const fuzzy::RuleBlock& block) {
      return std::any_of(block.rules.begin(), block.rules.end(),
                         [&](const fuzzy::Rule& rule) { return reads(rule, input) && concludes(rule, output); });
    });
  }
  // Of the output itself, and of the inputs that it depends on; sorted.
  [[nodiscard]] std::vector<std::string> words_for(std::size_t output) const {
    std::vector<std::string> known = words_of(base_->outputs[output]);
    for (std::size_t i = 0; i < base_->inputs.size(); ++i) {
      if (!gives(i, output)) continue;
      const std::vector<std::string> own = words_of(base_->inputs[i]);
      known.insert(known.end(), own.begin(), own.end());
    }
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    return known;
  }

  toml::table& root_;
  std::string_view document_;
  std::string name_;
  std::shared_ptr<const RuleBase> base_;
  std::vector<SceneGuess> guesses_;
};

}  // namespace

std::vector<SceneGuess> replace_words(toml::table& root, std::string_view document, const Files& files) {
  return Words(root, document, files).replace();
}

}  // namespace springnet::scene

namespace springnet {

std::string text_of(const SceneGuess& guess) {
  const std::string value = fmt::format("{:.4g}", guess.value);
  if (!(guess.width > 0.0)) return value;
  if (guess.is_logarithmic) return fmt::format("{} (to a factor of {:.2g})", value, std::pow(10.0, guess.width));
  return fmt::format("{} (+- {:.2g})", value, guess.width);
}

}  // namespace springnet
