// Numbers for readers: one unit for all lengths of a table, fractions in per cent.
#pragma once

#include <string>

#include <springnet/validation.hpp>

namespace springnet {

struct LengthUnit {
  const char* name;
  double metres;
};

// m, mm, µm or nm: the one in which `length` (m) has one to three digits before the point, if possible. m for 0 and for
// numbers that are not finite.
[[nodiscard]] LengthUnit unit_for(double length) noexcept;
// For the errors of all runs: chosen by that of the scene's own run or, if it failed, by the largest of the others.
[[nodiscard]] LengthUnit unit_of_errors(const Validation& validation) noexcept;

// Three digits, "-" if not finite: "12.8" in the given unit, "12.8 mm" in its own.
[[nodiscard]] std::string length_in(const LengthUnit& unit, double length);
[[nodiscard]] std::string length_text(double length);
// "4.27 %", or "-" if nothing moves.
[[nodiscard]] std::string share_text(double share);

}  // namespace springnet
