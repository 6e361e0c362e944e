#include "tables/table.hpp"

namespace springnet::tables {

// Each in the file of its name.
Table events(), trajectory(), reactions(), surfaces(), rigid(), springs(), elements();

const std::vector<Table>& all() {
  static const std::vector<Table> tables{events(), trajectory(), reactions(), surfaces(),
                                         rigid(),  springs(),    elements()};
  return tables;
}

}  // namespace springnet::tables
