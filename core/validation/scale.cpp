#include "validation/scale.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace springnet {

LengthUnit unit_for(double length) noexcept {
  constexpr LengthUnit units[] = {{"m", 1.0}, {"mm", 1e-3}, {"µm", 1e-6}, {"nm", 1e-9}};
  if (!std::isfinite(length) || length == 0.0) return units[0];
  // 0.9996 mm is 1 mm to three digits.
  const auto fits = [&](const LengthUnit& unit) { return std::abs(length) >= 0.9995 * unit.metres; };
  const auto found = std::find_if(std::begin(units), std::end(units), fits);
  return found == std::end(units) ? units[3] : *found;
}

LengthUnit unit_of_errors(const Validation& validation) noexcept {
  const ValidationRun& own = validation.run_of_scene();
  if (own.finished()) return unit_for(own.error.max);
  double greatest = 0.0;
  for (const ValidationRun& run : validation.runs) {
    if (run.finished() && std::isfinite(run.error.max)) greatest = std::max(greatest, run.error.max);
  }
  return unit_for(greatest);
}

std::string length_in(const LengthUnit& unit, double length) {
  return std::isfinite(length) ? fmt::format("{:.3g}", length / unit.metres) : "-";
}

std::string length_text(double length) {
  const LengthUnit unit = unit_for(length);
  const std::string number = length_in(unit, length);
  return number == "-" ? number : fmt::format("{} {}", number, unit.name);
}

std::string share_text(double share) {
  if (!std::isfinite(share)) return "-";
  return share >= 10.0 ? fmt::format("{:.0f} %", 100.0 * share) : fmt::format("{:.3g} %", 100.0 * share);
}

}  // namespace springnet
