#include <algorithm>
#include <limits>

#include "tables/table.hpp"

namespace springnet::tables {

Table states();

namespace {

constexpr std::string_view function_name(bool of_viscosity) { return of_viscosity ? "viscosity" : "spring"; }

// Rows of a spring or element of each material, and characters of text in them.
std::vector<RowCount> rows_of_materials(const Network& network, const OutputOptions& options, std::string_view kind) {
  std::vector<RowCount> rows;
  for (const Material& material : network.materials()) {
    RowCount count;
    for (const LawStates& law : options.law_states) {
      const bool viscosity = law.kind == ComponentKind::viscosity_function;
      const std::optional<LawUse>& use = viscosity ? material.viscosity : material.spring;
      if (!use || use->id != law.law) continue;
      for (const InternalState& state : law.states) {
        count.rows += 1.0;
        count.text += static_cast<double>(kind.size() + function_name(viscosity).size() + state.name.size());
      }
    }
    rows.push_back(count);
  }
  return rows;
}

RowCount count_state_rows(const Network& network, const OutputOptions& options) {
  RowCount sum{0.0, static_cast<double>(std::max(network.springs().size(), network.elements().size()))};
  if (options.law_states.empty()) sum.rows = std::numeric_limits<double>::quiet_NaN();
  const auto add = [&](const auto& all, const std::vector<std::uint32_t>& numbers, std::string_view kind) {
    const std::vector<RowCount> rows = rows_of_materials(network, options, kind);
    for (const std::uint32_t k : numbers) {
      sum.rows += rows[all[k].material].rows;
      sum.text += rows[all[k].material].text;
    }
  };
  add(network.springs(), chosen_or_all(options.springs, network.springs().size()), "spring");
  if (options.elements)
    add(network.elements(), chosen_or_all(options.element_numbers, network.elements().size()), "element");
  return sum;
}

// Springs and elements whose laws have states, by their numbers; found at the first record.
class StateRows {
 public:
  StateRows(const Network& network, const OutputOptions& options)
      : springs_(chosen_or_all(options.springs, network.springs().size())) {
    if (options.elements) elements_ = chosen_or_all(options.element_numbers, network.elements().size());
  }

  void operator()(const Record& record, TableFile& file) {
    const Simulation& simulation = record.simulation();
    if (!found_) {
      std::erase_if(springs_, [&](SpringIndex k) { return simulation.internal_states(k).empty(); });
      std::erase_if(elements_, [&](ElementIndex k) { return simulation.element_internal_states(k).empty(); });
      found_ = true;
    }
    for (const SpringIndex k : springs_)
      write(record, file, "spring", k, simulation.internal_state_names(k), simulation.internal_states(k));
    for (const ElementIndex k : elements_)
      write(record, file, "element", k, simulation.element_internal_state_names(k),
            simulation.element_internal_states(k));
  }

 private:
  static void write(const Record& record, TableFile& file, std::string_view kind, std::uint32_t number,
                    const std::vector<InternalState>& names, const std::vector<double>& values) {
    for (std::size_t j = 0; j < values.size(); ++j) {
      file.row(record.time());
      file << kind << number << function_name(names[j].of_viscosity) << std::string_view(names[j].name) << values[j];
    }
  }

  std::vector<SpringIndex> springs_;
  std::vector<ElementIndex> elements_;
  bool found_ = false;
};

}  // namespace

Table states() {
  return {
      .name = "states",
      .content = "internal states of laws, if output.states = true",
      .columns = {{{"element"}, "", "what has it: `spring`, `element`", Columns::Cell::text},
                  {{"index"}, "", "its number", Columns::Cell::count},
                  {{"function"},
                   "",
                   "whose state it is: that of the `spring` function or of the `viscosity` function",
                   Columns::Cell::text},
                  {{"state"}, "", "name of the state, as the law declares it", Columns::Cell::text},
                  {{"value"}, "", "in its unit; of a removed spring or element, as it was last"}},
      .wanted = [](const Network&, const OutputOptions& options) { return options.states; },
      .leave_out_hint = "leave out {} (output.states = false, or output.springs for some)",
      .rows = count_state_rows,
      .writer = [](const Network& network, const OutputOptions& options) -> RowWriter {
        return StateRows(network, options);
      },
  };
}

}  // namespace springnet::tables
