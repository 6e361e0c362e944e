#include "formula/symbols.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

namespace springnet::formula {
namespace {

struct OwnName {
  std::string_view name, meaning;
};
constexpr OwnName of_one[] = {{"e", "the value less its reference"},
                              {"strain", "e / reference"},
                              {"stretch", "value / reference"},
                              {"length", "of the spring, m"},
                              {"rest", "its length at rest, m"},
                              {"value", "of whatever the law is used on"},
                              {"reference", "the value at rest"},
                              {"angle", "rad"},
                              {"area", "m^2"},
                              {"volume", "m^3"},
                              {"speed", "of both ends relative to each other, m/s"},
                              {"rate", "of the value, per second"},
                              {"strain_rate", "rate / reference"}};
constexpr std::string_view of_all[] = {"time", "pi", "nan"};
constexpr std::string_view directions[] = {"direction_0", "direction_1", "direction_2"};

// several: of a law over several scalars, which have names of their own.
bool is_own_name(std::string_view name, bool several) {
  const auto is_it = [&](const OwnName& each) { return each.name == name; };
  return (!several && std::any_of(std::begin(of_one), std::end(of_one), is_it)) ||
         std::find(std::begin(of_all), std::end(of_all), name) != std::end(of_all) ||
         std::find(std::begin(directions), std::end(directions), name) != std::end(directions);
}

std::vector<std::string> names_of(const std::vector<FormulaSymbol>& symbols) {
  std::vector<std::string> names;
  for (const FormulaSymbol& each : symbols) names.push_back(each.name);
  return names;
}

template <class List>
std::ptrdiff_t index_of(const List& list, std::string_view name) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const auto& each) { return each.name == name; });
  return found == list.end() ? -1 : found - list.begin();
}

}  // namespace

std::vector<NamedFormula> formulas_of(const LawFormula& law) {
  std::vector<NamedFormula> result;
  if (!law.force.empty()) result.push_back({"force", &law.force});
  for (std::size_t i = 0; i < law.forces.size(); ++i)
    result.push_back(
        {i < law.scalars.size() ? fmt::format("force of {}", law.scalars[i].name) : "force", &law.forces[i]});
  if (!law.energy.empty()) result.push_back({"energy", &law.energy});
  if (!law.margin.empty()) result.push_back({"margin", &law.margin});
  for (const FormulaState& each : law.states) result.push_back({"rate of " + each.name, &each.rate});
  return result;
}

Expression parse_named(const NamedFormula& formula) {
  try {
    return parse(*formula.text);
  } catch (const Error& error) {
    throw Error(error.kind(), fmt::format("{}: {}", formula.what, error.what()));
  }
}

Symbols::Symbols(const LawFormula& law)
    : law_(law),
      several_(!law.scalars.empty()),
      viscosity_(law.kind == ComponentKind::viscosity_function),
      layout_{several_ ? law.scalars.size() : 1, law.parameters.size(), law.states.size(), law.inputs.size()} {
  std::set<std::string_view> taken;
  const auto check = [&](std::string_view what, std::string_view name) {
    const auto refuse = [&](std::string_view why) {
      throw Error(ErrorKind::input, fmt::format("{} '{}': {}", what, printable(std::string(name)), why));
    };
    if (!is_name(name))
      refuse("no name for formulas; give it one of lower-case letters, digits and '_', not that of a function");
    if (std::any_of(name.begin(), name.end(), [](char c) { return c >= 'A' && c <= 'Z'; }))
      refuse("names in formulas are in lower case; rename it");
    if (is_own_name(name, several_)) refuse("formulas have a meaning for this name; choose another one");
    if (!taken.insert(name).second) refuse("the name is given twice; rename one");
  };
  for (const FormulaSymbol& each : law.parameters) check("parameter", each.name);
  for (const FormulaSymbol& each : law.inputs) check("input", each.name);
  for (const FormulaCurve& each : law.curves) check("curve", each.name);
  for (const FormulaState& each : law.states) check("state", each.name);
  for (const FormulaScalar& each : law.scalars) check("scalar", each.name);
  reads_.value.assign(layout_.invariants, false);
  reads_.parameter.assign(law.parameters.size(), false);
  reads_.input.assign(law.inputs.size(), false);
}

void Symbols::check_definitions(const Expression& formula) const {
  for (const Definition& each : formula.definitions) {
    const auto refuse = [&](std::string_view what) {
      fail_at(formula.text, each.place, fmt::format("'{}' is {}; choose another name", each.name, what));
    };
    if (is_own_name(each.name, several_)) refuse("a word of the language");
    if (index_of(law_.parameters, each.name) >= 0) refuse("a parameter of the law");
    if (index_of(law_.inputs, each.name) >= 0) refuse("an input of the law");
    if (index_of(law_.states, each.name) >= 0) refuse("a state of the law");
    if (index_of(law_.scalars, each.name) >= 0) refuse("a scalar of the law");
  }
}

void Symbols::use_invariant(const Expression& formula, const Term& term, std::uint32_t invariant) {
  if (reads_.invariant != 0 && reads_.invariant != invariant)
    fail_at(formula.text, term.place,
            fmt::format("'{}' does not go with '{}': a law reads one of length, angle, area, volume and speed",
                        term.name, invariant_name_));
  reads_.invariant = invariant;
  invariant_name_ = term.name;
}

Meaning Symbols::meaning_of(const Expression& formula, const Term& term) {
  const std::string& name = term.name;
  const auto column = [](std::size_t at) { return Meaning{Made::column, at}; };
  if (name == "time") {
    reads_.time = true;
    return column(layout_.time());
  }
  if (const std::ptrdiff_t k = index_of(law_.parameters, name); k >= 0) {
    reads_.parameter[static_cast<std::size_t>(k)] = true;
    return column(layout_.parameter(static_cast<std::size_t>(k)));
  }
  if (const std::ptrdiff_t k = index_of(law_.states, name); k >= 0)
    return column(layout_.state(static_cast<std::size_t>(k)));
  if (const std::ptrdiff_t k = index_of(law_.inputs, name); k >= 0) {
    reads_.input[static_cast<std::size_t>(k)] = true;
    return column(layout_.input(static_cast<std::size_t>(k)));
  }
  if (index_of(law_.curves, name) >= 0)
    fail_at(formula.text, term.place, fmt::format("'{0}' is a curve; write {0}(…)", name));
  if (several_) {
    if (const std::ptrdiff_t k = index_of(law_.scalars, name); k >= 0) {
      reads_.value[static_cast<std::size_t>(k)] = true;
      return column(layout_.value(static_cast<std::size_t>(k)));
    }
    for (std::size_t k = 0; k < 3; ++k)
      if (name == directions[k]) {
        reads_.direction = true;
        return column(layout_.direction(k));
      }
    fail_unknown(formula, term);
  }
  const auto read_rate = [&] {
    if (reads_.invariant == SPRINGNET_RELATIVE_SPEED)
      fail_at(formula.text, term.place, "the relative speed has no rate; the law reads one or the other");
    reads_.rate = true;
  };
  reads_.value[0] = true;
  if (name == "e") return {Made::elongation, 0};
  if (name == "strain" || name == "stretch" || name == "strain_rate") {
    reads_.divides_by_reference = true;
    if (name == "strain_rate") read_rate();
    return {name == "strain" ? Made::strain : name == "stretch" ? Made::stretch : Made::strain_rate, 0};
  }
  if (name == "rate") {
    read_rate();
    return column(layout_.rate());
  }
  if (name == "value") return column(layout_.value());
  if (name == "reference") return column(layout_.reference());
  if (name == "length" || name == "rest") {
    use_invariant(formula, term, SPRINGNET_LENGTH);
    reads_.fits_elements = false;
    return column(name == "length" ? layout_.value() : layout_.reference());
  }
  if (name == "speed") {
    if (!viscosity_) fail_at(formula.text, term.place, "'speed' is read by viscosities alone");
    use_invariant(formula, term, SPRINGNET_RELATIVE_SPEED);
    return column(layout_.value());
  }
  for (const auto& [word, invariant] :
       {std::pair("angle", SPRINGNET_ANGLE), std::pair("area", SPRINGNET_AREA), std::pair("volume", SPRINGNET_VOLUME)})
    if (name == word) {
      use_invariant(formula, term, static_cast<std::uint32_t>(invariant));
      return column(layout_.value());
    }
  fail_unknown(formula, term);
}

Meaning Symbols::meaning_of_part(const Expression& formula, const Term& call) {
  const Term& of = formula[call.arguments[0]];
  if (!several_)
    fail_at(formula.text, call.place, fmt::format("'{0}(…)' is for laws over several scalars; write '{0}'", call.name));
  const std::ptrdiff_t k = of.operation == Operation::name ? index_of(law_.scalars, of.name) : -1;
  if (k < 0)
    fail_at(formula.text, of.place, fmt::format("'{}(…)' takes the name of a scalar that the law reads", call.name));
  const auto scalar = static_cast<std::size_t>(k);
  if (call.name == "rest") return {Made::column, layout_.reference(scalar)};
  reads_.rate = reads_.value[scalar] = true;
  return {Made::column, layout_.rate(scalar)};
}

std::ptrdiff_t Symbols::curve_of(std::string_view name) const { return index_of(law_.curves, name); }

void Symbols::fail_unknown(const Expression& formula, const Term& term) const {
  std::vector<std::string> known = names_of(law_.parameters);
  for (const std::string& name : names_of(law_.inputs)) known.push_back(name);
  for (const FormulaState& each : law_.states) known.push_back(each.name);
  for (const FormulaScalar& each : law_.scalars) known.push_back(each.name);
  if (several_)
    known.insert(known.end(), std::begin(directions), std::end(directions));
  else
    for (const OwnName& each : of_one) known.emplace_back(each.name);
  known.insert(known.end(), std::begin(of_all), std::end(of_all));
  const std::string nearest = suggestion(term.name, known);
  fail_at(
      formula.text, term.place,
      fmt::format("'{0}' is not known; {1}", printable(term.name),
                  !nearest.empty() ? nearest
                                   : fmt::format("if it is a parameter, give its value beside the formula: {} = 1.0",
                                                 printable(term.name))));
}

std::vector<std::string> free_names(const LawFormula& law) {
  std::vector<std::string> names;
  for (const NamedFormula& each : formulas_of(law)) {
    const Expression formula = parse_named(each);
    for (const Term& term : formula.terms) {
      if (term.operation != Operation::name || is_own_name(term.name, !law.scalars.empty())) continue;
      if (index_of(law.inputs, term.name) >= 0 || index_of(law.curves, term.name) >= 0 ||
          index_of(law.states, term.name) >= 0 || index_of(law.scalars, term.name) >= 0)
        continue;
      if (std::find(names.begin(), names.end(), term.name) == names.end()) names.push_back(term.name);
    }
  }
  return names;
}

}  // namespace springnet::formula
