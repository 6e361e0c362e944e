// Fuzzy rule bases: linguistic terms ("very soft", "watery") to numbers, with the rules and the width of each guess.
// Files are in FCL, the Fuzzy Control Language of IEC 61131-7.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <springnet/export.hpp>

namespace springnet::fuzzy {

// Membership functions, with their numbers in this order:
//   triangle   a b c       0 outside [a, c], 1 at b
//   trapezoid  a b c d     0 outside [a, d], 1 on [b, c]
//   gaussian   m s         exp(-(x - m)^2 / (2 s^2))
//   sigmoid    i s         1 / (1 + exp(-s (x - i)))
//   points     x1 y1 x2 y2 ...  linear between the points, constant beyond the outer ones
// and of outputs only, for Takagi-Sugeno rules:
//   singleton  z           the number itself
//   linear     c1 ... cn k the sum of all inputs, c_i each, and of k
enum class Shape { triangle, trapezoid, gaussian, sigmoid, points, singleton, linear };

struct Term {
  std::string name;
  Shape shape = Shape::triangle;
  std::vector<double> numbers;
};

// Of memberships a and b: their conjunction ("and"; also how a rule's activation shapes its conclusion).
//   minimum min(a, b), product a b, bounded max(0, a + b - 1), drastic min(a, b) if one is 1, else 0,
//   einstein a b / (2 - (a + b - a b)), hamacher a b / (a + b - a b), nilpotent min(a, b) if a + b > 1, else 0
enum class TNorm { minimum, product, bounded, drastic, einstein, hamacher, nilpotent };
// Their disjunction ("or"; also how conclusions are put together).
//   maximum max(a, b), sum a + b - a b, bounded min(1, a + b), normalised (a + b) / max(1, a + b),
//   drastic max(a, b) if one is 0, else 1, einstein (a + b) / (1 + a b), hamacher (a + b - 2 a b) / (1 - a b),
//   nilpotent max(a, b) if a + b < 1, else 1
enum class SNorm { maximum, sum, bounded, normalised, drastic, einstein, hamacher, nilpotent };

// Of a membership m: any 1, not 1 - m, very m^2, somewhat sqrt(m),
//   extremely 2 m^2 up to m = 1/2, then 1 - 2 (1 - m)^2; seldom sqrt(m / 2) up to m = 1/2, then 1 - sqrt((1 - m) / 2)
enum class Hedge { any, negation, very, somewhat, extremely, seldom };

// How the fuzzy set of an output becomes a number. Maxima within 1e-12 count as one plateau. The first five are for
// Mamdani rules, the others for Takagi-Sugeno.
enum class Method {
  centre_of_gravity,     // COG
  centre_of_area,        // COA: halves the area
  leftmost_maximum,      // LM
  rightmost_maximum,     // RM
  mean_of_maximum,       // MM: of the leftmost range of maxima
  centre_of_singletons,  // COGS: mean of the conclusions, weighted by activations
  weighted_sum           // COGSS: sum of the conclusions, each times its activation
};

struct Variable {
  std::string name;
  double smallest = 0.0, largest = 1.0;  // outputs: what is integrated over; inputs: what a scene may say
  std::vector<Term> terms;
  // Without RANGE a file's inputs, and outputs by Takagi and Sugeno, have what their terms span, which bounds nothing.
  bool has_range = true;
};

struct Output : Variable {
  Method method = Method::centre_of_gravity;
  SNorm accumulation = SNorm::maximum;
  std::optional<double> otherwise;  // the value if no rule applies
};

// "input is [hedges] term". Hedges apply from the last to the first. `any` as the last one needs no term.
struct Proposition {
  std::size_t input = 0;
  std::vector<Hedge> hedges;
  std::size_t term = 0;
};

// A condition as a tree: each node comes after those that it combines, the whole last.
struct ConditionNode {
  enum class Kind { proposition, both, either, negation };
  Kind kind = Kind::proposition;
  Proposition proposition;          // of that kind
  std::size_t left = 0, right = 0;  // what it combines; a negation has `left` alone
};

// "output is [hedges] term".
struct Conclusion {
  std::size_t output = 0;
  std::vector<Hedge> hedges;
  std::size_t term = 0;
};

struct Rule {
  std::string name;  // "1" of RULE 1
  std::vector<ConditionNode> condition;
  std::vector<Conclusion> conclusions;
  double weight = 1.0;
};

struct RuleBlock {
  std::string name;
  TNorm conjunction = TNorm::minimum;
  SNorm disjunction = SNorm::maximum;
  TNorm activation = TNorm::minimum;
  std::vector<Rule> rules;
};

struct RuleBase {
  std::string name;
  std::vector<Variable> inputs;
  std::vector<Output> outputs;
  std::vector<RuleBlock> blocks;
};

// Throws Error(input) that names file, line and column. `name` is the file's in messages.
[[nodiscard]] SPRINGNET_API RuleBase parse_rules(std::string_view text, std::string_view name);
[[nodiscard]] SPRINGNET_API RuleBase read_rules(const std::filesystem::path& file);
// FCL that parse_rules reads as the same rule base, all numbers to the bit.
[[nodiscard]] SPRINGNET_API std::string to_fcl(const RuleBase& base);
// The text with the numbers of the rule base's terms in place of its own, all else as it was, comments too. Throws
// Error(input) if the text is not FCL, or has other variables or terms.
[[nodiscard]] SPRINGNET_API std::string with_numbers_of(std::string_view fcl, const RuleBase& base);
// Throws Error(input) unless the rule base is one that a file may say: every index is in range, numbers are finite and
// in order, names are there and different. What reads and evaluates checks it.
SPRINGNET_API void check(const RuleBase& base);
// A rule as FCL writes it, without RULE and its name: "if feel is very soft then stiffness is low with 0.5".
[[nodiscard]] SPRINGNET_API std::string text_of(const RuleBase& base, const Rule& rule);
// Whether the rule's condition is about the input; whether it concludes the output.
[[nodiscard]] SPRINGNET_API bool reads(const Rule& rule, std::size_t input);
[[nodiscard]] SPRINGNET_API bool concludes(const Rule& rule, std::size_t output);

// What a rule gives for the inputs.
struct RuleActivation {
  std::size_t block = 0, rule = 0;
  double activation = 0.0;  // the smallest degree of the condition, times the weight
};

// A number for an output.
struct Guess {
  double value = 0.0;
  // Standard deviation of the guess, in the unit of the value. Mamdani: of the output's fuzzy set as a density,
  // sqrt(int (y - mean)^2 mu dy / int mu dy). Takagi-Sugeno: of the conclusions z, weighted by activations w,
  // sqrt(sum w (z - mean)^2 / sum w), for the weighted sum times sum w. 0 if no rule applies, and for a single number.
  double width = 0.0;
  bool is_otherwise = false;          // no rule applied: the value is Output::otherwise
  std::vector<double> activations;    // of the output's terms: the largest of the rules that conclude it
  std::vector<RuleActivation> rules;  // that apply and conclude the output
};

struct Evaluation {
  // Degrees of the terms of each input; of an input that is not given, 0.
  std::vector<std::vector<double>> degrees;
  std::vector<RuleActivation> rules;  // all, in the order of the file
  // One an output: nothing where no rule applies and there is no DEFAULT.
  std::vector<std::optional<Guess>> outputs;
};

// Values of the inputs. Nothing is known of one that is not given: a proposition about it may have any degree from 0 to
// 1, and what is known is the smallest and the largest degree of a condition ("not": 1 - largest and 1 - smallest). A
// rule applies with the smallest. "is any" has the degree 1.
using Inputs = std::vector<std::optional<double>>;

// Midpoints of this many cells of an output's range are what integrals are summed over, and maxima looked for at.
inline constexpr std::size_t resolution = 1000;

// Throws Error(input) if the rule base is none (check), or an input is not finite.
[[nodiscard]] SPRINGNET_API Evaluation evaluate(const RuleBase& base, const Inputs& inputs);

// The same for many inputs: checks the rule base once, computes the outputs that are asked for alone, and keeps each
// answer. Threads must not share one.
class SPRINGNET_API Evaluator {
 public:
  // Throws Error(input) if the rule base is none (check).
  explicit Evaluator(std::shared_ptr<const RuleBase> base);

  [[nodiscard]] const std::shared_ptr<const RuleBase>& base() const noexcept { return base_; }
  // evaluate(base, inputs).outputs[output]; valid as long as the evaluator. Throws Error(input) for an input that is
  // not finite, and std::out_of_range for an output that there is not.
  [[nodiscard]] const std::optional<Guess>& guess(std::size_t output, const Inputs& inputs);
  // guess_of_term(base, output, term), kept likewise.
  [[nodiscard]] const std::optional<Guess>& guess_of_term(std::size_t output, std::size_t term);

 private:
  std::shared_ptr<const RuleBase> base_;
  std::map<std::pair<std::size_t, Inputs>, std::optional<Guess>> guesses_;
  std::map<std::pair<std::size_t, std::size_t>, std::optional<Guess>> of_terms_;
};

// Where an input is that is said to be a term: in the middle of where the term's membership is largest, within the
// range.
[[nodiscard]] SPRINGNET_API double centre_of(const Variable& variable, const Term& term);
// What an output is that is said to be a term, whatever the inputs. Nothing of a linear term, and of one outside the
// range.
[[nodiscard]] SPRINGNET_API std::optional<Guess> guess_of_term(const RuleBase& base, std::size_t output,
                                                               std::size_t term);

// For pictures: the degree at x of a term that has one, and an output's fuzzy set at the midpoints of its `resolution`
// cells (Mamdani; empty if no rule applies).
[[nodiscard]] SPRINGNET_API double degree_of(const Term& term, double x);
[[nodiscard]] SPRINGNET_API std::vector<double> fuzzy_set_of(const RuleBase& base, const Inputs& inputs,
                                                             std::size_t output);

// The rule base that comes with springnet: terms for soft tissue, with the sources of their ranges.
[[nodiscard]] SPRINGNET_API const RuleBase& soft_tissue();
[[nodiscard]] SPRINGNET_API std::string_view soft_tissue_fcl();

// A number of a membership function.
struct Parameter {
  bool is_output = false;
  std::size_t variable = 0, term = 0, number = 0;
};
// All of them: of inputs, then of outputs.
[[nodiscard]] SPRINGNET_API std::vector<Parameter> parameters_of(const RuleBase& base);
[[nodiscard]] SPRINGNET_API double& number_of(RuleBase& base, const Parameter& parameter);

// Derivatives of one output's guess: value and width, by parameters_of() in order, and by the inputs (0 for one that is
// not given). They are those of the sums that evaluate() forms; at kinks, those of one side.
struct Gradient {
  std::vector<double> value, width, value_by_input, width_by_input;
};
// Throws Error(input) as evaluate() does, and if the output's method looks for a maximum: that jumps.
// All 0 if no rule applies. A width of 0 has derivatives of 0.
[[nodiscard]] SPRINGNET_API Gradient gradient_of(const RuleBase& base, const Inputs& inputs, std::size_t output);

// The same of guess_of_term(), by the numbers of that term.
[[nodiscard]] SPRINGNET_API Gradient gradient_of_term(const RuleBase& base, std::size_t output, std::size_t term);

}  // namespace springnet::fuzzy
