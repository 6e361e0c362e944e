// Formulas as C++: the class of a law, of its declarations and of its functions (writer.cpp).
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/formula_source.hpp>
#include <springnet/sdk/law/invariants.hpp>

#include "formula/derive.hpp"
#include "formula/law.hpp"
#include "formula/writer.hpp"

namespace springnet {
namespace formula {
namespace {

// Names that an enumerator of a law's class cannot have: keywords, macros of the C library, members of the class and of
// its bases that the SDK reads, the names in the statements.
constexpr std::string_view taken_names =
    " alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t class "
    "co_await co_return co_yield "
    "compl concept const const_cast consteval constexpr constinit continue decltype default delete do double "
    "dynamic_cast else enum explicit export extern false float for friend goto if inline int long mutable namespace "
    "new noexcept not not_eq nullptr operator or or_eq private protected public register reinterpret_cast requires "
    "return short signed sizeof static static_assert static_cast struct switch template this thread_local throw true "
    "try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor xor_eq "
    "errno assert stdin stdout stderr linux unix "
    "has id summary reference kind invariant acts_in_compression reads_rate reads_time monotone not_zero_at_rest "
    "adds_power calling_thread_only fits_elements divides_by_reference smallest_stretch largest_stretch update_order "
    "smooth_rates shape reads_direction parameters invariants states state_rates inputs tables prepare update start "
    "force energy margin number table length_of angle_of area_of volume_of dihedral_of at_rest source springnet std e "
    "p ";

// All names of a law in C++: enumerators, each of which is there once.
class Enumerators {
 public:
  explicit Enumerators(const LawFormula& law) {
    for (const auto* list : {&law.parameters, &law.inputs}) add(*list);
    add(law.states);
    add(law.scalars);
  }
  // For a name of the formula: itself, or with underscores.
  [[nodiscard]] std::string of(const std::string& name) const { return free(name, is_taken(name)); }
  // For a name that the formula does not have.
  [[nodiscard]] std::string another(const std::string& name) {
    std::string result = free(name, is_taken(name) || is_own(name));
    own_.push_back(result);
    return result;
  }

 private:
  template <class List>
  void add(const List& list) {
    for (const auto& each : list) own_.push_back(each.name);
  }
  static bool is_taken(const std::string& name) {
    return taken_names.find(fmt::format(" {} ", name)) != std::string_view::npos;
  }
  [[nodiscard]] bool is_own(const std::string& name) const {
    return std::find(own_.begin(), own_.end(), name) != own_.end();
  }
  [[nodiscard]] std::string free(std::string name, bool is_refused) const {
    while (is_refused) is_refused = is_own(name += '_');
    return name;
  }

  std::vector<std::string> own_;
};

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorKind::input, what); }

// In quotes.
std::string literal(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return result + '"';
}

// 3, 0.5: as an argument of type double.
std::string argument(double value) {
  if (!std::isfinite(value)) return number_text(value);
  constexpr double most = 1e9;  // of a literal of type int
  return std::abs(value) < most ? fmt::format("{}", value) : number_text(value);
}

// number("stiffness", "N/m", "of all").at_least(0)
template <class Symbol>
std::string entry_of(const Symbol& symbol, const std::string& more) {
  std::string text = fmt::format("number({}, {}, {}){}", literal(symbol.name),
                                 literal(symbol.unit.empty() ? "1" : symbol.unit), literal(symbol.summary), more);
  bool excludes = false;
  if constexpr (requires { symbol.excludes_smallest; }) excludes = symbol.excludes_smallest;
  if (std::isfinite(symbol.smallest))
    text += fmt::format(".{}({})", excludes ? "above" : "at_least", argument(symbol.smallest));
  if (std::isfinite(symbol.largest)) text += fmt::format(".at_most({})", argument(symbol.largest));
  return text;
}
std::string learnable(double scale) {
  return scale == 1.0 ? ".learnable()" : fmt::format(".learnable({})", argument(scale));
}
std::string preset(double value) { return fmt::format(".preset({})", argument(std::isnan(value) ? 0.0 : value)); }

SourceList parameter_list(const LawFormula& law) {
  SourceList list{"Parameter", "parameters", {}};
  for (const FormulaSymbol& each : law.parameters)
    list.entries.push_back(entry_of(each, std::isnan(each.preset) ? "" : preset(each.preset)) +
                           (each.learnable ? learnable(scale_of(each)) : ""));
  return list;
}
SourceList input_list(const LawFormula& law) {
  SourceList list{"Parameter", "inputs", {}};
  for (const FormulaSymbol& each : law.inputs) list.entries.push_back(entry_of(each, preset(each.preset)));
  return list;
}
SourceList state_list(const LawFormula& law) {
  SourceList list{"Parameter", "states", {}};
  for (const FormulaState& each : law.states)
    list.entries.push_back(entry_of(each, preset(each.start)) +
                           (scale_of(each) == 1.0 ? "" : learnable(scale_of(each))));
  return list;
}

// length_of(0, 1), at_rest(area_of(0, 1, 2))
SourceList invariant_list(const Component& component) {
  SourceList list{"Scalar", "invariants", {}};
  for (std::uint32_t k = 0; k < component.law().invariant_count; ++k) {
    const springnet_invariant& one = *component.law().invariants[k];
    const sdk::Scalar scalar{one.kind, {one.corners[0], one.corners[1], one.corners[2], one.corners[3]}, one.flags};
    std::string_view name = "dihedral_of";
    if (one.kind == SPRINGNET_LENGTH) name = "length_of";
    if (one.kind == SPRINGNET_ANGLE) name = "angle_of";
    if (one.kind == SPRINGNET_AREA) name = "area_of";
    if (one.kind == SPRINGNET_VOLUME) name = "volume_of";
    std::string corners;
    for (std::size_t c = 0; c < scalar.corner_count(); ++c)
      corners += fmt::format("{}{}", c == 0 ? "" : ", ", scalar.corners[c]);
    const std::string text = fmt::format("{}({})", name, corners);
    list.entries.push_back(scalar.reference_only() ? fmt::format("at_rest({})", text) : text);
  }
  return list;
}

// The points of curves are tables of the plugin, x and y of each.
void add_curves(const LawFormula& law, FormulaSource& source) {
  if (law.curves.empty()) return;
  source.uses_tables = true;
  SourceList list{"Table", "tables", {}};
  std::string curves;
  for (std::size_t k = 0; k < law.curves.size(); ++k) {
    const std::size_t x = 2 * k;
    list.entries.push_back(
        fmt::format("table({}, \"1\", \"\").increasing().at_least_values(2)", literal(source.table_keys[x])));
    list.entries.push_back(fmt::format("table({}, \"1\", \"\").as_long_as({})", literal(source.table_keys[x + 1]), x));
    const std::string points = fmt::format("source[{}], source[{}], Beyond::linear", x, x + 1);
    if (law.curves.size() == 1)
      source.prepare =
          fmt::format("static MonotoneCubic prepare(const TableSource& source) {{ return {{{}}}; }}", points);
    curves += fmt::format("{}MonotoneCubic({})", k == 0 ? "" : ",\n                      ", points);
  }
  source.lists.push_back(std::move(list));
  if (law.curves.size() > 1)
    source.prepare =
        fmt::format("static auto prepare(const TableSource& source) {{\n    return std::array{{{}}};\n  }}", curves);
}

// As the engine has it for names of plugins: snake_case, and keys of scenes are taken.
template <class List>
void check_names(std::string_view what, const List& list) {
  for (const auto& each : list) {
    if (each.name[0] == '_')
      refuse(fmt::format("{} '{}': names in plugins begin with a lower-case letter; rename it", what, each.name));
    if (each.name == "type" || each.name == "name")
      refuse(fmt::format("{} '{}': scenes have this key beside the parameters of a law; rename it", what, each.name));
  }
}

// Whether the law pulls or pushes at the reference value and at rest, with parameters of no special value.
bool is_loaded_at_rest(const Component& component) {
  constexpr double one = 1.0, nothing = 0.0, rounding = 1e-12;
  const springnet_law& law = component.law();
  if (law.invariant == SPRINGNET_SEVERAL) return false;
  std::vector<double> values, at_start, signals;
  std::vector<const double*> parameters, states, inputs;
  for (std::size_t k = 0; k < component.description->parameter_count; ++k)
    values.push_back(0.9 + 0.37 * static_cast<double>(k));
  for (std::size_t k = 0; k < law.state_count; ++k) at_start.push_back(law.states[k]->default_value);
  for (std::size_t k = 0; k < law.input_count; ++k) signals.push_back(law.inputs[k]->default_value);
  for (const double& value : values) parameters.push_back(&value);
  for (const double& value : at_start) states.push_back(&value);
  for (const double& value : signals) inputs.push_back(&value);
  const std::vector<std::uint32_t> strides(values.size() + signals.size(), 0);
  double force = 0.0;
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.time = 0.6;
  batch.q = law.invariant == SPRINGNET_RELATIVE_SPEED ? &nothing : &one;
  batch.rate = &nothing;
  batch.reference = &one;
  batch.parameters = parameters.data();
  batch.parameter_strides = strides.data();
  batch.states = states.data();
  batch.inputs = inputs.data();
  batch.input_strides = strides.data();
  batch.force = &force;
  return law.evaluate(law.context, &batch) == SPRINGNET_OK && std::abs(force) > rounding;
}

void add_declarations(const LawFormula& law, const Component& component, const Reads& reads, FormulaSource& source) {
  const auto declare = [&](bool is, std::string_view what) {
    if (is) source.declarations.push_back(fmt::format("static constexpr {};", what));
  };
  if (!law.energy.empty() || !law.margin.empty())
    source.declarations.push_back(fmt::format("using has = Has<{}{}{}>;", law.energy.empty() ? "" : "Energy",
                                              law.energy.empty() || law.margin.empty() ? "" : ", ",
                                              law.margin.empty() ? "" : "Margin"));
  const bool several = !law.scalars.empty(), viscosity = law.kind == ComponentKind::viscosity_function;
  const std::uint32_t invariant = component.law().invariant;
  declare(several, fmt::format("Shape shape = Shape::{}", name_of(law.shape)));
  declare(several && reads.direction, "bool reads_direction = true");
  declare(invariant == SPRINGNET_RELATIVE_SPEED, "std::uint32_t invariant = SPRINGNET_RELATIVE_SPEED");
  declare(invariant == SPRINGNET_ANGLE, "std::uint32_t invariant = SPRINGNET_ANGLE");
  declare(invariant == SPRINGNET_AREA, "std::uint32_t invariant = SPRINGNET_AREA");
  declare(invariant == SPRINGNET_VOLUME, "std::uint32_t invariant = SPRINGNET_VOLUME");
  declare(law.pulls_only, "bool acts_in_compression = false");
  const bool reads_rate = (component.description->capabilities & SPRINGNET_READS_RATE) != 0;
  declare(reads_rate && !viscosity, "bool reads_rate = true");
  declare(!reads_rate && viscosity && several, "bool reads_rate = false");
  declare(reads.time, "bool reads_time = true");
  declare(law.monotone, "bool monotone = true");
  declare(law.not_zero_at_rest || is_loaded_at_rest(component), "bool not_zero_at_rest = true");
  declare(law.adds_power, "bool adds_power = true");
  declare(reads.divides_by_reference, "bool divides_by_reference = true");
  declare((component.description->capabilities & SPRINGNET_FITS_ELEMENTS) != 0, "bool fits_elements = true");
  declare(law.smooth_rates, "bool smooth_rates = true");
  declare(law.smallest_stretch != 0.0, fmt::format("double smallest_stretch = {}", argument(law.smallest_stretch)));
  declare(std::isfinite(law.largest_stretch),
          fmt::format("double largest_stretch = {}", argument(law.largest_stretch)));
}

// Of the formulas for one function of the class.
SourceFunction function_of(const std::string& name, const std::vector<const std::string*>& texts, bool is_list,
                           Symbols& symbols, const SourceNames& names) {
  Graph graph;
  const Plain plain(graph);
  const auto argument = [&](std::size_t column) { return graph.input(static_cast<std::uint32_t>(column)); };
  std::vector<formula::Node> roots;
  for (const std::string* text : texts) roots.push_back(Evaluation(plain, symbols, argument).value(parse(*text)));
  SourceFunction function{name, statements_of(graph, roots, is_list, names)};
  for (const std::string& statement : function.statements) {
    function.uses_element = function.uses_element || statement.find("e.") != std::string::npos;
    function.uses_parameters = function.uses_parameters || statement.find("p[") != std::string::npos;
  }
  return function;
}

}  // namespace
}  // namespace formula

FormulaSource source_of(const LawFormula& given) {
  using namespace formula;
  LawFormula law = given;
  for (const std::string& name : free_names(law)) {
    const auto is_it = [&](const FormulaSymbol& each) { return each.name == name; };
    if (std::none_of(law.parameters.begin(), law.parameters.end(), is_it)) law.parameters.push_back({name});
  }
  check_names("parameter", law.parameters);
  check_names("input", law.inputs);
  check_names("state", law.states);
  check_names("curve", law.curves);
  const std::shared_ptr<const Component> component = component_of(law);  // says what else is wrong

  FormulaSource source;
  Symbols symbols(law);
  SourceNames names{symbols.layout(), !law.scalars.empty(), law.curves.size(), {}, {}, {}, {}, {}};
  Enumerators enumerators(law);
  const auto name_all = [&](const auto& list, std::vector<std::string>& to) {
    for (const auto& each : list) to.push_back(enumerators.of(each.name));
  };
  for (const FormulaSymbol& each : law.parameters) source.parameters.push_back(each.name);
  name_all(law.parameters, names.parameters);
  name_all(law.states, names.states);
  name_all(law.inputs, names.inputs);
  name_all(law.scalars, names.scalars);
  for (const FormulaCurve& each : law.curves)
    for (const char* axis : {"_x", "_y"}) source.table_keys.push_back(enumerators.another(each.name + axis));
  source.enumerators = names.parameters;
  for (const auto& list : {names.parameters, names.states, names.inputs, names.scalars})
    if (!list.empty()) source.enums.push_back(list);

  const auto add = [&](const std::string& name, const std::vector<const std::string*>& texts, bool is_list) {
    source.functions.push_back(function_of(name, texts, is_list, symbols, names));
  };
  const auto addresses = [](const auto& list, const auto& text) {
    std::vector<const std::string*> result;
    for (const auto& each : list) result.push_back(&text(each));
    return result;
  };
  if (!law.force.empty()) add("force", {&law.force}, false);
  if (!law.forces.empty())
    add("force", addresses(law.forces, [](const std::string& each) -> const std::string& { return each; }), true);
  if (!law.states.empty())
    add("state_rates", addresses(law.states, [](const FormulaState& each) -> const std::string& { return each.rate; }),
        true);
  if (!law.energy.empty()) add("energy", {&law.energy}, false);
  if (!law.margin.empty()) add("margin", {&law.margin}, false);

  add_declarations(law, *component, symbols.reads(), source);
  for (SourceList list : {parameter_list(law), state_list(law), input_list(law), invariant_list(*component)})
    if (!list.entries.empty()) source.lists.push_back(std::move(list));
  add_curves(law, source);
  return source;
}

}  // namespace springnet
