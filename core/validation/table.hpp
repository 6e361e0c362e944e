// The table of a validation as cells; the first row is the header.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <springnet/validation.hpp>

namespace springnet {

using TableRow = std::array<std::string, 9>;

[[nodiscard]] std::vector<TableRow> table_rows(const Validation& validation);

// What theta = 0.5 does for the scene's own run, as a sentence; empty if it is not better.
[[nodiscard]] std::string second_order_advice(const Validation& validation);

// "0.98", or "-" if there is none.
[[nodiscard]] std::string order_text(double order);

}  // namespace springnet
