// Figures of curves as SVG text, one panel below the other, for paper and screens.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace springnet::tool {

struct FigureCurve {
  std::string label;  // plain text; empty: not in the legend
  std::vector<double> x, y;
  bool dashed = false;
};
// A vertical line, or a shaded interval, with a few words.
struct FigureMark {
  double from, to;  // equal: a line
  std::string text;
};
struct FigurePanel {
  std::string x_label, y_label;  // with units: "length, m"
  std::vector<FigureCurve> curves;
  std::vector<FigureMark> marks;
  bool is_path = false;  // x goes to and fro
};
struct Figure {
  std::string title;
  std::vector<std::string> notes;  // below the title
  std::vector<FigurePanel> panels;
};

// One <svg> for all figures. Points that are not finite interrupt their curve. A panel whose largest values exceed the
// others by far, as near a pole, is cut off and says so.
[[nodiscard]] std::string svg_of(const std::vector<Figure>& figures);
// A page with the same pictures that shows the values at the pointer. It loads nothing.
[[nodiscard]] std::string page_of(const std::string& title, const std::vector<Figure>& figures);

}  // namespace springnet::tool
