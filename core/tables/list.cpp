#include "tables/table.hpp"

namespace springnet::tables {

// Each in the file of its name.
Table events(), trajectory(), reactions(), surfaces(), contacts(), rigid(), springs(), elements(), states(), energies();

const std::vector<Table>& all() {
  static const std::vector<Table> tables{events(), trajectory(), reactions(), surfaces(), contacts(),
                                         rigid(),  springs(),    elements(),  states(),   energies()};
  return tables;
}

}  // namespace springnet::tables
