// Numbers as people compare them: one unit for all lengths of a table, shares in per cent.
#pragma once

#include <string>

#include <springnet/validation.hpp>

namespace springnet {

struct LengthUnit {
  const char* name;
  double metres;
};

// m, mm, µm or nm: that in which `length` (m) has one to three digits before the point, as far as there is one. m for 0
// and what is not finite.
[[nodiscard]] LengthUnit unit_for(double length) noexcept;
// For the errors of all runs: by that of the scene's own run, or, where it failed, by the greatest of the others.
[[nodiscard]] LengthUnit unit_of_errors(const Validation& validation) noexcept;

// Three digits, "-" for what is not finite: "12.8" in the unit; "12.8 mm" in its own.
[[nodiscard]] std::string length_in(const LengthUnit& unit, double length);
[[nodiscard]] std::string length_text(double length);
// "4.27 %", or "-" where nothing moves.
[[nodiscard]] std::string share_text(double share);

}  // namespace springnet
