#include "learn_guesses.hpp"

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>
#include <springnet/printable.hpp>
#include <springnet/rule_correction.hpp>

namespace springnet::tool {

namespace {

// In the unit of the scene's number.
std::string number_of(const SceneGuess& guess, double value) {
  return fmt::format("{:.4g}", guess.is_logarithmic ? std::pow(10.0, value) : value);
}

OutsideFiles outside_of(const SceneArguments& scene) {
  return scene.allow_outside ? OutsideFiles::allowed : OutsideFiles::refused;
}

// Numbers that differ, to as many digits as they are known at the best.
void round_changes(const fuzzy::RuleBase& before, fuzzy::RuleBase& after) {
  for (std::size_t o = 0; o < after.outputs.size(); ++o)
    for (std::size_t t = 0; t < after.outputs[o].terms.size(); ++t) {
      std::vector<double>& numbers = after.outputs[o].terms[t].numbers;
      for (std::size_t k = 0; k < numbers.size(); ++k)
        if (numbers[k] != before.outputs[o].terms[t].numbers[k])
          numbers[k] = std::strtod(fmt::format("{:.6g}", numbers[k]).c_str(), nullptr);
    }
}

// As it stands in the file, with its comments; the scene has read it.
std::string fcl_of(const SceneGuess& guess, const SceneArguments& scene) {
  if (guess.rules.get() == &fuzzy::soft_tissue()) return std::string(fuzzy::soft_tissue_fcl());
  std::ifstream in(scene.file.parent_path() / guess.rules_name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

std::unique_ptr<const GuessedValues> guesses_of(const SceneArguments& scene,
                                                const std::shared_ptr<const PluginHost>& host,
                                                const std::vector<Learnable>& learnables) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(scene.file, unknown)) return nullptr;
  std::vector<SceneOverride> overrides;
  for (const std::string& set : scene.sets) overrides.push_back(parse_override(set));
  auto guesses = std::make_unique<const GuessedValues>(scene.file, host, learnables, overrides, outside_of(scene));
  if (guesses->guesses().empty()) return nullptr;
  return guesses;
}

CorrectedRules corrected_rules(const GuessedValues& guesses, const LearnedNet& learned, const SceneArguments& scene) {
  const std::vector<GuessedValues::Found> found = guesses.examples(learned);
  if (found.empty())
    return {
        "",
        {"What was learned does not tell what the guesses should have been: learned.fcl is not written. Learn values "
         "that words stand for, and of which the observations determine enough."}};
  std::vector<fuzzy::Example> examples;
  for (const GuessedValues::Found& each : found) examples.push_back(each.example);
  const SceneGuess& first = guesses.guesses().front();
  fuzzy::Correction correction;
  CorrectedRules result;
  try {
    correction = fuzzy::correct(*first.rules, examples);
    round_changes(*first.rules, correction.base);
    // The file may be another one by now.
    result.fcl =
        "// Corrected by springnet learn: numbers of outputs' terms are learned, comments on them are those of the "
        "original.\n" +
        fuzzy::with_numbers_of(fcl_of(first, scene), correction.base);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::input) throw;
    return {"", {fmt::format("The rules are not corrected, learned.fcl is not written: {}", error.what())}};
  }
  for (std::size_t k = 0; k < found.size(); ++k) {
    const SceneGuess& guess = guesses.guesses()[found[k].guess];
    const auto& corrected = correction.after[k];
    result.notes.push_back(fmt::format("{} from '{}': guessed {}, learned {}, by the corrected rules {}.", guess.key,
                                       printable(guess.words), number_of(guess, correction.before[k]->value),
                                       number_of(guess, examples[k].value),
                                       corrected ? number_of(guess, corrected->value) : "nothing"));
  }
  return result;
}

}  // namespace springnet::tool
