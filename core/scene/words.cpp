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

#include "scene/document.hpp"
#include "scene/formula.hpp"
#include "scene/keys.hpp"
#include "scene/reader.hpp"
#include "scene/terms.hpp"

namespace springnet::scene {
namespace {

using fuzzy::RuleBase;

// A text that may be meant as a term: not "3 N/m", nor a formula.
bool is_words(const toml::node& node) {
  const auto* const text = node.as_string();
  if (text == nullptr || text->get().empty()) return false;
  const auto is_letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  return is_letter(text->get()[0]) && std::all_of(text->get().begin(), text->get().end(), [&](char c) {
           return is_letter(c) || (c >= '0' && c <= '9') || c == ' ' || c == '-' || c == '_';
         });
}

bool is_number(std::string_view form) { return form.find("a number") != std::string_view::npos; }

// Whether the form of the key has the text among its own: plane.friction is 'held', 'none' or a number.
bool is_own_text(std::string_view key, const toml::node& node) {
  const std::string quoted = fmt::format("'{}'", node.as_string()->get());
  const std::vector<KeyForm> keys = keys_named(key);
  return std::any_of(keys.begin(), keys.end(),
                     [&](const KeyForm& each) { return each.form.find(quoted) != std::string_view::npos; });
}

// Words must not stand where a scene has a text of another meaning: no output has the name of such a key, no input that
// of a key of materials.
void check_names(const RuleBase& base) {
  for (const fuzzy::Output& output : base.outputs)
    for (const KeyForm& each : keys_named(key_of(output)))
      if (!is_number(each.form))
        throw Error(ErrorKind::input, fmt::format("output '{}' has the name of a key that is no number in scenes ({}: "
                                                  "{}); rename the output",
                                                  output.name, each.path, each.form));
  const std::vector<std::string> keys = keys_in("body.material");
  for (const fuzzy::Variable& input : base.inputs)
    if (std::find(keys.begin(), keys.end(), input.name) != keys.end())
      throw Error(ErrorKind::input, fmt::format("input '{0}' has the name of a key of scenes (body.material.{0}), so "
                                                "that no scene can give it; rename the input",
                                                input.name));
}

// The unit that the form of a key ends with: "a number above 0, Pa".
std::string unit_of_key(std::string_view path) {
  std::string schema;
  for (std::size_t begin = 0; begin < path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string_view step = path.substr(begin, end - begin);
    if (step.find_first_not_of("0123456789") != std::string_view::npos)
      schema += fmt::format("{}{}", schema.empty() ? "" : ".", step);
    begin = end + 1;
  }
  for (const KeyForm& each : keys_named(path.substr(path.rfind('.') + 1))) {
    if (each.path != schema || !each.form.starts_with("a number")) continue;
    const std::size_t comma = each.form.rfind(", ");
    if (comma == std::string_view::npos) continue;
    const std::string_view unit = each.form.substr(comma + 2);
    if (unit.find(' ') == std::string_view::npos) return std::string(unit);  // not "m^2 or m^3"
  }
  return {};
}

// Of a component's parameter, in a table with its type under one of these keys.
std::string unit_of_parameter(const toml::table& table, const std::string& path, std::string_view parameter,
                              const PluginHost& plugins) {
  constexpr std::pair<std::string_view, ComponentKind> kinds[] = {{".spring.", ComponentKind::spring_function},
                                                                  {".law.", ComponentKind::spring_function},
                                                                  {".viscosity.", ComponentKind::viscosity_function},
                                                                  {".neuron.", ComponentKind::neuron}};
  const toml::value<std::string>* const type = table.get_as<std::string>("type");
  if (type == nullptr) return {};
  for (const auto& [owner, kind] : kinds) {
    if (!path.ends_with(fmt::format("{}{}", owner, parameter))) continue;
    const std::shared_ptr<const Component> component = plugins.find(kind, type->get());
    const std::ptrdiff_t index = component == nullptr ? -1 : parameter_index(*component->description, parameter);
    if (index < 0) return {};
    const std::string_view unit = component->description->parameters[index]->unit;
    return unit == "1" ? std::string() : std::string(unit);
  }
  return {};
}

class Words {
 public:
  Words(toml::table& root, std::string_view document, const Files& files, const PluginHost* plugins)
      : root_(root), document_(document), plugins_(plugins), evaluator_(read(root, document, files)) {
    const toml::node* const rules = root.get("rules");
    name_ = rules == nullptr ? "soft_tissue.fcl" : Value(*rules, "rules", document).text();
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
  static std::shared_ptr<const RuleBase> read(const toml::table& root, std::string_view document, const Files& files) {
    const toml::node* const rules = root.get("rules");
    if (rules == nullptr) return {std::shared_ptr<void>(), &fuzzy::soft_tissue()};
    const Value file(*rules, "rules", document);
    const std::filesystem::path path = files.resolve(file);
    return file.at_this_place([&] {
      auto base = std::make_shared<const RuleBase>(fuzzy::read_rules(path));
      try {
        check_names(*base);
      } catch (const Error& error) {
        throw Error(error.kind(), fmt::format("{}: {}", printable(path.string()), error.what()));
      }
      return base;
    });
  }
  [[nodiscard]] const RuleBase& base() const { return *evaluator_.base(); }

  // Writes a guess to the table as a number whose place is that of the words.
  void insert(toml::table& table, std::string_view key, const std::string& path, const Value& words, SceneGuess guess,
              const fuzzy::Guess& number) {
    guess.key = path;
    guess.number = number;
    guess.width = number.width;
    guess.is_logarithmic = is_logarithm(base().outputs[guess.output]);
    guess.value = guess.is_logarithmic ? sdk::pow(10.0, number.value) : number.value;
    if (!std::isfinite(guess.value))
      words.fail(fmt::format("stands for 10^{} by the rules of {}; correct these", number.value, name_));
    guess.unit = unit_of_key(path);
    if (guess.unit.empty() && plugins_ != nullptr) guess.unit = unit_of_parameter(table, path, key, *plugins_);
    guess.rules = evaluator_.base();
    guess.rules_name = name_;
    table.insert_or_assign(key, number_at(guess.value, words.place()));
    guesses_.push_back(std::move(guess));
  }

  // The number of an input: where its term lies, or as given.
  double read_input(const fuzzy::Variable& input, const Value& value) const {
    if (value.is_number()) {
      const double number = value.number();
      if (input.has_range && (number < input.smallest || number > input.largest))
        value.fail(fmt::format("must be from {} to {} by the rules of {}, is {}", input.smallest, input.largest, name_,
                               number));
      return number;
    }
    const std::vector<std::string> known = words_of(input);
    if (!value.is_text())
      value.wrong_type(fmt::format("{}a number{} by the rules of {}",
                                   known.empty() ? "" : fmt::format("one of '{}', or ", fmt::join(known, "', '")),
                                   input.has_range ? fmt::format(" from {} to {}", input.smallest, input.largest) : "",
                                   name_));
    const std::string words = value.text();
    const std::optional<std::size_t> term = find_term(input, words);
    if (!term)
      value.fail(fmt::format("'{}' is no term of it in {}; {}", printable(words), name_, nearest_or_all(words, known)));
    return centre_of(input, input.terms[*term]);
  }

  // What a body says of the inputs: "feel = soft" of each that it gives.
  using Said = std::vector<std::string>;
  // Of the inputs that rules of the guess read; of all, if it is the DEFAULT, for which no rule applies.
  [[nodiscard]] std::string words_that_count(const Said& said, const fuzzy::Guess& number) const {
    std::vector<std::string> count;
    for (std::size_t i = 0; i < said.size(); ++i) {
      const bool is_read = std::any_of(
          number.rules.begin(), number.rules.end(),
          [&](const fuzzy::RuleActivation& each) { return reads(base().blocks[each.block].rules[each.rule], i); });
      if (!said[i].empty() && (is_read || number.is_otherwise)) count.push_back(said[i]);
    }
    return fmt::format("{}", fmt::join(count, ", "));
  }

  void replace_material(toml::table& body, const std::string& path) {
    toml::table* const material = body.get_as<toml::table>("material");
    if (material == nullptr) return;
    const std::string owner = path + ".material";
    fuzzy::Inputs inputs(base().inputs.size());
    Said said(base().inputs.size());
    std::string all;
    for (std::size_t i = 0; i < base().inputs.size(); ++i) {
      const fuzzy::Variable& input = base().inputs[i];
      const toml::node* const node = material->get(input.name);
      if (node == nullptr) continue;
      const Value value(*node, fmt::format("{}.{}", owner, input.name), document_);
      inputs[i] = read_input(input, value);
      said[i] =
          fmt::format("{} = {}", input.name, value.is_text() ? printable(value.text()) : fmt::format("{}", *inputs[i]));
      all += (all.empty() ? "" : ", ") + said[i];
    }
    check_words(*material, owner);
    if (all.empty()) return;
    const Value place(*material, owner, document_);
    const auto offer = [&](toml::table& table, std::string_view key, const std::string& of) {
      const std::optional<std::size_t> output = find_output(base(), key);
      if (table.contains(key) || !output) return;
      const std::optional<fuzzy::Guess> number = place.at_this_place([&] { return evaluator_.guess(*output, inputs); });
      if (!number) return;
      SceneGuess guess;
      guess.output = *output;
      guess.inputs = inputs;
      guess.words = words_that_count(said, *number);
      insert(table, key, fmt::format("{}.{}", of, key), place, std::move(guess), *number);
    };
    for (const char* key : {"youngs_modulus", "poisson_ratio"}) offer(*material, key, owner);
    if (!body.contains("viscosity")) offer(*material, "damping_time", owner);
    if (needs_density(body)) offer(body, "density", path);
    if (!material->contains("youngs_modulus")) {
      const std::optional<std::size_t> output = find_output(base(), "youngs_modulus");
      const std::vector<std::string> more = output ? inputs_that_give(base(), *output) : std::vector<std::string>{};
      place.fail(fmt::format(
          "{} says nothing of youngs_modulus by the rules of {}; add {}", all, name_,
          more.empty() ? "the number" : fmt::format("a word that does ({}), or the number", fmt::join(more, ", "))));
    }
    for (const fuzzy::Variable& input : base().inputs) material->erase(input.name);
  }

  // Neither masses that the scene says, nor a cloud of points, which have no volume.
  static bool needs_density(const toml::table& body) {
    const toml::table* const neuron = body.get_as<toml::table>("neuron");
    const toml::table* const mesh = body.get_as<toml::table>("mesh");
    return !body.contains("masses") && !body.contains("mass") && !(neuron != nullptr && neuron->contains("mass")) &&
           !(mesh != nullptr && mesh->contains("points"));
  }

  // A key with words that is neither of a material nor an input.
  void check_words(const toml::table& material, const std::string& path) const {
    std::vector<std::string> known = keys_in("body.material");
    for (const fuzzy::Variable& input : base().inputs) known.push_back(input.name);
    for (auto&& [key, node] : material) {
      if (!is_words(node) || std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      Value(node, fmt::format("{}.{}", path, printable(key.str())), document_)
          .fail(fmt::format("unknown key, and no input of {}; {}", name_, nearest_or_all(key.str(), known)));
    }
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
    const bool is_formula = table->contains("formula") || table->contains("energy");
    std::vector<std::string> with_words;
    for (auto&& [key, value] : *table) {
      if (is_formula && is_key_of_formulas(key.str())) continue;
      if (is_words(value) && find_output(base(), key.str()) && !is_own_text(key.str(), value))
        with_words.emplace_back(key.str());
      else
        replace_terms(value, fmt::format("{}.{}", path, key.str()));
    }
    for (const std::string& key : with_words)
      replace_term(*table, key, Value(*table->get(key), fmt::format("{}.{}", path, key), document_));
  }

  void replace_term(toml::table& table, const std::string& key, const Value& value) {
    SceneGuess guess;
    guess.output = *find_output(base(), key);
    const fuzzy::Output& output = base().outputs[guess.output];
    const std::string words = value.text();
    guess.words = printable(words);
    guess.inputs.resize(base().inputs.size());
    if (!(guess.term = find_term(output, words))) {
      const fuzzy::Guess number = guess_by_input(guess, words, value);
      insert(table, key, value.path(), value, std::move(guess), number);
      return;
    }
    const std::optional<fuzzy::Guess>& number = evaluator_.guess_of_term(guess.output, *guess.term);
    if (!number) value.fail(fmt::format("is no number whatever the inputs, by the rules of {}; write one", name_));
    insert(table, key, value.path(), value, std::move(guess), *number);
  }

  // A term of one input, by the rules that read it.
  fuzzy::Guess guess_by_input(SceneGuess& guess, const std::string& words, const Value& value) {
    std::vector<std::string> meanings;
    std::optional<fuzzy::Guess> number;
    for (std::size_t i = 0; i < base().inputs.size(); ++i) {
      const fuzzy::Variable& input = base().inputs[i];
      const std::optional<std::size_t> term = gives(base(), i, guess.output) ? find_term(input, words) : std::nullopt;
      if (!term) continue;
      fuzzy::Inputs alone(base().inputs.size());
      alone[i] = centre_of(input, input.terms[*term]);
      const std::optional<fuzzy::Guess>& of_term = evaluator_.guess(guess.output, alone);
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
                             printable(words), nearest_or_all(words, words_for(base(), guess.output))));
    return *number;
  }

  toml::table& root_;
  std::string_view document_;
  const PluginHost* plugins_;
  std::string name_;
  fuzzy::Evaluator evaluator_;
  std::vector<SceneGuess> guesses_;
};

}  // namespace

std::vector<SceneGuess> replace_words(toml::table& root, std::string_view document, const Files& files,
                                      const PluginHost* plugins) {
  return Words(root, document, files, plugins).replace();
}

}  // namespace springnet::scene

namespace springnet {

std::string text_of(const SceneGuess& guess) {
  const std::string value = fmt::format("{:.4g}{}{}", guess.value, guess.unit.empty() ? "" : " ", guess.unit);
  if (!(guess.width > 0.0)) return value;
  if (guess.is_logarithmic) return fmt::format("{} (to a factor of {:.2g})", value, std::pow(10.0, guess.width));
  return fmt::format("{} (+- {:.2g})", value, guess.width);
}

std::string note_of(const SceneGuess& guess) {
  const std::string key = guess.key.substr(guess.key.rfind('.') + 1);
  const std::string origin =
      guess.number.is_otherwise
          ? fmt::format("the DEFAULT of {}, because none of its rules applies to '{}'", guess.rules_name, guess.words)
          : fmt::format("a first guess from '{}'", guess.words);
  return fmt::format("{} is {}, {}; 'springnet inspect' shows how it comes about.", key, text_of(guess), origin);
}

}  // namespace springnet
