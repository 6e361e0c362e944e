#include "formula/units.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "formula/expression.hpp"
#include "formula/symbols.hpp"
#include "text/units.hpp"

namespace springnet::formula {
namespace {

using Unit = UnitPowers;
using Known = std::optional<Unit>;  // nothing: not known, fits anything
constexpr Unit none{}, joule{1, 2, -2};

Unit times(const Unit& a, const Unit& b, double power = 1.0) {
  Unit result = a;
  for (std::size_t k = 0; k < result.size(); ++k) result[k] += power * b[k];
  return result;
}
Unit raised(const Unit& a, double power) { return times(none, a, power); }
bool equal(const Unit& a, const Unit& b) {
  for (std::size_t k = 0; k < a.size(); ++k)
    if (std::abs(a[k] - b[k]) > 1e-9) return false;
  return true;
}
std::string text_of(const Unit& unit) {
  if (equal(unit, none)) return "1";
  struct Named {
    Unit unit;
    const char* name;
  };
  constexpr Named named[] = {{{1, 1, -2}, "N"},     {{1, 0, -2}, "N/m"}, {{1, 2, -2}, "J"},    {{1, -1, -2}, "Pa"},
                             {{1, 0, -1}, "N s/m"}, {{1, 2, -3}, "W"},   {{1, -1, -1}, "Pa s"}};
  for (const Named& each : named)
    if (equal(unit, each.unit)) return each.name;
  std::string text;
  for (std::size_t k = 0; k < unit.size(); ++k) {
    if (std::abs(unit[k]) < 1e-9) continue;
    if (!text.empty()) text += ' ';
    text += base_units[k];
    if (std::abs(unit[k] - 1.0) > 1e-9) text += fmt::format("^{:g}", unit[k]);
  }
  return text;
}

// "N s/m^2", "1/s", "Pa s"; nothing for what is not understood.
Known read(std::string_view text) {
  Unit result = none;
  double side = 1.0;
  std::size_t at = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (c == ' ') {
      ++at;
      continue;
    }
    if (c == '/') {
      side = -1.0;
      ++at;
      continue;
    }
    if (c == '*' || c == '(' || c == ')') {
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < text.size() && std::string_view(" /*()^").find(text[end]) == std::string_view::npos) ++end;
    const std::string_view name = text.substr(at, end - at);
    const NamedUnit* const found = find_unit(name);
    if (found == nullptr && name != "1") return std::nullopt;
    double power = 1.0;
    if (end < text.size() && text[end] == '^') {
      const auto [stop, error] = std::from_chars(text.data() + end + 1, text.data() + text.size(), power);
      if (error != std::errc()) return std::nullopt;
      end = static_cast<std::size_t>(stop - text.data());
    }
    if (found != nullptr) result = times(result, found->powers, side * power);
    at = end;
  }
  return result;
}

class Checker {
 public:
  Checker(const LawFormula& law, const Unit& value) : law_(law), value_(value) {}

  void check(const NamedFormula& named, const Known& wanted) const {
    const Expression formula = parse(*named.text);
    std::vector<Known> units;
    try {
      for (const Term& term : formula.terms) units.push_back(of(formula, term, units));
    } catch (const Error& error) {
      throw Error(error.kind(), fmt::format("{}: {}", named.what, error.what()));
    }
    const Known& result = units[formula.root];
    if (result && wanted && !equal(*result, *wanted) && !is_zero(formula, formula.root))
      throw Error(ErrorKind::input, fmt::format("{}: is in {}, and must be in {}; look at the units of its parameters",
                                                named.what, text_of(*result), text_of(*wanted)));
  }
  [[nodiscard]] Known unit_of_scalar(std::string_view name) const {
    for (const FormulaScalar& each : law_.scalars) {
      if (each.name != name) continue;
      if (each.of.starts_with("length")) return Unit{0, 1, 0};
      if (each.of.starts_with("area")) return Unit{0, 2, 0};
      if (each.of.starts_with("volume")) return Unit{0, 3, 0};
      return none;
    }
    return std::nullopt;
  }

 private:
  static bool is_zero(const Expression& formula, std::uint32_t term) {
    return formula[term].operation == Operation::number && formula[term].number == 0.0;
  }
  [[nodiscard]] Known of_name(const std::string& name) const {
    const Unit per_time{0, 0, -1};
    if (name == "time") return Unit{0, 0, 1};
    if (name == "nan") return std::nullopt;
    if (name == "pi" || name.starts_with("direction_")) return none;
    for (const auto* list : {&law_.parameters, &law_.inputs})
      for (const FormulaSymbol& each : *list)
        if (each.name == name) return each.unit.empty() ? std::nullopt : read(each.unit);
    for (const FormulaState& each : law_.states)
      if (each.name == name) return each.unit.empty() ? std::nullopt : read(each.unit);
    if (!law_.scalars.empty()) return unit_of_scalar(name);
    if (name == "strain" || name == "stretch" || name == "angle") return none;
    if (name == "strain_rate") return per_time;
    if (name == "rate") return times(value_, per_time);
    return value_;
  }
  // The unit of both; fails where they differ.
  Known same(const Expression& formula, const Term& term, const std::vector<Known>& units, std::size_t first) const {
    Known common;
    for (std::size_t k = first; k < term.arguments.size(); ++k) {
      const std::uint32_t a = term.arguments[k];
      const Known& unit = units[a];
      if (!unit || is_zero(formula, a)) continue;
      if (common && !equal(*common, *unit))
        fail_at(formula.text, formula[a].place,
                fmt::format("is in {}, and goes with what is in {}", text_of(*unit), text_of(*common)));
      common = unit;
    }
    return common;
  }
  Known of(const Expression& formula, const Term& term, const std::vector<Known>& units) const {
    const auto unit = [&](std::size_t k) -> const Known& { return units[term.arguments[k]]; };
    switch (term.operation) {
      case Operation::number:
        return none;
      case Operation::name:
        return of_name(term.name);
      case Operation::negative:
        return unit(0);
      case Operation::sum:
      case Operation::difference:
        return same(formula, term, units, 0);
      case Operation::less:
      case Operation::less_or_equal:
        same(formula, term, units, 0);
        return none;
      case Operation::product:
      case Operation::quotient:
        if (!unit(0) || !unit(1)) return std::nullopt;
        return times(*unit(0), *unit(1), term.operation == Operation::product ? 1.0 : -1.0);
      case Operation::power:
        return power(formula, term, unit(0), unit(1));
      case Operation::both:
      case Operation::either:
      case Operation::negation:
        return none;
      case Operation::call:
        return call(formula, term, units);
    }
    return std::nullopt;
  }
  Known power(const Expression& formula, const Term& term, const Known& base, const Known& exponent) const {
    const Term& written = formula[term.arguments[1]];
    if (exponent && !equal(*exponent, none))
      fail_at(formula.text, written.place,
              fmt::format("an exponent is in {}, and must have no unit", text_of(*exponent)));
    if (!base || equal(*base, none)) return base;
    if (written.operation == Operation::number) return raised(*base, written.number);
    if (written.operation == Operation::negative && formula[written.arguments[0]].operation == Operation::number)
      return raised(*base, -formula[written.arguments[0]].number);
    fail_at(formula.text, term.place,
            fmt::format("what is in {} is raised to a power that is not written as a number", text_of(*base)));
  }
  Known call(const Expression& formula, const Term& term, const std::vector<Known>& units) const {
    const std::string& name = term.name;
    const auto unit = [&](std::size_t k) -> const Known& { return units[term.arguments[k]]; };
    if (name == "rest") return unit_of_scalar(formula[term.arguments[0]].name);
    if (name == "rate") {
      const Known of = unit_of_scalar(formula[term.arguments[0]].name);
      return of ? Known(times(*of, Unit{0, 0, -1})) : of;
    }
    if (name == "if") return same(formula, term, units, 1);
    if (name == "min" || name == "max" || name == "clamp" || name == "hypot") return same(formula, term, units, 0);
    if (name == "atan2") {
      same(formula, term, units, 0);
      return none;
    }
    if (name == "abs") return unit(0);
    if (name == "sqrt") return unit(0) ? Known(raised(*unit(0), 0.5)) : unit(0);
    if (name == "cbrt") return unit(0) ? Known(raised(*unit(0), 1.0 / 3.0)) : unit(0);
    if (name == "pow") return power(formula, term, unit(0), unit(1));
    if (!is_function(name)) return std::nullopt;  // a curve
    if (unit(0) && !equal(*unit(0), none))
      fail_at(formula.text, formula[term.arguments[0]].place,
              fmt::format("{} takes a number without unit, this is in {}", name, text_of(*unit(0))));
    return none;
  }

  const LawFormula& law_;
  Unit value_;
};

// What units are where a law over one invariant is used.
struct Use {
  Unit value, force;
};
Use use_on(std::optional<Invariant> elements) {
  const auto by = [](const Unit& value) { return Use{value, times(joule, value, -1.0)}; };
  if (!elements) return by({0, 1});
  switch (*elements) {
    case Invariant::area:
      return by({0, 2});
    case Invariant::volume:
    case Invariant::enclosed_volume:
      return by({0, 3});
    default:  // angles
      return by(none);
  }
}

// What the formulas themselves say of their use; nothing: they are for whatever has a value.
std::optional<Use> named_use(const LawFormula& law) {
  for (const NamedFormula& each : formulas_of(law)) {
    for (const Term& term : parse(*each.text).terms) {
      if (term.operation != Operation::name) continue;
      if (term.name == "speed") return Use{{0, 1, -1}, {1, 1, -2}};
      if (term.name == "length" || term.name == "rest") return use_on(std::nullopt);
      if (term.name == "angle") return use_on(Invariant::angle);
      if (term.name == "area") return use_on(Invariant::area);
      if (term.name == "volume") return use_on(Invariant::volume);
    }
  }
  return std::nullopt;
}

void check_use(const LawFormula& law, const Use& use) {
  const Checker checker(law, use.value);
  std::size_t scalar = 0;
  for (const NamedFormula& each : formulas_of(law)) {
    if (each.what == "energy") {
      checker.check(each, joule);
    } else if (each.what == "margin") {
      checker.check(each, none);
    } else if (each.what.starts_with("rate of ")) {
      for (const FormulaState& state : law.states)
        if (each.text == &state.rate) {
          const Known own = state.unit.empty() ? std::nullopt : read(state.unit);
          checker.check(each, own ? Known(times(*own, Unit{0, 0, -1})) : own);
        }
    } else if (law.scalars.empty()) {
      checker.check(each, use.force);
    } else {
      const Known of = checker.unit_of_scalar(law.scalars[scalar++].name);
      checker.check(each, of ? Known(times(joule, *of, -1.0)) : of);
    }
  }
}

// Whether there is something to check. Throws Error(input) for a unit that is not known.
bool has_units(const LawFormula& law) {
  bool result = false;
  for (const auto* list : {&law.parameters, &law.inputs})
    for (const FormulaSymbol& each : *list) {
      result = result || !each.unit.empty();
      if (!each.unit.empty() && !read(each.unit))
        throw Error(ErrorKind::input, fmt::format("the unit '{}' of '{}' is not known; write it with those of the SI "
                                                  "without prefixes, as \"N s/m\", \"1/s\", or \"1\" for none",
                                                  printable(each.unit), each.name));
    }
  return result;
}

}  // namespace

void check_units_of_some_use(const LawFormula& law) {
  if (!has_units(law)) return;
  const std::optional<Use> named = named_use(law);
  if (named || !law.scalars.empty()) return check_use(law, named.value_or(Use{}));
  for (const Invariant each : {Invariant::angle, Invariant::area, Invariant::volume}) {
    try {
      return check_use(law, use_on(each));
    } catch (const Error&) {  // what is wrong is told of springs
    }
  }
  check_use(law, use_on(std::nullopt));
}

}  // namespace springnet::formula

namespace springnet {

void check_units(const LawFormula& law, std::optional<Invariant> elements) {
  using namespace formula;
  if (law.scalars.empty() && has_units(law)) check_use(law, named_use(law).value_or(use_on(elements)));
}

}  // namespace springnet
