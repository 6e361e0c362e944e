#include "tables/names.hpp"
#include "tables/table.hpp"

namespace springnet::tables {

Table contacts();

Table contacts() {
  return {
      .name = "contacts",
      .content = "forces of bodies on each other",
      .columns = {{{"pair"},
                   "",
                   "nodes of both that touch: `3; 8 9 12` is node 3 and a face, `3 4; 8 9` two edges",
                   Columns::Cell::text},
                  {{"x", "y", "z"}, "m", "where, in the middle of the gap that their thickness fills"},
                  {{"nx", "ny", "nz"}, "", "direction from the second to the first, of length 1"},
                  {{"fx", "fy", "fz"},
                   "N",
                   "force on the first: mean over the last step, in `cvode` at the time; of redundant pairs the "
                   "smallest that do the same"}},
      .wanted = [](const Network& network,
                   const OutputOptions& options) { return options.contacts && !network.contacts().empty(); },
      .leave_out_hint = "leave out {} (output.contacts = false)",
      .writer = [](const Network&, const OutputOptions&) -> RowWriter {
        return [](const Record& record, TableFile& file) {
          for (const BodyTouch& each : record.simulation().body_touches()) {
            file.row(record.time());
            file << pair_of(each.nodes, each.first, each.count) << each.position << each.normal << each.force;
          }
        };
      },
  };
}

}  // namespace springnet::tables
