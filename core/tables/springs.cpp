#include "tables/table.hpp"

namespace springnet::tables {

Table springs();

Table springs() {
  return {
      .name = "springs",
      .content = "lengths, tensions and energies of the springs of output.springs",
      .columns =
          {{{"spring"}, "", "number of the spring", Columns::Cell::count},
           {{"length"}, "m", "distance between its ends"},
           {{"tension"},
            "N",
            "tension with its viscous part, positive if it pulls the ends together; 0 once the spring is removed"},
           {{"energy"}, "J", "stored energy, `nan` if the law has none; 0 once the spring is removed"},
           {{"alive"}, "", "1; 0 once it is removed", Columns::Cell::flag}},
      .wanted = [](const Network&, const OutputOptions& options) { return !options.springs.empty(); },
      .leave_out_hint = "write fewer springs to {} (output.springs)",
      .numbers = [](const Network&, const OutputOptions& options) { return options.springs; },
      .writer = [](const Network&, const OutputOptions& options) -> RowWriter {
        return [springs = options.springs](const Record& record, TableFile& file) {
          for (const SpringIndex spring : springs) {
            file.row(record.time());
            file << spring << record.lengths()[spring] << record.tensions()[spring] << record.energies()[spring]
                 << (record.simulation().alive(spring) ? 1.0 : 0.0);
          }
        };
      },
  };
}

}  // namespace springnet::tables
