#include "tables/table.hpp"

namespace springnet::tables {

Table trajectory();

Table trajectory() {
  return {
      .name = "trajectory",
      .content = "positions and velocities of nodes, and forces; see output.quantities",
      .columns = {{{"node"}, "", "number of the node", Columns::Cell::count},
                  {{"x", "y", "z"},
                   "m",
                   "position",
                   Columns::Cell::number,
                   [](const OutputOptions& options) { return options.position; }},
                  {{"vx", "vy", "vz"},
                   "m/s",
                   "velocity",
                   Columns::Cell::number,
                   [](const OutputOptions& options) { return options.velocity; }},
                  {{"fx", "fy", "fz"},
                   "N",
                   "sum of spring forces and loads, without reactions",
                   Columns::Cell::number,
                   [](const OutputOptions& options) { return options.force; }}},
      .wanted = [](const Network&, const OutputOptions& options) { return options.trajectory; },
      .leave_out_hint = "leave out {} (output.trajectory = false)",
      .shrink_hint = "write fewer nodes (output.nodes)",
      .numbers = [](const Network& network,
                    const OutputOptions& options) { return chosen_or_all(options.nodes, network.nodes().size()); },
      .writer = [](const Network& network, const OutputOptions& options) -> RowWriter {
        return [nodes = chosen_or_all(options.nodes, network.nodes().size()), position = options.position,
                velocity = options.velocity, force = options.force](const Record& record, TableFile& file) {
          const Record::Vectors* const quantities[] = {position ? &record.positions() : nullptr,
                                                       velocity ? &record.velocities() : nullptr,
                                                       force ? &record.forces() : nullptr};
          for (const NodeIndex node : nodes) {
            file.row(record.time());
            file << node;
            for (const Record::Vectors* const quantity : quantities)
              if (quantity != nullptr) file << quantity->col(static_cast<Eigen::Index>(node));
          }
        };
      },
  };
}

}  // namespace springnet::tables
