// Reads FCL from top to bottom; see read.cpp for the grammar.
#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <springnet/fuzzy.hpp>

#include "fuzzy/names.hpp"
#include "fuzzy/scanner.hpp"

namespace springnet::fuzzy {

class Reader {
 public:
  Reader(std::string_view text, std::string_view name) : scanner_(text, name) {}

  RuleBase read();

 private:
  // read.cpp: blocks and variables
  void read_variables(bool are_outputs);
  void read_fuzzify();
  void read_defuzzify();
  void read_range(Variable& variable);
  Token read_new_name(std::string_view what);
  void check_outputs() const;

  // read_terms.cpp
  void read_term(Variable& variable);
  void read_points(Term& term);

  // read_rules.cpp
  void read_rule_block();
  void read_rule(RuleBlock& block, std::set<std::string_view>& names);
  std::size_t read_disjunction(Rule& rule, std::size_t depth);
  std::size_t read_conjunction(Rule& rule, std::size_t depth);
  std::size_t read_primary(Rule& rule, std::size_t depth);
  std::size_t read_proposition(Rule& rule);
  std::size_t add(Rule& rule, ConditionNode node);
  std::vector<Hedge> read_hedges();
  std::size_t read_term_name(const Variable& variable);
  void read_conclusion(Rule& rule);

  // Words and symbols.
  [[nodiscard]] bool next_is(std::string_view word_or_symbol) const;
  bool take(std::string_view word_or_symbol);
  void expect(std::string_view word_or_symbol, std::string_view after);
  double read_number(std::string_view what);
  [[noreturn]] void fail_unexpected(std::string_view wanted);
  // "KEYWORD : WORD ;" after the keyword.
  template <class Kind, std::size_t count>
  Kind read_choice(const std::array<Word<Kind>, count>& words, std::string_view keyword) {
    expect(":", keyword);
    const Token word = scanner_.take();
    const Kind* const found = word.kind == Token::Kind::word ? find_word(words, word.text) : nullptr;
    if (found == nullptr)
      scanner_.fail(word,
                    fmt::format("{} must not be {}; {}", keyword, shown(word), remedy(word.text, texts_of(words))));
    expect(";", keyword);
    return *found;
  }

  Scanner scanner_;
  RuleBase base_;
  Token last_{};                                    // read last
  std::set<std::string_view> seen_;                 // variables that have a FUZZIFY or DEFUZZIFY block
  std::vector<std::optional<SNorm>> accumulation_;  // of outputs, as far as the file says it
};

}  // namespace springnet::fuzzy
