// The table of a validation, as cells; the first row is the heading.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <springnet/validation.hpp>

namespace springnet {

using TableRow = std::array<std::string, 8>;

[[nodiscard]] std::vector<TableRow> table_rows(const Validation& validation);

// "0.98", or "-" where there is none.
[[nodiscard]] std::string order_text(double order);

}  // namespace springnet
