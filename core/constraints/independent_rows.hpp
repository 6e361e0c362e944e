// Rows of pairs without those that others imply, as of faces on faces: what they allow is the same, and systems with
// fewer rows take less time.
#pragma once

#include <vector>

#include "layers/linear/constraint_row.hpp"

namespace springnet {

// In the order that they had. mobility: [node] 1/kg. A row counts as implied if what it has beside all sums of the
// others is less than 1e-4 of it. Rows that are connected with more than two thousand others all stay.
[[nodiscard]] std::vector<ConstraintRow> independent_rows(std::vector<ConstraintRow> rows,
                                                          const std::vector<double>& mobility);

}  // namespace springnet
