#include <numeric>

#include "tables/names.hpp"
#include "tables/table.hpp"

namespace springnet::tables {

Table surfaces();

Table surfaces() {
  return {
      .name = "surfaces",
      .content = "forces and torques on planes and instruments",
      .columns = {{{"surface"},
                   "",
                   "name of the plane or instrument; its number if it has none: planes first, then instruments",
                   Columns::Cell::text},
                  {{"x", "y", "z"}, "m", "position: a plane's point, a sphere's or box's centre, `from` of a capsule"},
                  {{"fx", "fy", "fz"}, "N", "force of the nodes in contact on it"},
                  {{"tx", "ty", "tz"}, "N m", "torque of that force about this position"},
                  {{"nodes"}, "", "number of nodes in contact with it", Columns::Cell::count},
                  {{"jx", "jy", "jz"}, "N s", "sum of the contact impulses that nodes gave it since the start"}},
      .wanted = [](const Network& network,
                   const OutputOptions& options) { return options.surfaces && surface_count(network) > 0; },
      .leave_out_hint = "leave out {} (output.surfaces = false)",
      .rows =
          [](const Network& network, const OutputOptions&) {
            const std::vector<double> labels = label_lengths(network);
            return RowCount{static_cast<double>(labels.size()), static_cast<double>(network.nodes().size()),
                            std::accumulate(labels.begin(), labels.end(), 0.0)};
          },
      .writer = [](const Network&, const OutputOptions&) -> RowWriter {
        return [](const Record& record, TableFile& file) {
          const Simulation& simulation = record.simulation();
          for (std::size_t k = 0; k < simulation.surface_count(); ++k) {
            const Record::SurfaceLoad& load = record.surface_loads()[k];
            file.row(record.time());
            file << label_of(simulation, k) << simulation.surface_position(k) << load.force
                 << simulation.surface_torque(k) << static_cast<std::uint32_t>(load.nodes)
                 << simulation.surface_impulse(k);
          }
        };
      },
  };
}

}  // namespace springnet::tables
