#include "formula/writer.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace springnet::formula {
namespace {

// Longer expressions get a name, in a statement of their own.
constexpr std::size_t longest_expression = 70;

// How tightly an expression binds, from loosest to tightest.
enum Level { choice, either, both, comparison, sum, product, sign, single };

struct Text {
  std::string text;
  Level level = single;
};

}  // namespace

std::string number_text(double value) {
  if (std::isnan(value)) return "std::numeric_limits<double>::quiet_NaN()";
  if (std::isinf(value)) return fmt::format("{}std::numeric_limits<double>::infinity()", value < 0.0 ? "-" : "");
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

namespace {

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
  Writer(const Graph& graph, const SourceNames& names)
      : graph_(graph), layout_(names.layout), names_(names), texts_(graph.size()), is_dual_(graph.size(), false) {}

  std::vector<std::string> statements_of(const std::vector<Node>& roots, bool is_list) {
    find_duals();
    std::vector<std::size_t> uses(graph_.size(), 0);
    for (const Node root : roots) ++uses[root];
    for (Node node = static_cast<Node>(graph_.size()); node-- > 0;)
      if (uses[node] > 0)
        for (const Node operand : written(node).operands) ++uses[operand];
    std::vector<std::string> statements;
    for (Node node = 0; node < graph_.size(); ++node) {
      if (uses[node] == 0) continue;
      texts_[node] = text_of(node);
      const bool is_plain = written(node).operands.empty() || written(node).idiom == Idiom::elongation;
      const bool is_alone = !is_list && node == roots[0];
      if (is_plain || (uses[node] == 1 && (is_alone || texts_[node].text.size() <= longest_expression))) continue;
      const std::string name = next_name();
      statements.push_back(fmt::format("const auto {} = {};", name, texts_[node].text));
      texts_[node] = {name, single};
    }
    const std::string start = is_list ? fmt::format("return {}{{", type_of(roots)) : "return ";
    std::vector<std::string> results;
    std::size_t length = start.size();
    for (const Node root : roots) {
      results.push_back(texts_[root].text);
      length += results.back().size() + 2;
    }
    constexpr std::size_t longest_list = 110;
    const std::string next = length <= longest_list ? ", " : ",\n" + std::string(4 + start.size(), ' ');
    statements.push_back(fmt::format("{}{}{};", start, fmt::join(results, next), is_list ? "}" : ""));
    return statements;
  }

 private:
  // A std::array of dual numbers; a plain number among them needs its type.
  [[nodiscard]] std::string type_of(const std::vector<Node>& roots) const {
    if (std::all_of(roots.begin(), roots.end(), [&](Node root) { return is_dual_[root]; })) return "std::array";
    const char* const number = names_.several ? "decltype(e.reference[0] + 0.0)" : "decltype(e.reference + 0.0)";
    return fmt::format("std::array<{}, {}>", number, roots.size());
  }
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
    return !names_.several && step.code == Code::difference && is_input(step.a, layout_.value()) &&
           is_input(step.b, layout_.reference());
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
    // Of the value, its rate or its reference.
    const auto of = [&](const char* name, std::size_t first) {
      if (!names_.several) return Text{fmt::format("e.{}", name)};
      return Text{fmt::format("e.{}[{}]", name, names_.scalars[column - first])};
    };
    if (column < layout_.rate(0)) return of("q", layout_.value(0));
    if (column < layout_.reference(0)) return of("rate", layout_.rate(0));
    if (column < layout_.parameter(0)) return of("reference", layout_.reference(0));
    if (column < layout_.state(0)) return {fmt::format("p[{}]", names_.parameters[column - layout_.parameter(0)])};
    if (column < layout_.input(0)) return {fmt::format("e.state({})", names_.states[column - layout_.state(0)])};
    if (column < layout_.time()) return {fmt::format("e.input({})", names_.inputs[column - layout_.input(0)])};
    if (column == layout_.time()) return {"e.time"};
    return {fmt::format("e.direction[{}]", column - layout_.direction(0))};
  }
  // e.table, or one of several: e.table[1].
  [[nodiscard]] Text curve(const Step& step) const {
    const std::string which = names_.curve_count == 1 ? "" : fmt::format("[{}]", step.index);
    return {fmt::format("e.table{}({})", which, texts_[step.a].text)};
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
      case Code::curve:
        return curve(step);
      default:
        return call(function_of(step.code), own.operands);
    }
  }

  // x1, x2, …, other than the parameters.
  std::string next_name() {
    for (;;) {
      std::string name = fmt::format("x{}", ++named_);
      if (!names_.has(name)) return name;
    }
  }

  const Graph& graph_;
  const sdk::JacobianLayout layout_;
  const SourceNames& names_;
  std::vector<Text> texts_;
  std::vector<bool> is_dual_;
  std::size_t named_ = 0;
};

}  // namespace

bool SourceNames::has(const std::string& name) const {
  const auto is_in = [&](const std::vector<std::string>& list) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  return is_in(parameters) || is_in(states) || is_in(inputs) || is_in(scalars) || is_in(tables);
}

std::vector<std::string> statements_of(const Graph& graph, const std::vector<Node>& roots, bool is_list,
                                       const SourceNames& names) {
  return Writer(graph, names).statements_of(roots, is_list);
}

}  // namespace springnet::formula
