// Parameters and tables that laws are checked with, and words of their reports.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include <springnet/formula.hpp>

#include "check/law_checks.hpp"

namespace springnet::check {
namespace {

// Tables that most laws accept: points that increase from `first`, and values that increase with them.
TableValues guessed_tables(const springnet_law& law, double first) {
  TableValues tables;
  for (std::uint32_t t = 0; t < law.table_count; ++t) {
    const springnet_table& table = *law.tables[t];
    const std::size_t length = std::max<std::size_t>({table.least, law.tables[table.as_long_as]->least, 7});
    std::vector<double>& values = tables[table.name];
    const double low = std::max(table.smallest, -1e300), high = std::min(table.largest, 1e300);
    for (std::size_t k = 0; k < length; ++k) {
      const double x = first + 1.5 * static_cast<double>(k) / static_cast<double>(length - 1);
      const double value = (table.flags & SPRINGNET_INCREASING) != 0 ? x : x + 0.3 * x * x * x;
      values.push_back(std::clamp(value, low, high));
    }
  }
  return tables;
}

std::vector<std::vector<double>> in_order(const Component& component, const TableValues& tables) {
  std::vector<std::vector<double>> result;
  for (const auto& values : complete_tables(*component.description, tables, "the check"))
    result.emplace_back(values.begin(), values.end());
  return result;
}

}  // namespace

ReadyLaw::ReadyLaw(const LawSubject& subject)
    : parameters_(subject.scene != nullptr ? subject.scene->parameters.front()
                                           : typical_parameters(*subject.component->description)) {
  const Component& component = *subject.component;
  const springnet_law& law = component.law();
  const bool has_tables = law.table_count > 0;
  if (subject.scene != nullptr) {
    if (!subject.scene->elements.empty())
      parameters_ = subject.scene->parameters[subject.scene->elements.front().parameters];
    tables_ = subject.scene->use.tables;
    prepared_ = std::make_unique<PreparedTable>(component, in_order(component, tables_), parameters_);
  } else if (has_tables) {
    std::string refused;
    for (const double first : {-0.5, 0.0, 0.5}) {
      tables_ = guessed_tables(law, first);
      try {
        prepared_ = std::make_unique<PreparedTable>(component, in_order(component, tables_), parameters_);
        break;
      } catch (const std::exception& error) {
        refused = error.what();
      }
    }
    if (prepared_ == nullptr)
      throw std::runtime_error(fmt::format(
          "it refuses all tables that the check tries ({}): check a scene that uses it with tables of its own",
          refused));
  }
  call_ = std::make_unique<LawCall>(component, prepared_ == nullptr ? nullptr : prepared_->get());
  points_ = std::make_unique<Points>(*call_, parameters_, subject.scene, has_tables, subject.seed);
}

bool is_formula(const Component& component) { return formula_of(component) != nullptr; }

std::string declaring(const Component& component, const char* constant, const char* word) {
  if (is_formula(component)) return fmt::format("write declares = [\"{}\"]", word);
  return fmt::format("declare {}", constant);
}

std::string place(const LawCall& call, const Point& point) {
  const sdk::JacobianLayout& l = call.layout();
  std::string text;
  const auto add = [&](const char* what, std::size_t first, std::size_t count) {
    if (count == 0) return;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", what);
    for (std::size_t i = 0; i < count; ++i) text += fmt::format("{}{:.6g}", i == 0 ? " " : "; ", point[first + i]);
  };
  add("at q", l.value(), l.invariants);
  if (call.reads_rate()) add("rate", l.rate(), l.invariants);
  add("reference", l.reference(), l.invariants);
  add("parameters", l.parameter(0), l.parameters);
  add("states", l.state(0), l.states);
  add("inputs", l.input(0), l.inputs);
  return text;
}

}  // namespace springnet::check
