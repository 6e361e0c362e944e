#include "tables/table.hpp"

namespace springnet::tables {

Table elements();

Table elements() {
  return {
      .name = "elements",
      .content = "angles, areas, volumes and the forces of their laws",
      .columns = {{{"element"}, "", "number of the element", Columns::Cell::count},
                  {{"value"}, "", "angle, area or volume: rad, m², m³"},
                  {{"force"},
                   "",
                   "generalised force of its law, positive if it reduces the value: N m, N/m, Pa; the pressure of a "
                   "filling is its negative"},
                  {{"alive"}, "", "1; 0 once it is removed", Columns::Cell::flag}},
      .wanted = [](const Network& network,
                   const OutputOptions& options) { return options.elements && !network.elements().empty(); },
      .leave_out_hint = "leave out {} (output.elements = false, or a list of names of [[element]] for some)",
      .numbers =
          [](const Network& network, const OutputOptions& options) {
            return chosen_or_all(options.element_numbers, network.elements().size());
          },
      .writer = [](const Network& network, const OutputOptions& options) -> RowWriter {
        return [elements = chosen_or_all(options.element_numbers, network.elements().size())](const Record& record,
                                                                                              TableFile& file) {
          for (const ElementIndex element : elements) {
            file.row(record.time());
            file << element << record.element_value(element) << record.simulation().element_force(element)
                 << (record.simulation().element_alive(element) ? 1.0 : 0.0);
          }
        };
      },
  };
}

}  // namespace springnet::tables
