// Formulas as C++: the steps of their graph as expressions of the SDK.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/formula_source.hpp>
#include <springnet/suggestion.hpp>

#include "formula/derive.hpp"

namespace springnet {
namespace formula {
namespace {

// Longer expressions get a name, in a statement of their own.
constexpr std::size_t longest_expression = 70;

// Names that an enumerator of a law's class cannot have: keywords, macros of the C library, members of the class and of
// its bases that the SDK reads, the names in the statements.
constexpr std::string_view taken_names =
    " alignas alignof and and_eq asm auto bitand bitor bool break case catch char class co_await co_return co_yield "
    "compl concept const const_cast consteval constexpr constinit continue decltype default delete do double "
    "dynamic_cast else enum explicit export extern false float for friend goto if inline int long mutable namespace "
    "new noexcept not not_eq nullptr operator or or_eq private protected public register reinterpret_cast requires "
    "return short signed sizeof static static_assert static_cast struct switch template this thread_local throw true "
    "try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor xor_eq "
    "errno assert stdin stdout stderr linux unix "
    "has id summary reference kind invariant acts_in_compression reads_rate reads_time monotone not_zero_at_rest "
    "adds_power calling_thread_only fits_elements divides_by_reference smallest_stretch largest_stretch update_order "
    "smooth_rates shape reads_direction parameters invariants states state_rates inputs tables prepare update start "
    "force energy margin number springnet std e p ";

std::string enumerator_of(std::string name, const std::vector<std::string>& parameters) {
  if (taken_names.find(fmt::format(" {} ", name)) == std::string_view::npos) return name;
  do name += '_';
  while (std::find(parameters.begin(), parameters.end(), name) != parameters.end());
  return name;
}

// How tightly an expression binds, from loosest to tightest.
enum Level { choice, either, both, comparison, sum, product, sign, single };

struct Text {
  std::string text;
  Level level = single;
};

std::string number_text(double value) {
  if (std::isnan(value)) return "std::numeric_limits<double>::quiet_NaN()";
  if (std::isinf(value)) return fmt::format("{}std::numeric_limits<double>::infinity()", value < 0.0 ? "-" : "");
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string_view function_of(Code code) {
  constexpr std::pair<Code, std::string_view> names[] = {
      {Code::absolute, "abs"}, {Code::floor, "floor"}, {Code::ceil, "ceil"},   {Code::sqrt, "sqrt"},
      {Code::cbrt, "cbrt"},    {Code::exp, "exp"},     {Code::expm1, "expm1"}, {Code::log, "log"},
      {Code::log1p, "log1p"},  {Code::log10, "log10"}, {Code::sin, "sin"},     {Code::cos, "cos"},
      {Code::tan, "tan"},      {Code::asin, "asin"},   {Code::acos, "acos"},   {Code::atan, "atan"},
      {Code::sinh, "sinh"},    {Code::cosh, "cosh"},   {Code::tanh, "tanh"},   {Code::erf, "erf"},
      {Code::power, "pow"},    {Code::hypot, "hypot"}, {Code::atan2, "atan2"}};
  for (const auto& [each, name] : names)
    if (each == code) return name;
  return "";
}

// What a step is written as, where that is more than its code says.
enum class Idiom { none, elongation, strain, least, greatest, within };
struct Written {
  Idiom idiom = Idiom::none;
  std::vector<Node> operands;
};

class Writer {
 public:
  Writer(const Graph& graph, const sdk::JacobianLayout& layout, const FormulaSource& names)
      : graph_(graph), layout_(layout), names_(names), texts_(graph.size()), is_dual_(graph.size(), false) {}

  std::vector<std::string> statements_of(Node root) {
    find_duals();
    std::vector<std::size_t> uses(graph_.size(), 0);
    uses[root] = 1;
    for (Node node = root + 1; node-- > 0;)
      if (uses[node] > 0)
        for (const Node operand : written(node).operands) ++uses[operand];
    std::vector<std::string> statements;
    for (Node node = 0; node < root; ++node) {
      if (uses[node] == 0) continue;
      texts_[node] = text_of(node);
      const bool is_plain = written(node).operands.empty() || written(node).idiom == Idiom::elongation;
      if (is_plain || (uses[node] == 1 && texts_[node].text.size() <= longest_expression)) continue;
      const std::string name = next_name();
      statements.push_back(fmt::format("const auto {} = {};", name, texts_[node].text));
      texts_[node] = {name, single};
    }
    statements.push_back(fmt::format("return {};", text_of(root).text));
    return statements;
  }

 private:
  // Not every function of the SDK takes a double in each place of a dual number.
  void find_duals() {
    for (Node node = 0; node < graph_.size(); ++node) {
      const Step& step = graph_[node];
      if (step.code == Code::constant || is_condition(step.code)) continue;
      const auto is_dual = [&](Node operand) { return operand != no_node && is_dual_[operand]; };
      is_dual_[node] = step.code == Code::input || (step.code != Code::choose && is_dual(step.a)) || is_dual(step.b) ||
                       is_dual(step.c);
    }
  }
  static bool is_condition(Code code) {
    return code == Code::less || code == Code::less_or_equal || code == Code::equal || code == Code::both ||
           code == Code::either || code == Code::negation;
  }

  [[nodiscard]] bool is_input(Node node, std::size_t column) const {
    return graph_[node].code == Code::input && graph_[node].index == column;
  }
  [[nodiscard]] bool is_elongation(Node node) const {
    const Step& step = graph_[node];
    return step.code == Code::difference && is_input(step.a, layout_.value()) && is_input(step.b, layout_.reference());
  }

  [[nodiscard]] Written written(Node node) const {
    const Step& step = graph_[node];
    if (step.code == Code::constant || step.code == Code::input) return {};
    if (is_elongation(node)) return {Idiom::elongation, {}};
    if (step.code == Code::quotient && is_elongation(step.a) && is_input(step.b, layout_.reference()))
      return {Idiom::strain, {}};
    if (step.code == Code::choose && graph_[step.a].code == Code::less) {
      const Node left = graph_[step.a].a, right = graph_[step.a].b;
      if (step.b == left && step.c == right) return {Idiom::least, {right, left}};
      if (step.b == right && step.c == left) return {Idiom::greatest, {left, right}};
      // x < low ? low : (high < x ? high : x)
      const Written other = written(step.c);
      if (step.b == right && is_dual_[left] && other.idiom == Idiom::least && other.operands[0] == left)
        return {Idiom::within, {left, right, other.operands[1]}};
    }
    Written result;
    for (const Node operand : {step.a, step.b, step.c})
      if (operand != no_node) result.operands.push_back(operand);
    return result;
  }

  [[nodiscard]] std::string operand(Node node, Level level) const {
    const Text& own = texts_[node];
    return own.level < level ? fmt::format("({})", own.text) : own.text;
  }
  [[nodiscard]] Text call(std::string_view name, const std::vector<Node>& operands) const {
    std::string text;
    for (const Node each : operands) text += (text.empty() ? "" : ", ") + texts_[each].text;
    return {fmt::format("{}({})", name, text), single};
  }
  // Brackets as written: (a + b) + c is not a + (b + c).
  [[nodiscard]] Text between(const Step& step, std::string_view symbol, Level level) const {
    const auto tighter = static_cast<Level>(static_cast<int>(level) + 1);
    const Level left = level == sum || level == product ? level : tighter;
    return {fmt::format("{} {} {}", operand(step.a, left), symbol, operand(step.b, tighter)), level};
  }

  [[nodiscard]] Text input(std::size_t column) const {
    if (column == layout_.value()) return {"e.q"};
    if (column == layout_.rate()) return {"e.rate"};
    if (column == layout_.reference()) return {"e.reference"};
    if (column == layout_.time()) return {"e.time"};
    return {fmt::format("p[{}]", names_.enumerators[column - layout_.parameter(0)])};
  }

  [[nodiscard]] Text text_of(Node node) const {
    const Step& step = graph_[node];
    const Written own = written(node);
    switch (own.idiom) {
      case Idiom::elongation:
        return {"e.elongation()"};
      case Idiom::strain:
        return {"e.strain()"};
      case Idiom::least:
        return call("min", own.operands);
      case Idiom::greatest:
        return call("max", own.operands);
      case Idiom::within:
        return call("clamp", own.operands);
      case Idiom::none:
        break;
    }
    switch (step.code) {
      case Code::constant:
        return {number_text(step.number), std::signbit(step.number) ? sign : single};
      case Code::input:
        return input(step.index);
      case Code::negative:
        return {fmt::format("-{}", operand(step.a, single)), sign};
      case Code::sum:
        return between(step, "+", sum);
      case Code::difference:
        return between(step, "-", sum);
      case Code::product:
        return between(step, "*", product);
      case Code::quotient:
        return between(step, "/", product);
      case Code::less:
        return between(step, "<", comparison);
      case Code::less_or_equal:
        return between(step, "<=", comparison);
      case Code::equal:
        return between(step, "==", comparison);
      case Code::both:
        return between(step, "&&", both);
      case Code::either:
        return {fmt::format("{} || {}", operand(step.a, comparison), operand(step.b, comparison)), either};
      case Code::negation:
        return {fmt::format("!{}", operand(step.a, single)), sign};
      case Code::choose:
        return {fmt::format("{} ? {} : {}", operand(step.a, both), operand(step.b, sum), operand(step.c, sum)), choice};
      default:
        return call(function_of(step.code), own.operands);
    }
  }

  // x1, x2, …, other than the parameters.
  std::string next_name() {
    for (;;) {
      std::string name = fmt::format("x{}", ++named_);
      const auto& taken = names_.enumerators;
      if (std::find(taken.begin(), taken.end(), name) == taken.end()) return name;
    }
  }

  const Graph& graph_;
  const sdk::JacobianLayout layout_;
  const FormulaSource& names_;
  std::vector<Text> texts_;
  std::vector<bool> is_dual_;
  std::size_t named_ = 0;
};

[[noreturn]] void refuse(std::string_view what) { throw Error(ErrorKind::input, std::string(what)); }

void refuse_what_is_declared(const LawFormula& law) {
  constexpr std::string_view how = "write the plugin for the force alone, and add it as the author's guide shows";
  if (!law.energy.empty()) refuse(fmt::format("an energy is not translated; {} (\"Energy, rupture\")", how));
  if (!law.margin.empty()) refuse(fmt::format("a margin is not translated; {} (\"Energy, rupture\")", how));
  if (!law.inputs.empty()) refuse(fmt::format("inputs are not translated; {} (\"Inputs\")", how));
  if (!law.states.empty()) refuse(fmt::format("internal states are not translated; {} (\"Laws with memory\")", how));
  if (!law.curves.empty()) refuse(fmt::format("curves are not translated; {} (\"Tables\")", how));
  if (!law.scalars.empty() || !law.forces.empty())
    refuse(fmt::format("a law over several scalars is not translated; {} (\"Laws over several invariants\")", how));
  if (law.force.empty()) refuse("the law has no formula; give its force");
}

// Names and calls whose meaning is data of a scene, or that need elements.
void refuse_terms(const Expression& formula) {
  const auto fail = [&](const Term& term, const std::string& what) { fail_at(formula.text, term.place, what); };
  for (const Term& term : formula.terms) {
    const std::string& name = term.name;
    if (term.operation == Operation::call && (name == "rest" || name == "rate"))
      fail(term, fmt::format("'{0}(…)' is for laws over several scalars, which are not translated; write '{0}', or the "
                             "law as the author's guide shows (\"Laws over several invariants\")",
                             name));
    if (term.operation == Operation::call && !is_function(name)) {
      const std::string nearest = suggestion(name, function_names());
      fail(term, fmt::format("there is no function '{}'{}{}; a curve by points is a table of the plugin: write the law "
                             "without it, then add it as the author's guide shows (\"Tables\")",
                             name, nearest.empty() ? "" : "; ", nearest));
    }
    if (term.operation != Operation::name) continue;
    if (name.starts_with("direction_"))
      fail(term, fmt::format("'{}' is for laws over several scalars, which are not translated; see \"Laws over several "
                             "invariants\" in the author's guide",
                             name));
    for (const auto& [word, constant] : {std::pair("angle", "SPRINGNET_ANGLE"), std::pair("area", "SPRINGNET_AREA"),
                                         std::pair("volume", "SPRINGNET_VOLUME")})
      if (name == word)
        fail(term, fmt::format("'{}' is not translated, because the scene of a new plugin has springs; write 'value', "
                               "and in the class `static constexpr std::uint32_t invariant = {};`",
                               name, constant));
  }
}

// As the engine has it for parameters of plugins: snake_case, and keys of scenes are taken.
void check_names(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (name[0] == '_')
      refuse(fmt::format("parameter '{}': names of a plugin's parameters begin with a lower-case letter; rename it",
                         name));
    if (name == "type" || name == "name")
      refuse(fmt::format("parameter '{}': scenes have this key beside the parameters of a law; rename it", name));
  }
}

// Whether the law pulls or pushes at the reference value and at rest, with parameters of no special value.
bool is_loaded_at_rest(const Component& component) {
  constexpr double one = 1.0, nothing = 0.0, rounding = 1e-12;
  std::vector<double> values;
  std::vector<const double*> parameters;
  for (std::size_t k = 0; k < component.description->parameter_count; ++k)
    values.push_back(0.9 + 0.37 * static_cast<double>(k));
  for (const double& value : values) parameters.push_back(&value);
  const std::vector<std::uint32_t> strides(values.size(), 0);
  double force = 0.0;
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.time = 0.6;
  batch.q = component.law().invariant == SPRINGNET_RELATIVE_SPEED ? &nothing : &one;
  batch.rate = &nothing;
  batch.reference = &one;
  batch.parameters = parameters.data();
  batch.parameter_strides = strides.data();
  batch.force = &force;
  return component.law().evaluate(component.law().context, &batch) == SPRINGNET_OK && std::abs(force) > rounding;
}

}  // namespace
}  // namespace formula

FormulaSource source_of(const LawFormula& given) {
  using namespace formula;
  refuse_what_is_declared(given);
  LawFormula law = given;
  Expression expression;
  try {
    expression = parse(law.force);
    refuse_terms(expression);
  } catch (const Error& error) {
    throw Error(error.kind(), fmt::format("force: {}", error.what()));
  }
  for (const std::string& name : free_names(law)) {
    const auto is_it = [&](const FormulaSymbol& each) { return each.name == name; };
    if (std::none_of(law.parameters.begin(), law.parameters.end(), is_it)) law.parameters.push_back({name});
  }
  FormulaSource source;
  for (const FormulaSymbol& each : law.parameters) source.parameters.push_back(each.name);
  check_names(source.parameters);
  const std::shared_ptr<const Component> component = component_of(law);  // says what else is wrong

  for (const std::string& name : source.parameters)
    source.enumerators.push_back(enumerator_of(name, source.parameters));

  Symbols symbols(law);
  Graph graph;
  const Plain plain(graph);
  const auto argument = [&](std::size_t column) { return graph.input(static_cast<std::uint32_t>(column)); };
  const formula::Node root = Evaluation(plain, symbols, argument).value(expression);
  source.statements = Writer(graph, symbols.layout(), source).statements_of(root);

  const Reads& reads = symbols.reads();
  const auto declare = [&](bool is, std::string_view what) {
    if (is) source.declarations.push_back(fmt::format("static constexpr {};", what));
  };
  const bool relative = reads.invariant == SPRINGNET_RELATIVE_SPEED;
  declare(relative, "std::uint32_t invariant = SPRINGNET_RELATIVE_SPEED");
  declare(reads.rate && law.kind == ComponentKind::spring_function, "bool reads_rate = true");
  declare(reads.time, "bool reads_time = true");
  declare(is_loaded_at_rest(*component), "bool not_zero_at_rest = true");
  declare(reads.divides_by_reference, "bool divides_by_reference = true");
  declare(reads.fits_elements && !relative, "bool fits_elements = true");
  for (const std::string& statement : source.statements) {
    source.uses_element = source.uses_element || statement.find("e.") != std::string::npos;
    source.uses_parameters = source.uses_parameters || statement.find("p[") != std::string::npos;
  }
  return source;
}

}  // namespace springnet
