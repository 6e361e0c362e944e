// Figures of curves as SVG text, one panel below the other, for paper, screens and pages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace springnet::figure {

struct FigureCurve {
  std::string label;  // plain text; empty: not in the legend
  std::vector<double> x, y;
  bool dashed = false;
  bool markers = false;
  bool has_line = true;              // false: markers alone
  std::vector<double> from{}, to{};  // ends of a vertical bar at each point; none: no bars
};
// A vertical line, or a shaded interval, with a few words or none. Not on logarithmic axes.
struct FigureMark {
  double from, to;  // equal: a line
  std::string text;
};
struct FigurePanel {
  std::string x_label, y_label;  // with units: "length, m"
  std::vector<FigureCurve> curves;
  std::vector<FigureMark> marks;
  bool is_path = false;          // x goes to and fro
  bool has_plain_lines = false;  // solid, unless a curve is dashed; else dashes, too, tell curves apart. So do paths
  bool x_logarithmic = false, y_logarithmic = false;
  double height = 230.0;
};
struct Figure {
  std::string title;               // may be empty
  std::vector<std::string> notes;  // below the title
  std::vector<FigurePanel> panels;
};

// Where a panel is in the picture, and what it shows there.
struct PlacedPanel {
  const FigurePanel* panel;
  double left, top, right, bottom;
  double x_low, x_high, y_low, y_high;
};
struct Drawing {
  std::string svg;
  std::vector<PlacedPanel> panels;  // those with a frame
};

struct Look {
  bool is_embedded = false;   // in a page, which has the styles of its classes (`embedded_style`) and other pictures
  std::string ids = "frame";  // begin of the ids in the <svg>: one for each picture of a page
};
// Styles of a page with embedded pictures, in its colours --ink, --faint and --soft.
extern const char* const embedded_style;

// One <svg> for all figures. Points that are not finite, or not above 0 on a logarithmic axis, interrupt their curve. A
// panel whose largest values exceed the others by far, as near a pole, is cut off and says so. Of long curves the
// largest value of each of some hundred intervals is drawn, unless the panel is a path.
[[nodiscard]] Drawing draw(const std::vector<Figure>& figures, const Look& look = {});

}  // namespace springnet::figure
