#include <springnet/guessed_values.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include <springnet/error.hpp>

#include "learning/variables.hpp"

namespace springnet {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of a guess: values that follow it by a power do so to this.
constexpr double step = 1e-4;
constexpr double no_influence = 1e-9;  // rounding over the step

// The standard deviation of a guess, of its natural logarithm or as a share of it.
double relative_width(const SceneGuess& guess) {
  if (guess.is_logarithmic) return std::numbers::ln10 * guess.width;
  return guess.value == 0.0 ? 0.0 : guess.width / std::abs(guess.value);
}

}  // namespace

GuessedValues::GuessedValues(const std::filesystem::path& file, const std::shared_ptr<const PluginHost>& plugins,
                             const std::vector<Learnable>& learnables, const std::vector<SceneOverride>& overrides,
                             OutsideFiles outside) {
  const std::vector<SceneGuess> all = find_guesses(file, overrides, outside);
  if (all.empty()) return;
  const auto values_with = [&](const std::vector<SceneOverride>& own) {
    const auto network = std::make_shared<const Network>(load_scene(file, *plugins, own, outside).network);
    return values_in(network, plugins, learnables);
  };
  const VectorXd start = values_with(overrides);
  std::vector<VectorXd> columns;
  for (const SceneGuess& guess : all) {
    if (guess.value == 0.0) continue;
    std::vector<SceneOverride> own = overrides;
    own.push_back({guess.key, ""});
    // A guess at the bound of what its key may have moves the other way.
    const auto moved_by = [&](double change) -> std::optional<VectorXd> {
      own.back().value = fmt::format("{}", guess.value * (1.0 + change));
      try {
        return values_with(own);
      } catch (const Error& error) {
        if (error.kind() != ErrorKind::input) throw;
        return std::nullopt;
      }
    };
    double change = step;
    std::optional<VectorXd> moved = moved_by(change);
    if (!moved) moved = moved_by(change = -step);
    if (!moved) continue;
    VectorXd column = VectorXd::Zero(start.size());
    for (Index k = 0; k < start.size(); ++k)
      if ((*moved)[k] * start[k] > 0.0) column[k] = std::log((*moved)[k] / start[k]) / std::log1p(change);
    if (!(column.cwiseAbs().maxCoeff() > no_influence)) continue;
    columns.push_back((column.array().abs() > no_influence).select(column, 0.0));
    guesses_.push_back(guess);
  }
  influence_.resize(start.size(), static_cast<Index>(columns.size()));
  for (std::size_t g = 0; g < columns.size(); ++g) influence_.col(static_cast<Index>(g)) = columns[g];
}

void GuessedValues::set_widths(std::vector<Learnable>& learnables) const {
  if (guesses_.empty()) return;
  Index first = 0;
  for (Learnable& each : learnables) {
    const auto count = static_cast<Index>(learning::value_count(each));
    const auto own = influence_.middleRows(first, count);
    first += count;
    VectorXd square = VectorXd::Zero(count);
    for (std::size_t g = 0; g < guesses_.size(); ++g) {
      const VectorXd width = relative_width(guesses_[g]) * own.col(static_cast<Index>(g));
      square += static_cast<double>((width.array() != 0.0).count()) * width.cwiseAbs2();
      each.by_logarithm = each.by_logarithm || (guesses_[g].is_logarithmic && !width.isZero(0.0));
    }
    if (!(square.maxCoeff() > 0.0)) continue;
    each.guess_widths.resize(static_cast<std::size_t>(count));
    for (Index k = 0; k < count; ++k) each.guess_widths[static_cast<std::size_t>(k)] = std::sqrt(square[k]);
  }
}

std::vector<GuessedValues::Found> GuessedValues::examples(const LearnedNet& learned) const {
  if (guesses_.empty()) return {};
  if (static_cast<Index>(learned.parameters.size()) != influence_.rows())
    throw Error(ErrorKind::input, fmt::format("guesses: {} values were learned, not the {} whose guesses these are",
                                              learned.parameters.size(), influence_.rows()));
  constexpr double quantile = 1.96;       // of the intervals
  std::map<std::size_t, double> members;  // of each variable
  bool any_interval = false;
  for (const LearnedParameter& each : learned.parameters) {
    ++members[each.variable];
    any_interval = any_interval || std::isfinite(each.upper);
  }
  // ln(value / start) = sum of influences times the changes of the guesses' logarithms, weighted.
  const auto count = static_cast<Index>(guesses_.size());
  MatrixXd normal = MatrixXd::Zero(count, count);
  VectorXd right = VectorXd::Zero(count);
  double square = 0.0, used = 0.0;
  for (std::size_t k = 0; k < learned.parameters.size(); ++k) {
    const LearnedParameter& each = learned.parameters[k];
    const VectorXd row = influence_.row(static_cast<Index>(k)).transpose();
    if (row.isZero(0.0) || !(each.value * each.start > 0.0)) continue;
    double weight = 1.0;
    if (any_interval) {
      const double deviation = 0.5 * (each.upper - each.lower) / (quantile * std::abs(each.value));
      if (!std::isfinite(deviation)) continue;
      constexpr double least = 1e-6;  // of a value: no scene is so near to its body
      weight = 1.0 / std::pow(std::max(deviation, least), 2);
    }
    weight /= members[each.variable];  // one variable is one piece of knowledge
    const double change = std::log(each.value / each.start);
    normal += weight * row * row.transpose();
    right += weight * change * row;
    square += weight * change * change;
    used += 1.0 / members[each.variable];
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(normal);
  if (count == 0 || !(spectrum.eigenvalues().maxCoeff() > 0.0)) return {};
  constexpr double told_apart = 1e-8;  // of the greatest
  MatrixXd inverse = MatrixXd::Zero(count, count), known = inverse;
  Index rank = 0;
  for (Index k = 0; k < count; ++k) {
    if (!(spectrum.eigenvalues()[k] > told_apart * spectrum.eigenvalues().maxCoeff())) continue;
    const VectorXd direction = spectrum.eigenvectors().col(k);
    inverse += direction * direction.transpose() / spectrum.eigenvalues()[k];
    known += direction * direction.transpose();
    ++rank;
  }
  const VectorXd change = inverse * right;
  // Of values that differ among themselves the scatter is part of how well their guess is known.
  const double left = std::max(0.0, square - change.dot(right)), freedom = used - static_cast<double>(rank);
  const double scatter = freedom > 0.5 ? left / freedom : 0.0;
  const double variance = any_interval ? std::max(1.0, scatter) : scatter;
  std::vector<Found> result;
  for (std::size_t g = 0; g < guesses_.size(); ++g) {
    const auto place = static_cast<Index>(g);
    constexpr double determined = 1e-6;
    const SceneGuess& guess = guesses_[g];
    if (known(place, place) < 1.0 - determined || guess.number.is_otherwise) continue;
    const double deviation = std::sqrt(variance * inverse(place, place));
    fuzzy::Example example{guess.output, guess.inputs, guess.term, 0.0, 0.0};
    if (guess.is_logarithmic) {
      example.value = std::log10(guess.value) + change[place] / std::numbers::ln10;
      example.deviation = deviation / std::numbers::ln10;
    } else {
      example.value = guess.value * std::exp(change[place]);
      example.deviation = deviation * std::abs(example.value);
    }
    result.push_back({g, std::move(example)});
  }
  return result;
}

}  // namespace springnet
