// Line plots as SVG text.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springnet {

struct PlotSeries {
  std::string label;  // plain text; empty: not in the legend
  std::vector<double> x, y;
  bool markers = false;
  bool dashed = false;
};

struct PlotAxis {
  std::string label;  // plain text
  bool logarithmic = false;
};

struct Plot {
  PlotAxis x, y;
  std::vector<PlotSeries> series;
};

// An <svg> element. Points that are not finite, or not above 0 on a logarithmic axis, interrupt their line. Long series
// are thinned to the maximum of each of some hundred intervals. A plot without any point says so.
[[nodiscard]] std::string to_svg(const Plot& plot);

// Text with the special characters of HTML escaped.
[[nodiscard]] std::string escape_html(std::string_view text);

}  // namespace springnet
