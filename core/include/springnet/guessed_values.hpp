// A scene's first guesses as what learning knows beforehand, and what learned values say of the guesses.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <springnet/export.hpp>
#include <springnet/learn.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/rule_correction.hpp>
#include <springnet/scene.hpp>
#include <springnet/scene_guesses.hpp>

namespace springnet {

class SPRINGNET_API GuessedValues {
 public:
  // How the values of the scene's network that are learned depend on the numbers that words stand for: the scene is
  // read once more for each guess, with that number changed. Throws as load_scene() and learn() do.
  GuessedValues(const std::filesystem::path& file, const std::shared_ptr<const PluginHost>& plugins,
                const std::vector<Learnable>& learnables, const std::vector<SceneOverride>& overrides = {},
                OutsideFiles outside = OutsideFiles::refused);

  // Those that a learned value depends on.
  [[nodiscard]] const std::vector<SceneGuess>& guesses() const noexcept { return guesses_; }
  // d ln(value) / d ln(guess), [value][guess]; values in the order of MotionDerivatives. 0 of values that are 0.
  [[nodiscard]] const Eigen::MatrixXd& influence() const noexcept { return influence_; }

  // Sets Learnable::guess_widths, and by_logarithm where the guess is one of it. A guess is one piece of knowledge, of
  // all n values of a learnable that follow it: as much as n values that are known sqrt(n) times less well.
  void set_widths(std::vector<Learnable>& learnables) const;

  // What the learned values say that the guesses should have been, of those that they tell apart; `guess` is a place in
  // guesses(). From the intervals of values, or equal shares where none has one, with their scatter. Throws
  // Error(input) if it was not these learnables that were learned.
  struct Found {
    std::size_t guess = 0;
    fuzzy::Example example;
  };
  [[nodiscard]] std::vector<Found> examples(const LearnedNet& learned) const;

 private:
  std::vector<SceneGuess> guesses_;
  Eigen::MatrixXd influence_;
};

}  // namespace springnet
