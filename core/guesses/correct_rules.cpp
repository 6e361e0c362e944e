#include <springnet/rule_correction.hpp>

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Core>

#include <springnet/error.hpp>

#include "learning/minimise.hpp"

namespace springnet::fuzzy {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorKind::input, "correcting rules: " + what); }

// How the numbers of a term follow shift and stretch.
struct Form {
  double centre = 0.0, width = 0.0;  // width: 0 for a single number
  std::vector<double> by_shift;      // [number]
  std::vector<double> arm;           // [number] what the stretch multiplies
  bool is_slope = false;             // the second number of a sigmoid is divided in place of that
};

Form form_of(const Term& term) {
  const std::vector<double>& numbers = term.numbers;
  Form form;
  form.by_shift.assign(numbers.size(), 1.0);
  form.arm.assign(numbers.size(), 0.0);
  const auto spread = [&](std::size_t step) {  // over numbers 0, step, 2 step, …
    std::size_t count = 0;
    for (std::size_t k = 0; k < numbers.size(); k += step, ++count) form.centre += numbers[k];
    form.centre /= static_cast<double>(count);
    for (std::size_t k = 0; k < numbers.size(); k += step) form.arm[k] = numbers[k] - form.centre;
    form.width = 0.5 * (numbers[numbers.size() - step] - numbers[0]);
  };
  switch (term.shape) {
    case Shape::triangle:
    case Shape::trapezoid:
      spread(1);
      break;
    case Shape::points:
      spread(2);
      for (std::size_t k = 1; k < numbers.size(); k += 2) form.by_shift[k] = 0.0;
      break;
    case Shape::gaussian:
      form.centre = numbers[0];
      form.width = form.arm[1] = numbers[1];
      form.by_shift[1] = 0.0;
      break;
    case Shape::sigmoid:
      form.centre = numbers[0];
      form.width = numbers[1] == 0.0 ? 0.0 : 1.0 / std::abs(numbers[1]);
      form.by_shift[1] = 0.0;
      form.is_slope = true;
      break;
    case Shape::singleton:
      form.centre = numbers[0];
      break;
    case Shape::linear:
      for (std::size_t k = 0; k + 1 < numbers.size(); ++k) form.by_shift[k] = 0.0;
      break;
  }
  return form;
}

// The variables: a shift of each output, then a shift and a stretch of each of its terms, in their deviations.
class Terms {
 public:
  Terms(const RuleBase& base, const CorrectionOptions& options) : base_(base), options_(options) {
    const std::vector<Parameter> parameters = parameters_of(base);
    for (std::size_t o = 0; o < base.outputs.size(); ++o) {
      const Output& output = base.outputs[o];
      const Index common = count_++;
      double widths = 0.0;
      for (const Term& term : output.terms) widths += form_of(term).width;
      // A single number has no width of its own; the range tells what is far.
      constexpr double part_of_range = 0.1;
      const double typical = widths > 0.0 ? widths / static_cast<double>(output.terms.size())
                                          : part_of_range * (output.largest - output.smallest);
      for (std::size_t t = 0; t < output.terms.size(); ++t) {
        Own own{o, t, form_of(output.terms[t]), typical, common, count_, {}};
        count_ += 2;
        for (std::size_t k = 0; k < parameters.size(); ++k)
          if (parameters[k].is_output && parameters[k].variable == o && parameters[k].term == t)
            own.places.push_back(k);
        own_.push_back(std::move(own));
      }
    }
  }

  [[nodiscard]] Index count() const noexcept { return count_; }

  [[nodiscard]] RuleBase at(const VectorXd& x) const {
    RuleBase result = base_;
    for (const Own& each : own_) {
      const double shift = shift_of(each, x), factor = std::exp(stretch_of(each, x));
      std::vector<double>& numbers = result.outputs[each.output].terms[each.term].numbers;
      for (std::size_t k = 0; k < numbers.size(); ++k)
        numbers[k] += each.form.by_shift[k] * shift + each.form.arm[k] * (factor - 1.0);
      if (each.form.is_slope) numbers[1] /= factor;
    }
    return result;
  }

  // Derivatives by the variables, for those by the numbers of all terms.
  [[nodiscard]] VectorXd by_variables(const std::vector<double>& by_number, const VectorXd& x) const {
    VectorXd result = VectorXd::Zero(count_);
    for (const Own& each : own_) {
      const double factor = std::exp(stretch_of(each, x));
      for (std::size_t k = 0; k < each.places.size(); ++k) {
        const double own = by_number[each.places[k]];
        const double shift = each.form.by_shift[k] * own;
        result[each.common] += options_.common_shift * each.typical * shift;
        result[each.first] += options_.shift * each.typical * shift;
        result[each.first + 1] += options_.stretch * each.form.arm[k] * factor * own;
      }
      if (each.form.is_slope)
        result[each.first + 1] -= options_.stretch * number(each, 1) / factor * by_number[each.places[1]];
    }
    return result;
  }

  [[nodiscard]] std::vector<TermChange> changes(const VectorXd& x, const VectorXd& influence) const {
    std::vector<TermChange> result;
    for (const Own& each : own_)
      if (influence[each.first] > 0.0 || influence[each.first + 1] > 0.0)
        result.push_back(
            {each.output, each.term, shift_of(each, x), each.form.width > 0.0 ? stretch_of(each, x) : 0.0});
    return result;
  }
  [[nodiscard]] std::vector<double> common_shifts(const VectorXd& x) const {
    std::vector<double> result(base_.outputs.size(), 0.0);
    for (const Own& each : own_) result[each.output] = options_.common_shift * each.typical * x[each.common];
    return result;
  }

 private:
  struct Own {
    std::size_t output, term;
    Form form;
    double typical;  // width of the output's terms
    Index common, first;
    std::vector<std::size_t> places;  // [number] among parameters_of()
  };
  [[nodiscard]] double number(const Own& each, std::size_t k) const {
    return base_.outputs[each.output].terms[each.term].numbers[k];
  }
  [[nodiscard]] double shift_of(const Own& each, const VectorXd& x) const {
    return each.typical * (options_.common_shift * x[each.common] + options_.shift * x[each.first]);
  }
  [[nodiscard]] double stretch_of(const Own& each, const VectorXd& x) const {
    return options_.stretch * x[each.first + 1];
  }

  const RuleBase& base_;
  const CorrectionOptions& options_;
  std::vector<Own> own_;
  Index count_ = 0;
};

std::optional<Guess> guess_of(const RuleBase& base, const Example& example) {
  if (example.term) return guess_of_term(base, example.output, *example.term);
  return evaluate(base, example.inputs).outputs[example.output];
}

// Differences of the examples in their deviations, then the variables.
class Problem : public learning::LeastSquares {
 public:
  Problem(const RuleBase& base, const std::vector<Example>& examples, const CorrectionOptions& options)
      : terms_(base, options), examples_(examples), deviations_(static_cast<Index>(examples.size())) {}

  [[nodiscard]] const Terms& terms() const noexcept { return terms_; }
  VectorXd& deviations() noexcept { return deviations_; }

  VectorXd residuals(const VectorXd& x) override {
    const RuleBase own = terms_.at(x);
    VectorXd result(deviations_.size() + terms_.count());
    for (Index k = 0; k < deviations_.size(); ++k) {
      const Example& example = examples_[static_cast<std::size_t>(k)];
      // Where terms have left what defuzzifies them, the search steps back.
      const std::optional<Guess> guess = guess_of(own, example);
      result[k] = guess ? (guess->value - example.value) / deviations_[k] : std::numeric_limits<double>::quiet_NaN();
    }
    result.tail(terms_.count()) = x;
    return result;
  }
  void linearise(const VectorXd& x) override {
    const RuleBase own = terms_.at(x);
    jacobian_.setZero(deviations_.size() + terms_.count(), terms_.count());
    for (Index k = 0; k < deviations_.size(); ++k) {
      const Example& example = examples_[static_cast<std::size_t>(k)];
      const Gradient gradient = example.term ? gradient_of_term(own, example.output, *example.term)
                                             : gradient_of(own, example.inputs, example.output);
      jacobian_.row(k) = terms_.by_variables(gradient.value, x).transpose() / deviations_[k];
    }
    jacobian_.bottomRows(terms_.count()).diagonal().setOnes();
  }
  VectorXd times(const VectorXd& change) override { return jacobian_ * change; }
  VectorXd transposed_times(const VectorXd& weights) override { return jacobian_.transpose() * weights; }
  MatrixXd jacobian(Index) override { return jacobian_; }

 private:
  Terms terms_;
  const std::vector<Example>& examples_;
  VectorXd deviations_;
  MatrixXd jacobian_;
};

void check(const RuleBase& base, const std::vector<Example>& examples, const CorrectionOptions& options) {
  check(base);
  if (examples.empty()) refuse("there is no example to learn from");
  const auto is_above_0 = [](double value) { return value > 0.0 && std::isfinite(value); };
  if (!(options.spread >= 0.0 && std::isfinite(options.spread)))
    refuse(fmt::format("the spread of bodies is {}, must be 0 or above", options.spread));
  if (!is_above_0(options.common_shift) || !is_above_0(options.shift) || !is_above_0(options.stretch))
    refuse("the deviations of shifts and stretches must be above 0");
  for (std::size_t k = 0; k < examples.size(); ++k) {
    const Example& each = examples[k];
    if (each.output >= base.outputs.size())
      refuse(fmt::format("example {} is of output {}; there are {}", k, each.output, base.outputs.size()));
    const std::string& name = base.outputs[each.output].name;
    if (!std::isfinite(each.value) || !(each.deviation >= 0.0 && std::isfinite(each.deviation)))
      refuse(fmt::format("example {} of '{}' has the value {} and the deviation {}; give finite ones", k, name,
                         each.value, each.deviation));
    if (options.spread == 0.0 && each.deviation == 0.0)
      refuse(fmt::format("example {} of '{}' is exact, and bodies have no spread; give one of both", k, name));
  }
}

}  // namespace

Correction correct(const RuleBase& base, const std::vector<Example>& examples, const CorrectionOptions& options) {
  check(base, examples, options);
  Problem problem(base, examples, options);
  Correction result;
  for (std::size_t k = 0; k < examples.size(); ++k) {
    const Example& each = examples[k];
    const std::string& name = base.outputs[each.output].name;
    result.before.push_back(guess_of(base, each));
    if (!result.before.back() || result.before.back()->is_otherwise)
      refuse(fmt::format("no rule gives '{}' for example {}; leave it out, or add a rule", name, k));
    double& own = problem.deviations()[static_cast<Index>(k)];
    own = std::hypot(each.deviation, options.spread * result.before.back()->width);
    if (!(own > 0.0))
      refuse(fmt::format("example {} of '{}' is exact, and its guess has no width; give it a deviation", k, name));
  }
  const Index count = problem.terms().count();
  const VectorXd start = VectorXd::Zero(count);
  problem.linearise(start);
  const VectorXd influence =
      problem.jacobian(count).topRows(static_cast<Index>(examples.size())).colwise().norm().transpose();
  const VectorXd no_bound = VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  result.start_cost = 0.5 * problem.residuals(start).squaredNorm();
  const learning::Minimum found = learning::levenberg_marquardt(problem, start, {-no_bound, no_bound});
  result.cost = found.cost;
  result.base = problem.terms().at(found.x);
  result.changes = problem.terms().changes(found.x, influence);
  result.common_shifts = problem.terms().common_shifts(found.x);
  for (const Example& each : examples) result.after.push_back(guess_of(result.base, each));
  return result;
}

}  // namespace springnet::fuzzy
