#include "tables/table.hpp"

namespace springnet::tables {

Table energies();

Table energies() {
  return {
      .name = "energies",
      .content = "energies of the whole, if output.energies = true",
      .columns = {{{"kinetic"}, "J", "kinetic energy of all nodes"},
                  {{"potential"}, "J", "energy stored by springs and elements, and of gravity, 0 at the origin"},
                  {{"dissipation"}, "W", "power that the laws of springs and elements dissipate"},
                  {{"dissipated"}, "J", "what they have dissipated since the start"}},
      .wanted = [](const Network&, const OutputOptions& options) { return options.energies; },
      .leave_out_hint = "leave out {} (output.energies = false)",
      .rows = [](const Network&, const OutputOptions&) { return RowCount{1.0}; },
      .writer = [](const Network&, const OutputOptions&) -> RowWriter {
        return [](const Record& record, TableFile& file) {
          const Simulation& simulation = record.simulation();
          file.row(record.time());
          file << record.kinetic_energy() << record.potential_energy() << simulation.dissipated_power()
               << simulation.dissipated_energy();
        };
      },
  };
}

}  // namespace springnet::tables
