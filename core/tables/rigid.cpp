#include "tables/table.hpp"

namespace springnet::tables {

Table rigid();

Table rigid() {
  return {
      .name = "rigid",
      .content = "tensions of rigid connections",
      .columns = {{{"rigid"}, "", "number of the connection", Columns::Cell::count},
                  {{"force"}, "N", "tension, positive if it pulls the ends together"}},
      .wanted = [](const Network& network,
                   const OutputOptions& options) { return options.rigid && !network.rigids().empty(); },
      .leave_out_hint = "leave out {} (output.rigid = false)",
      .rows =
          [](const Network& network, const OutputOptions&) {
            const auto count = static_cast<double>(network.rigids().size());
            return RowCount{count, count};
          },
      .writer = [](const Network& network, const OutputOptions&) -> RowWriter {
        return [count = static_cast<RigidIndex>(network.rigids().size())](const Record& record, TableFile& file) {
          for (RigidIndex rigid = 0; rigid < count; ++rigid) {
            file.row(record.time());
            file << rigid << record.simulation().rigid_force(rigid);
          }
        };
      },
  };
}

}  // namespace springnet::tables
