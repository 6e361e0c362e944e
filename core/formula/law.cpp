#include "formula/law.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "formula/derive.hpp"
#include "formula/element.hpp"

namespace springnet::formula {
namespace {

// Messages of a formula begin with what it is.
template <class What>
auto at(std::string_view formula, const What& what) {
  try {
    return what();
  } catch (const Error& error) {
    throw Error(error.kind(), fmt::format("{}: {}", formula, error.what()));
  }
}

struct Parsed {
  std::string what;
  Expression formula;
};
std::vector<Parsed> parse_all(const LawFormula& law, const Symbols& symbols) {
  std::vector<Parsed> result;
  for (const NamedFormula& each : formulas_of(law)) {
    result.push_back({each.what, parse_named(each)});
    at(each.what, [&] { symbols.check_definitions(result.back().formula); });
  }
  return result;
}
const Parsed* find(const std::vector<Parsed>& all, std::string_view what) {
  for (const Parsed& each : all)
    if (each.what == what) return &each;
  return nullptr;
}

// Columns that differ in nothing but the numbers they are derivatives by: some at a time, see sdk/law/kernel.hpp.
constexpr std::size_t at_a_time = 4;
std::vector<std::pair<std::size_t, std::size_t>> groups_of(const sdk::JacobianLayout& layout) {
  std::vector<std::pair<std::size_t, std::size_t>> groups;
  const std::size_t last = layout.columns(false);
  for (std::size_t column = 0; column < last;) {
    std::size_t end = std::min(last, column + at_a_time);
    for (const std::size_t border :
         {layout.rate(), layout.reference(), layout.parameter(0), layout.state(0), layout.time(), layout.direction(0)})
      if (column < border) end = std::min(end, border);
    groups.emplace_back(column, end - column);
    column = end;
  }
  return groups;
}

}  // namespace

void fail_unknown_function(const Expression& formula, const Term& term) {
  const std::string nearest =
      term.name == "ln" ? "the natural logarithm is 'log'" : suggestion(term.name, function_names());
  fail_at(formula.text, term.place,
          fmt::format("there is no function '{}'{}{}", printable(term.name), nearest.empty() ? "" : "; ", nearest));
}

double scale_of(const FormulaSymbol& symbol) {
  if (!std::isnan(symbol.scale)) return symbol.scale;
  return std::isnan(symbol.preset) || symbol.preset == 0.0 ? 1.0 : std::abs(symbol.preset);
}

double scale_of(const FormulaState& state) {
  if (!std::isnan(state.scale)) return state.scale;
  return state.start == 0.0 ? 1.0 : std::abs(state.start);
}

Law::CurvesOf::CurvesOf(const std::vector<FormulaCurve>& curves) {
  for (const FormulaCurve& each : curves) {
    try {
      curves_.emplace_back(each.x, each.y, sdk::Beyond::linear);
    } catch (const std::invalid_argument& error) {
      throw Error(ErrorKind::input, fmt::format("curve '{}': {}", printable(each.name), error.what()));
    }
  }
}

void Law::CurvesOf::evaluate(std::uint32_t table, unsigned order, const double* x, double* out,
                             std::size_t count) const {
  using Once = sdk::Dual<1>;
  const sdk::MonotoneCubic& curve = curves_[table];
  for (std::size_t i = 0; i < count; ++i) {
    if (order == 0) {
      out[i] = curve(x[i]);
    } else if (order == 1) {
      out[i] = curve(Once::variable(x[i], 0)).derivatives[0];
    } else {
      using Twice = sdk::Dual<1, Once>;
      out[i] = curve(Twice::variable(Once::variable(x[i], 0), 0)).derivatives[0].derivatives[0];
    }
  }
}

bool Law::is_often_same(std::uint32_t column) const {
  return column >= layout_.parameter(0) ? column < layout_.direction(0) : !several_ && column >= layout_.reference();
}

// values(algebra, argument): the rows in the numbers of an algebra, whose arguments argument(column) gives.
template <class Values>
Law::Quantity Law::quantity(std::size_t rows, std::size_t tangent_columns, const Values& values) const {
  Quantity result;
  result.rows = rows;
  const auto same = [this](std::uint32_t column) { return is_often_same(column); };
  {
    Graph graph;
    const Plain plain(graph);
    const auto argument = [&](std::size_t column) { return graph.input(static_cast<std::uint32_t>(column)); };
    result.values = schedule(graph, values(plain, argument), same);
  }
  // By `count` columns from `first` on; with_values: these first.
  const auto derivatives = [&](std::size_t first, std::size_t count, bool with_values) {
    Graph graph;
    const Forward<Plain> forward(Plain(graph), count);
    const auto argument = [&](std::size_t column) {
      auto number = forward.lift(graph.input(static_cast<std::uint32_t>(column)));
      if (column >= first && column < first + count) number.derivatives[column - first] = graph.constant(1.0);
      return number;
    };
    const auto all = values(forward, argument);
    std::vector<Node> nodes;
    if (with_values)
      for (const auto& row : all) nodes.push_back(row.value);
    for (const auto& row : all) nodes.insert(nodes.end(), row.derivatives.begin(), row.derivatives.end());
    return schedule(graph, nodes, same);
  };
  if (tangent_columns > 0) result.tangent = derivatives(0, tangent_columns, true);
  for (const auto& [first, count] : groups_of(layout_))
    result.columns.push_back({first, count, derivatives(first, count, false)});
  return result;
}

namespace {

// The rows of a law's forces in an algebra: its formulas, or the derivatives of its energy.
template <class Algebra, class Argument>
std::vector<typename Algebra::Number> forces_in(const Algebra& algebra, const Argument& argument, Symbols& symbols,
                                                const std::vector<const Parsed*>& forces, const Parsed* energy) {
  std::vector<typename Algebra::Number> rows;
  for (const Parsed* each : forces)
    rows.push_back(at(each->what, [&] { return Evaluation(algebra, symbols, argument).value(each->formula); }));
  if (!forces.empty()) return rows;
  const std::size_t scalars = symbols.layout().invariants;
  const Forward<Algebra> lifted(algebra, scalars);
  const auto by_values = [&](std::size_t column) {
    auto number = lifted.lift(argument(column));
    if (column < scalars) number.derivatives[column] = algebra.constant(1.0);
    return number;
  };
  return at(energy->what, [&] { return Evaluation(lifted, symbols, by_values).value(energy->formula); }).derivatives;
}

}  // namespace

Law::Law(const LawFormula& law) : several_(!law.scalars.empty()), curves_(law.curves) {
  Symbols symbols(law);
  layout_ = symbols.layout();
  if (several_ && !law.force.empty())
    throw Error(ErrorKind::input, "a law over several scalars has a force for each of them, or an energy alone");
  if (law.scalars.size() > SPRINGNET_MOST_INVARIANTS)
    throw Error(ErrorKind::input, fmt::format("the law reads {} scalars; at most {} can be read", law.scalars.size(),
                                              SPRINGNET_MOST_INVARIANTS));
  if (law.parameters.size() > max_parameters || law.inputs.size() > max_inputs)
    throw Error(ErrorKind::input, fmt::format("the law has {} parameters and {} inputs; at most {} and {} are possible",
                                              law.parameters.size(), law.inputs.size(), max_parameters, max_inputs));
  if (!law.forces.empty() && law.forces.size() != law.scalars.size())
    throw Error(ErrorKind::input, fmt::format("the law has {} forces and reads {} scalars; give one for each",
                                              law.forces.size(), law.scalars.size()));
  if (!law.states.empty()) {
    if (several_)
      throw Error(ErrorKind::input, "a law over several scalars cannot have states; give it none, or one scalar");
    if (law.states.size() > max_states || law.parameters.size() > max_parameters_beside_states ||
        law.inputs.size() > max_inputs_beside_states)
      throw Error(ErrorKind::input,
                  fmt::format("a formula with states has at most {} of them, {} parameters and {} inputs, not {}, {} "
                              "and {}; write a plugin",
                              max_states, max_parameters_beside_states, max_inputs_beside_states, law.states.size(),
                              law.parameters.size(), law.inputs.size()));
  }
  for (const FormulaState& each : law.states)
    states_.push_back(sdk::number("", "", "").at_least(each.smallest).at_most(each.largest).learnable(scale_of(each)));
  smooth_rates_ = law.smooth_rates;
  const std::vector<Parsed> all = parse_all(law, symbols);
  std::vector<const Parsed*> forces;
  for (const Parsed& each : all)
    if (each.what.starts_with("force")) forces.push_back(&each);
  std::vector<const Parsed*> rates;
  for (const Parsed& each : all)
    if (each.what.starts_with("rate of ")) rates.push_back(&each);
  const Parsed* const energy = find(all, "energy");
  const Parsed* const margin = find(all, "margin");
  if (forces.empty() && energy == nullptr)
    throw Error(ErrorKind::input, "the law has no formula; give its force, or its energy");

  // What they read is known once each has been looked at.
  {
    Graph graph;
    const Plain plain(graph);
    const auto argument = [&](std::size_t column) { return graph.input(static_cast<std::uint32_t>(column)); };
    static_cast<void>(forces_in(plain, argument, symbols, forces, energy));
    for (const Parsed* each : {energy, margin})
      if (each != nullptr) at(each->what, [&] { return Evaluation(plain, symbols, argument).value(each->formula); });
    for (const Parsed* each : rates)
      at(each->what, [&] { return Evaluation(plain, symbols, argument).value(each->formula); });
  }
  reads_ = symbols.reads();
  for (std::size_t k = 0; k < law.parameters.size(); ++k)
    if (!reads_.parameter[k])
      throw Error(ErrorKind::input,
                  fmt::format("parameter '{}': no formula of the law reads it; remove it", law.parameters[k].name));
  for (std::size_t k = 0; k < law.inputs.size(); ++k)
    if (!reads_.input[k])
      throw Error(ErrorKind::input,
                  fmt::format("input '{}': no formula of the law reads it; remove it", law.inputs[k].name));
  if (reads_.invariant == 0) reads_.invariant = SPRINGNET_LENGTH;
  if (law.kind == ComponentKind::viscosity_function && reads_.invariant != SPRINGNET_RELATIVE_SPEED && !several_)
    reads_.rate = true;
  if (reads_.rate && energy != nullptr && forces.empty())
    throw Error(ErrorKind::input,
                "energy: an energy does not depend on rates; write what they do as a force of its own");
  if (law.smooth_rates && law.states.empty())
    throw Error(ErrorKind::input, "'smooth rates' are declared of states, and the law has none; remove that");
  tangent_columns_ = layout_.invariants * (reads_.rate ? 2 : 1);

  force_ = quantity(layout_.invariants, tangent_columns_, [&](const auto& algebra, const auto& argument) {
    return forces_in(algebra, argument, symbols, forces, energy);
  });
  const auto single = [&](const Parsed* parsed) {
    return quantity(1, 0, [&](const auto& algebra, const auto& argument) {
      return std::vector{Evaluation(algebra, symbols, argument).value(parsed->formula)};
    });
  };
  if (energy != nullptr) energy_ = single(energy);
  if (margin != nullptr) margin_ = single(margin);
  if (!rates.empty())
    rates_ = quantity(rates.size(), 0, [&](const auto& algebra, const auto& argument) {
      using Number = decltype(algebra.constant(0.0));
      std::vector<Number> rows;
      for (const Parsed* each : rates) rows.push_back(Evaluation(algebra, symbols, argument).value(each->formula));
      return rows;
    });
  if (!rates.empty())
    for (const Program* each : {&force_.values, &energy_.values, &margin_.values, &rates_.values})
      if (each->places() > max_element_places)
        throw Error(ErrorKind::input, "a formula of a law with states has too many operations; write a plugin");
}

// The arguments of a batch by their columns.
struct Law::Arguments {
  static constexpr sdk::JacobianLayout most{SPRINGNET_MOST_INVARIANTS, max_parameters, max_states, max_inputs};
  // Not initialised beyond what the layout has.
  std::array<const double*, most.columns(false)> values;
  std::array<std::uint32_t, most.columns(false)> strides;

  Arguments(const springnet_law_batch& b, const sdk::JacobianLayout& layout, bool several) {
    const auto set = [&](std::size_t column, const double* from, std::uint32_t stride) {
      values[column] = from;
      strides[column] = stride;
    };
    for (std::size_t i = 0; several && i < layout.invariants; ++i) {
      set(layout.value(i), b.values[i], 1);
      set(layout.rate(i), b.rates == nullptr ? nullptr : b.rates[i], 1);
      set(layout.reference(i), b.references[i], 1);
    }
    if (!several) {
      static constexpr double no_reference = 0.0;
      set(layout.value(), b.q, 1);
      set(layout.rate(), b.rate, 1);
      set(layout.reference(), b.reference == nullptr ? &no_reference : b.reference,
          b.reference == nullptr ? 0 : b.reference_stride);
    }
    for (std::size_t k = 0; k < layout.parameters; ++k)
      set(layout.parameter(k), b.parameters[k], b.parameter_strides[k]);
    for (std::size_t k = 0; k < layout.states; ++k) set(layout.state(k), b.states[k], 1);
    for (std::size_t k = 0; k < layout.inputs; ++k) set(layout.input(k), b.inputs[k], b.input_strides[k]);
    set(layout.time(), &b.time, 0);
    for (std::size_t c = 0; b.direction != nullptr && c < 3; ++c) set(layout.direction(c), b.direction[c], 1);
  }
};

// All columns of a quantity from `first` on, as far as to(row, column) asks for them.
template <class To>
void Law::run_columns(const Quantity& quantity, const Batch& batch, std::size_t first, const To& to) const {
  std::array<double*, SPRINGNET_MOST_INVARIANTS * at_a_time> outputs;
  for (const Columns& group : quantity.columns) {
    if (group.first < first) continue;
    bool wanted = false;
    for (std::size_t row = 0; row < quantity.rows; ++row)
      for (std::size_t k = 0; k < group.count; ++k) {
        double* const output = outputs[row * group.count + k] = to(row, group.first + k);
        wanted = wanted || output != nullptr;
      }
    if (wanted) run(group.program, batch, outputs.data());
  }
}

void Law::evaluate(const springnet_law_batch& b) const {
  const Arguments arguments(b, layout_, several_);
  const Batch batch{b.count, arguments.values.data(), arguments.strides.data(), &curves_, b.instruction_set};
  const std::size_t columns = layout_.columns(false), scalars = layout_.invariants;
  const auto in_matrix = [&](std::size_t row, std::size_t column) -> double* {
    return b.derivatives == nullptr ? nullptr : b.derivatives[row * columns + column];
  };

  // Forces and their tangent.
  std::array<double*, SPRINGNET_MOST_INVARIANTS*(1 + 2 * SPRINGNET_MOST_INVARIANTS)> outputs;
  bool forces = false, tangent = false;
  for (std::size_t i = 0; i < scalars; ++i) {
    outputs[i] = several_ ? (b.forces == nullptr ? nullptr : b.forces[i]) : b.force;
    forces = forces || outputs[i] != nullptr;
    for (std::size_t j = 0; j < tangent_columns_; ++j) {
      double* const own = several_ ? in_matrix(i, j) : j == 0 ? b.force_by_q : b.force_by_rate;
      outputs[scalars + i * tangent_columns_ + j] = own;
      tangent = tangent || own != nullptr;
    }
  }
  if (tangent)
    run(force_.tangent, batch, outputs.data());
  else if (forces)
    run(force_.values, batch, outputs.data());
  if (!several_ && !reads_.rate && b.force_by_rate != nullptr) std::fill_n(b.force_by_rate, b.count, 0.0);
  if (b.energy != nullptr) run(energy_.values, batch, &b.energy);
  if (b.margin != nullptr) run(margin_.values, batch, &b.margin);

  // Other derivatives, from the matrix and from lists of their own; where both ask, the matrix gets a copy.
  if (b.derivatives == nullptr && b.force_by_parameters == nullptr && b.energy_by_q == nullptr && layout_.states == 0)
    return;
  const auto rest = [&](const Quantity& quantity, std::size_t first_row, std::size_t first, const auto& listed) {
    if (quantity.rows == 0) return;
    run_columns(quantity, batch, first, [&](std::size_t row, std::size_t column) {
      double* const own = listed(row, column);
      return own != nullptr ? own : in_matrix(first_row + row, column);
    });
    for (std::size_t row = 0; row < quantity.rows; ++row)
      for (std::size_t column = first; column < columns; ++column) {
        const double* const own = listed(row, column);
        double* const copy = in_matrix(first_row + row, column);
        if (own != nullptr && copy != nullptr && own != copy) std::copy_n(own, b.count, copy);
      }
  };
  const std::size_t P = layout_.parameters, S = layout_.states;
  const auto from = [](double* const* list, std::size_t index) { return list == nullptr ? nullptr : list[index]; };
  // Whether a column is one of `count` from `first_column` on.
  const auto is_among = [](std::size_t column, std::size_t first_column, std::size_t count) {
    return column - first_column < count;
  };
  rest(force_, layout_.force(), several_ ? tangent_columns_ : 0, [&](std::size_t, std::size_t column) -> double* {
    if (several_) return nullptr;
    if (is_among(column, layout_.parameter(0), P)) return from(b.force_by_parameters, column - layout_.parameter(0));
    if (is_among(column, layout_.state(0), S)) return from(b.force_by_states, column - layout_.state(0));
    return nullptr;
  });
  rest(energy_, layout_.energy(), 0, [&](std::size_t, std::size_t column) -> double* {
    if (several_) return nullptr;
    if (column == layout_.value()) return b.energy_by_q;
    if (is_among(column, layout_.state(0), S)) return from(b.energy_by_states, column - layout_.state(0));
    return nullptr;
  });
  rest(margin_, layout_.margin(), 0, [](std::size_t, std::size_t) -> double* { return nullptr; });
  if (S == 0) return;
  std::array<double*, max_states> rates{};
  for (std::size_t k = 0; k < S; ++k) rates[k] = from(b.state_rates, k);
  if (std::any_of(rates.begin(), rates.end(), [](const double* each) { return each != nullptr; }))
    run(rates_.values, batch, rates.data());
  rest(rates_, layout_.state_row(0), 0, [&](std::size_t row, std::size_t column) -> double* {
    if (column == layout_.value()) return from(b.rates_by_q, row);
    if (column == layout_.rate()) return from(b.rates_by_rate, row);
    if (is_among(column, layout_.parameter(0), P))
      return from(b.rates_by_parameters, row * P + column - layout_.parameter(0));
    if (is_among(column, layout_.state(0), S)) return from(b.rates_by_states, row * S + column - layout_.state(0));
    return nullptr;
  });
}

}  // namespace springnet::formula
