#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "formula/expression.hpp"

namespace springnet::formula {
namespace {

struct Function {
  std::string_view name;
  std::size_t arguments;
};
// In the order of their names. `if` has a condition; `rest` and `rate` take the name of something that is read.
constexpr Function functions[] = {{"abs", 1},   {"acos", 1},  {"asin", 1},  {"atan", 1}, {"atan2", 2}, {"cbrt", 1},
                                  {"ceil", 1},  {"clamp", 3}, {"cos", 1},   {"cosh", 1}, {"erf", 1},   {"exp", 1},
                                  {"expm1", 1}, {"floor", 1}, {"hypot", 2}, {"if", 3},   {"log", 1},   {"log10", 1},
                                  {"log1p", 1}, {"max", 2},   {"min", 2},   {"pow", 2},  {"rate", 1},  {"rest", 1},
                                  {"sin", 1},   {"sinh", 1},  {"sqrt", 1},  {"tan", 1},  {"tanh", 1}};
constexpr std::string_view words[] = {"and", "or", "not"};

const Function* find_function(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(functions), std::end(functions), [&](const Function& each) { return each.name == name; });
  return found == std::end(functions) ? nullptr : found;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// A letter of a text in UTF-8, for messages.
std::string_view character_at(std::string_view text, std::size_t place) {
  std::size_t length = 1;
  while (place + length < text.size() && (static_cast<unsigned char>(text[place + length]) & 0xc0u) == 0x80u) ++length;
  return text.substr(place, length);
}

class Parser {
 public:
  explicit Parser(std::string_view text, bool is_scalar = false) : text_(text), is_scalar_(is_scalar) {
    result_.text = text;
  }

  Expression parse() {
    for (skip(); place_ < text_.size(); skip()) {
      const std::optional<std::uint32_t> value = definition_or_value();
      if (value) {
        if (place_ < text_.size()) fail(place_, unexpected());
        result_.root = number_at(*value);
        for (const Definition& each : result_.definitions)
          if (!definitions_.at(each.name).is_used)
            fail(each.place, fmt::format("'{}' is not used; remove it, or correct the formula", each.name));
        return std::move(result_);
      }
    }
    if (definitions_.empty()) fail(0, "is empty; write a formula, as 'stiffness * e'");
    fail(text_.size(), "ends with a definition; after the last ';' write what the formula is");
  }

 private:
  [[noreturn]] void fail(std::size_t place, std::string_view what) const { fail_at(text_, place, what); }

  void skip() {
    while (place_ < text_.size()) {
      const char c = text_[place_];
      if (c == '#')
        while (place_ < text_.size() && text_[place_] != '\n') ++place_;
      else if (c == ' ' || c == '\t' || c == '\n' || c == '\r')
        ++place_;
      else
        return;
    }
  }
  bool take(std::string_view symbol) {
    skip();
    if (text_.substr(place_, symbol.size()) != symbol) return false;
    place_ += symbol.size();
    return true;
  }
  // The next word, if it is this one.
  bool take_word(std::string_view word) {
    skip();
    if (peek_name() != word) return false;
    place_ += word.size();
    return true;
  }
  [[nodiscard]] std::string_view peek_name() const {
    std::size_t end = place_;
    if (end < text_.size() && is_letter(text_[end]))
      while (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]))) ++end;
    return text_.substr(place_, end - place_);
  }
  [[nodiscard]] std::string unexpected() const {
    if (place_ >= text_.size()) return "ends here; a value is missing";
    const std::string_view c = character_at(text_, place_);
    const std::string shown = printable(std::string(c));
    if (c == "=") return "'=' has no meaning here; '<' and '<=' compare, 'name = …;' before the formula defines a name";
    if (c == ")") return "this ')' closes nothing";
    if (c == "!" || c == "&" || c == "|") return fmt::format("'{}' has no meaning; write 'not', 'and', 'or'", shown);
    if (c == "?") return "'?' has no meaning; write if(condition, value, other)";
    if (c == "[" || c == "{") return fmt::format("'{}' has no meaning; write '('", shown);
    if (c == "*" || c == "/" || c == "^" || c == "," || c == "<" || c == ">" || c == "+" || c == "-" || c == ";")
      return fmt::format("'{}' stands where a value is missing", shown);
    if (is_letter(c[0]) || is_digit(c[0]) || c == "(")
      return fmt::format("an operator is missing before '{}'", is_letter(c[0]) ? std::string(peek_name()) : shown);
    return fmt::format("'{}' has no meaning", shown);
  }

  std::uint32_t add(Operation operation, std::size_t place, std::vector<std::uint32_t> arguments = {}) {
    if (result_.terms.size() >= max_terms) fail(place, fmt::format("has more than {} operations", max_terms));
    Term& term = result_.terms.emplace_back();
    term.operation = operation;
    term.place = place;
    term.arguments = std::move(arguments);
    return static_cast<std::uint32_t>(result_.terms.size() - 1);
  }
  // A level deeper, for the life of the object.
  class Deeper {
   public:
    explicit Deeper(Parser& parser) : parser_(parser) {
      if (++parser_.depth_ > max_depth)
        parser_.fail(parser_.place_, fmt::format("has more than {} brackets and signs within each other", max_depth));
    }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;
    ~Deeper() { --parser_.depth_; }

   private:
    Parser& parser_;
  };

  [[nodiscard]] bool is_condition(std::uint32_t term) const {
    switch (result_.terms[term].operation) {
      case Operation::less:
      case Operation::less_or_equal:
      case Operation::both:
      case Operation::either:
      case Operation::negation:
        return true;
      default:
        return false;
    }
  }
  [[nodiscard]] std::uint32_t number_at(std::uint32_t term) const {
    if (is_condition(term)) fail(result_.terms[term].place, "is a condition, not a number; use it in if(…, …, …)");
    return term;
  }
  [[nodiscard]] std::uint32_t condition_at(std::uint32_t term) const {
    if (!is_condition(term)) fail(result_.terms[term].place, "is a number, not a condition; compare it, as x < 1");
    return term;
  }

  // "name = value;", or the value of the whole.
  std::optional<std::uint32_t> definition_or_value() {
    const std::size_t start = place_;
    const std::string name(peek_name());
    if (!name.empty()) {
      place_ += name.size();
      skip();
      if (place_ < text_.size() && text_[place_] == '=' && text_.substr(place_, 2) != "==") {
        ++place_;
        if (!is_name(name)) fail(start, fmt::format("'{}' is a word of the language; choose another name", name));
        if (definitions_.contains(name)) fail(start, fmt::format("'{}' is defined twice", name));
        result_.definitions.push_back({name, start});
        const std::uint32_t value = number_at(condition());
        if (!take(";"))
          fail(place_, place_ < text_.size() ? unexpected() : "a ';' is missing, and the formula after it");
        definitions_.emplace(name, Defined{value});
        return std::nullopt;
      }
      place_ = start;
    }
    const std::uint32_t value = condition();
    if (take(";")) skip();
    return value;
  }

  std::uint32_t condition() {
    const Deeper deeper(*this);
    std::uint32_t left = conjunction();
    for (skip(); take_word("or"); skip()) {
      const std::size_t place = result_.terms[left].place;
      const std::uint32_t right = conjunction();
      left = add(Operation::either, place, {condition_at(left), condition_at(right)});
    }
    return left;
  }
  std::uint32_t conjunction() {
    std::uint32_t left = negation();
    for (skip(); take_word("and"); skip()) {
      const std::size_t place = result_.terms[left].place;
      const std::uint32_t right = negation();
      left = add(Operation::both, place, {condition_at(left), condition_at(right)});
    }
    return left;
  }
  std::uint32_t negation() {
    skip();
    const std::size_t place = place_;
    if (!take_word("not")) return comparison();
    const Deeper deeper(*this);
    const std::uint32_t of = negation();
    return add(Operation::negation, place, {condition_at(of)});
  }
  std::uint32_t comparison() {
    const std::uint32_t left = sum();
    skip();
    const std::size_t place = place_;
    for (const std::string_view symbol : {"==", "!="})
      if (text_.substr(place_, 2) == symbol)
        fail(place, fmt::format("'{}' has no meaning: rounding would decide; compare with '<' or '<='", symbol));
    // a > b is b < a.
    for (const auto& [symbol, operation, exchanged] :
         {std::tuple("<=", Operation::less_or_equal, false), std::tuple(">=", Operation::less_or_equal, true),
          std::tuple("<", Operation::less, false), std::tuple(">", Operation::less, true)}) {
      if (!take(symbol)) continue;
      const std::uint32_t right = number_at(sum());
      std::vector<std::uint32_t> both{number_at(left), right};
      if (exchanged) std::swap(both[0], both[1]);
      return add(operation, place, std::move(both));
    }
    return left;
  }
  std::uint32_t sum() {
    std::uint32_t left = product();
    for (;;) {
      skip();
      const std::size_t place = place_;
      const bool plus = take("+");
      if (!plus && !take("-")) return left;
      const std::uint32_t right = number_at(product());
      left = add(plus ? Operation::sum : Operation::difference, place, {number_at(left), right});
    }
  }
  std::uint32_t product() {
    std::uint32_t left = sign();
    for (;;) {
      skip();
      const std::size_t place = place_;
      if (text_.substr(place_, 2) == "**") fail(place, "'**' has no meaning; powers are written with '^'");
      const bool times = take("*");
      if (!times && !take("/")) return left;
      const std::uint32_t right = number_at(sign());
      left = add(times ? Operation::product : Operation::quotient, place, {number_at(left), right});
    }
  }
  std::uint32_t sign() {
    skip();
    const std::size_t place = place_;
    const bool minus = take("-");
    if (!minus && !take("+")) return power();
    const Deeper deeper(*this);
    const std::uint32_t of = number_at(sign());
    return minus ? add(Operation::negative, place, {of}) : of;
  }
  std::uint32_t power() {
    const std::uint32_t base = value();
    skip();
    const std::size_t place = place_;
    if (!take("^")) return base;
    const Deeper deeper(*this);
    const std::uint32_t exponent = number_at(sign());
    return add(Operation::power, place, {number_at(base), exponent});
  }
  std::uint32_t value() {
    skip();
    const std::size_t place = place_;
    if (place_ >= text_.size()) fail(place_, unexpected());
    const char c = text_[place_];
    if (is_digit(c) || c == '.') return number();
    if (c == '(') {
      ++place_;
      const std::uint32_t inside = condition();
      if (!take(")"))
        fail(place_ < text_.size() ? place_ : place, place_ < text_.size() ? unexpected() : "this '(' is not closed");
      return inside;
    }
    const std::string name(peek_name());
    if (name.empty()) fail(place, unexpected());
    if (std::find(std::begin(words), std::end(words), name) != std::end(words))
      fail(place, fmt::format("'{}' stands where a value is missing", name));
    place_ += name.size();
    skip();
    if (place_ < text_.size() && text_[place_] == '(') return call(name, place);
    if (const auto defined = definitions_.find(name); defined != definitions_.end()) {
      defined->second.is_used = true;
      return defined->second.value;
    }
    if (find_function(name) != nullptr && name != "rest" && name != "rate")
      fail(place, fmt::format("'{0}' is a function; write {0}(…)", name));
    const std::uint32_t term = add(Operation::name, place);
    result_.terms[term].name = name;
    return term;
  }
  std::uint32_t number() {
    const std::size_t place = place_;
    double parsed = 0.0;
    const char* const begin = text_.data() + place_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), parsed);
    if (error == std::errc::result_out_of_range) fail(place, "this number is too large or too small");
    if (error != std::errc()) fail(place, "is not a number");
    place_ += static_cast<std::size_t>(end - begin);
    if (!peek_name().empty()) fail(place_, fmt::format("'*' is missing between a number and '{}'", peek_name()));
    const std::uint32_t term = add(Operation::number, place);
    result_.terms[term].number = parsed;
    return term;
  }
  // Names of functions that are not known may be tables: whoever knows these decides.
  std::uint32_t call(const std::string& name, std::size_t place) {
    const Deeper deeper(*this);
    ++place_;
    std::vector<std::uint32_t> arguments;
    if (!take(")")) {
      do {
        const std::uint32_t argument = condition();
        const bool is_choice = name == "if" && arguments.empty();
        arguments.push_back(is_choice ? condition_at(argument) : number_at(argument));
      } while (take(","));
      if (!take(")"))
        fail(place_ < text_.size() ? place_ : place,
             place_ < text_.size() ? unexpected() : "the '(' here is not closed");
    }
    const Function* const function = find_function(name);
    const std::size_t wanted = function == nullptr ? 1 : function->arguments;
    if (arguments.size() != wanted && (function != nullptr || !is_scalar_))
      fail(place, fmt::format("{} takes {} {}, not {}", name, wanted, wanted == 1 ? "argument" : "arguments",
                              arguments.size()));
    const std::uint32_t term = add(Operation::call, place, std::move(arguments));
    result_.terms[term].name = name;
    return term;
  }

  std::string_view text_;
  bool is_scalar_;  // a call with any number of arguments
  Expression result_;
  std::size_t place_ = 0, depth_ = 0;
  struct Defined {
    std::uint32_t value;
    bool is_used = false;
  };
  std::map<std::string, Defined, std::less<>> definitions_;
};

void check_length(std::string_view text) {
  if (text.size() > max_length)
    throw Error(ErrorKind::input, fmt::format("a formula of {} bytes; at most {} are read", text.size(), max_length));
}

}  // namespace

void fail_at(std::string_view text, std::size_t place, std::string_view what) {
  place = std::min(place, text.size());
  const std::size_t line_start = place == 0 ? 0 : text.rfind('\n', place - 1) + 1;  // npos + 1 is 0
  const std::size_t line_end = std::min(text.find('\n', place), text.size());
  const std::string line(text.substr(line_start, line_end - line_start));
  const auto line_number = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(place), '\n');
  // Columns count characters.
  const auto column = std::count_if(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(place - line_start),
                                    [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; });
  const std::string where = text.find('\n') == std::string_view::npos ? "" : fmt::format("line {}, ", line_number);
  // Long lines are shown around the place.
  constexpr std::ptrdiff_t before = 60;
  std::string shown = line, mark(static_cast<std::size_t>(column), ' ');
  for (char& c : shown)
    if (c == '\t' || c == '\r') c = ' ';
  if (column > before && line.size() > 100) {
    const std::size_t cut = place - line_start - static_cast<std::size_t>(before);
    std::size_t begin = cut;
    while (begin < line.size() && (static_cast<unsigned char>(line[begin]) & 0xc0u) == 0x80u) ++begin;
    const auto left = std::count_if(shown.begin() + static_cast<std::ptrdiff_t>(begin),
                                    shown.begin() + static_cast<std::ptrdiff_t>(place - line_start),
                                    [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; });
    shown = "…" + shown.substr(begin);
    mark.assign(static_cast<std::size_t>(left) + 1, ' ');
  }
  if (shown.size() > 200) {
    std::size_t end = 197;
    while (end > 0 && (static_cast<unsigned char>(shown[end]) & 0xc0u) == 0x80u) --end;
    shown = shown.substr(0, end) + "…";
  }
  throw Error(ErrorKind::input,
              fmt::format("{}column {}: {}\n    {}\n    {}^", where, column + 1, what, printable(shown, 400), mark));
}

bool is_name(std::string_view text) {
  if (text.empty() || !is_letter(text[0]) || find_function(text) != nullptr) return false;
  if (std::find(std::begin(words), std::end(words), text) != std::end(words)) return false;
  return std::all_of(text.begin(), text.end(), [](char c) { return is_letter(c) || is_digit(c); });
}
bool is_function(std::string_view text) { return find_function(text) != nullptr; }

const std::vector<std::string>& function_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const Function& each : functions) result.emplace_back(each.name);
    return result;
  }();
  return names;
}

Expression parse_scalar(std::string_view text) {
  check_length(text);
  Expression result = Parser(text, true).parse();
  const Term& root = result[result.root];
  const bool is_call = root.operation == Operation::call &&
                       std::all_of(root.arguments.begin(), root.arguments.end(),
                                   [&](std::uint32_t a) { return result[a].operation == Operation::number; });
  if (!is_call) fail_at(text, root.place, "is no scalar of an element; write it as \"length(0, 1)\"");
  return result;
}

Expression parse(std::string_view text) {
  check_length(text);
  return Parser(text).parse();
}

}  // namespace springnet::formula
