// A law as a figure: force, stiffness and energy over what it reads, force over the rate, a loop of its memory.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "figure/figure.hpp"
#include "law_caller.hpp"

namespace springnet::tool {

using figure::Figure, figure::FigureCurve, figure::FigureMark, figure::FigurePanel;

struct LawFigureOptions {
  std::optional<std::pair<double, double>> range;  // as stretches; of speeds m/s, of bent angles rad
  double reference = 1.0;                          // m, rad, m^2, m^3
  double period = 1.0;                             // s, of the cycle of a law with internal states
};

// title: of the figure. setting: without references, which follow from the options. Throws Error(input) for a range or
// a table that cannot be.
[[nodiscard]] Figure figure_of(const std::string& title, std::vector<std::string> notes, LawSetting setting,
                               const LawFigureOptions& options);

}  // namespace springnet::tool
