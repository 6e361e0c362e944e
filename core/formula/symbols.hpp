// What the names in a law's formulas stand for.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/formula.hpp>
#include <springnet/sdk/law/jacobian.hpp>

#include "formula/expression.hpp"

namespace springnet::formula {

// A value that formulas name: an argument of the law by its column (see JacobianLayout), or made of the invariant and
// its reference.
enum class Made : std::uint8_t {
  column,
  elongation,   // q - reference
  strain,       // (q - reference) / reference
  stretch,      // q / reference
  strain_rate,  // rate / reference
};
struct Meaning {
  Made made = Made::column;
  std::size_t column = 0;
};

// What a law reads, from all of its formulas.
struct Reads {
  std::uint32_t invariant = 0;  // SPRINGNET_LENGTH …; of a law over one
  bool fits_elements = true;    // no name of it is about a length
  bool divides_by_reference = false;
  bool rate = false, time = false, direction = false;
  std::vector<bool> value, parameter, input;  // [scalar], [parameter], [input]
};

class Symbols {
 public:
  // Throws Error(input) for names that are taken or are none.
  explicit Symbols(const LawFormula& law);

  // Fails for names that a formula defines and that have a meaning already.
  void check_definitions(const Expression& formula) const;
  // What a name, or rest(name) and rate(name), means; notes that the law reads it. Fails at the term's place.
  [[nodiscard]] Meaning meaning_of(const Expression& formula, const Term& term);
  // rest(…) or rate(…): of the scalar that its argument names.
  [[nodiscard]] Meaning meaning_of_part(const Expression& formula, const Term& call);
  // The number of the curve that a call names, or -1.
  [[nodiscard]] std::ptrdiff_t curve_of(std::string_view name) const;

  // To be called once all formulas have been looked at. Fails for names of different invariants.
  [[nodiscard]] const Reads& reads() const { return reads_; }
  [[nodiscard]] const sdk::JacobianLayout& layout() const { return layout_; }

 private:
  void use_invariant(const Expression& formula, const Term& term, std::uint32_t invariant);
  [[noreturn]] void fail_unknown(const Expression& formula, const Term& term) const;

  const LawFormula& law_;
  bool several_, viscosity_;
  sdk::JacobianLayout layout_;
  Reads reads_;
  std::string invariant_name_;  // by which the invariant was told
};

// Names that are none of the language's, of inputs, curves or scalars.
[[nodiscard]] std::vector<std::string> free_names(const LawFormula& law);
// All formulas of a law with what they are, "force", "energy", ….
struct NamedFormula {
  std::string what;
  const std::string* text;
};
[[nodiscard]] std::vector<NamedFormula> formulas_of(const LawFormula& law);
// Messages begin with what it is.
[[nodiscard]] Expression parse_named(const NamedFormula& formula);

}  // namespace springnet::formula
