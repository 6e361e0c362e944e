#include "figure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "plot_page.hpp"

namespace springnet::tool {

namespace {

constexpr double page_width = 760.0, panel_height = 230.0, frame_left = 78.0, frame_right = 742.0;
constexpr double title_line = 28.0, note_line = 19.0, heading_space = 30.0, below = 50.0, mark_row = 17.0;
constexpr std::size_t note_letters = 104;  // a line of notes
constexpr double letter = 6.9;             // mean width, of 13 px

// Distinguishable with colour vision deficiencies (Okabe and Ito), and by their dashes without colours.
constexpr std::array<const char*, 6> line_colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#7a5c00", "#444444"};
constexpr std::array<const char*, 6> line_dashes{"", "7 3", "2 3", "9 3 2 3", "12 4", "4 2"};

constexpr const char* figure_style = R"(<style>
text { font: 13px "DejaVu Sans", Verdana, Helvetica, Arial, sans-serif; fill: #1a1a1a; }
.title { font-size: 17px; font-weight: bold; }
.heading { font-weight: bold; }
.halo { stroke: #ffffff; stroke-width: 4px; paint-order: stroke; stroke-linejoin: round; }
.grid { stroke: #dddddd; stroke-width: 1; }
.zero { stroke: #777777; stroke-width: 1; }
.frame { fill: none; stroke: #1a1a1a; stroke-width: 1; }
.shade { fill: #e4e4e4; }
.mark { stroke: #1a1a1a; stroke-width: 1.2; stroke-dasharray: 3 3; }
.curve { fill: none; stroke-width: 2.2; stroke-linejoin: round; }
</style>
)";

std::string escaped(std::string_view text) {
  std::string result;
  for (const char each : text) {
    if (each == '&')
      result += "&amp;";
    else if (each == '<')
      result += "&lt;";
    else if (each == '>')
      result += "&gt;";
    else if (each == '"')
      result += "&quot;";
    else
      result += each;
  }
  return result;
}

// Letters, of UTF-8.
std::size_t length_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; }));
}

double width_of(std::string_view text) {
  constexpr double digit = 8.3;
  const auto digits = std::count_if(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  return letter * static_cast<double>(length_of(text)) + (digit - letter) * static_cast<double>(digits);
}

struct Interval {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] bool empty() const { return !(low <= high); }
};

class Axis {
 public:
  Axis(Interval values, double from, double to, double wanted_ticks)
      : low_(values.low), high_(values.high), from_(from), to_(to) {
    const double raw = (high_ - low_) / wanted_ticks;
    const double power = std::pow(10.0, std::floor(std::log10(raw)));
    step_ = 10.0 * power;
    for (const double factor : {5.0, 2.0, 1.0})
      if (factor * power >= raw * (1.0 - 1e-9)) step_ = factor * power;
  }
  [[nodiscard]] double place(double value) const { return from_ + (value - low_) / (high_ - low_) * (to_ - from_); }
  [[nodiscard]] std::vector<double> ticks() const {
    std::vector<double> result;
    for (double k = std::ceil(low_ / step_ - 1e-9); k * step_ <= high_ + 1e-9 * step_; k += 1.0)
      result.push_back(k * step_ + 0.0);  // + 0.0: no "-0"
    return result;
  }
  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }

 private:
  double low_, high_, from_, to_, step_;
};

bool is_point(const FigureCurve& curve, std::size_t k) {
  return std::isfinite(curve.x[k]) && std::isfinite(curve.y[k]);
}

// Of y, without what exceeds nine tenths of all values by far; `is_cut`: there is such.
Interval drawn_values(const FigurePanel& panel, bool& is_cut) {
  constexpr double by_far = 12.0, drawn = 4.0;
  std::vector<double> sizes;
  Interval all;
  for (const FigureCurve& curve : panel.curves) {
    for (std::size_t k = 0; k < curve.x.size(); ++k) {
      if (!is_point(curve, k)) continue;
      all.include(curve.y[k]);
      sizes.push_back(std::abs(curve.y[k]));
    }
  }
  is_cut = false;
  if (sizes.empty()) return all;
  const auto ninth = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 9 / 10);
  std::nth_element(sizes.begin(), ninth, sizes.end());
  const double usual = *ninth, largest = std::max(std::abs(all.low), std::abs(all.high));
  if (usual > 0.0 && largest > by_far * usual) {
    is_cut = true;
    all.low = std::max(all.low, -drawn * usual);
    all.high = std::min(all.high, drawn * usual);
  }
  all.include(0.0);
  if (!(all.high > all.low)) all = {-1.0, 1.0};
  const double margin = 0.06 * (all.high - all.low);
  if (all.low < 0.0) all.low -= margin;
  if (all.high > 0.0) all.high += margin;
  return all;
}

Interval places_of(const FigurePanel& panel) {
  Interval all;
  for (const FigureCurve& curve : panel.curves)
    for (const double x : curve.x)
      if (std::isfinite(x)) all.include(x);
  if (all.empty()) all = {0.0, 1.0};
  if (!(all.high > all.low)) all = {all.low - 0.5, all.high + 0.5};
  return all;
}

std::string number_text(double number) {
  const std::string digits = fmt::format("{:g}", std::abs(number));
  return number < 0.0 ? "\u2212" + digits : digits;
}

// Of curve k. A path has a dashed course and a solid one.
const char* dashes_of(const FigurePanel& panel, std::size_t k) {
  if (panel.curves[k].dashed) return line_dashes[1];
  return panel.is_path ? line_dashes[0] : line_dashes[k % line_dashes.size()];
}

std::string line(const char* kind, double x1, double y1, double x2, double y2) {
  return fmt::format("<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>", kind, x1, y1, x2,
                     y2);
}
std::string words(const char* kind, double x, double y, const char* anchor, std::string_view text) {
  return fmt::format("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", kind, x, y, anchor,
                     escaped(text));
}

std::string axes(const FigurePanel& panel, const Axis& x, const Axis& y, double top, double bottom) {
  std::string svg;
  for (const double tick : x.ticks()) {
    svg += line("grid", x.place(tick), top, x.place(tick), bottom);
    svg += words("tick", x.place(tick), bottom + 18.0, "middle", number_text(tick));
  }
  for (const double tick : y.ticks()) {
    svg += line(tick == 0.0 ? "zero" : "grid", frame_left, y.place(tick), frame_right, y.place(tick));
    svg += words("tick", frame_left - 8.0, y.place(tick) + 4.5, "end", number_text(tick));
  }
  return svg + words("label", (frame_left + frame_right) / 2.0, bottom + 38.0, "middle", panel.x_label);
}

// Lines and their words, each in a row of its own so that they never overlap.
std::string words_of_marks(const FigurePanel& panel, const Axis& x, double top, double bottom) {
  std::string svg;
  double at = top + mark_row;
  for (const FigureMark& mark : panel.marks) {
    const double from = std::clamp(x.place(mark.from), frame_left, frame_right);
    const double to = std::clamp(x.place(mark.to), frame_left, frame_right);
    if (mark.from == mark.to) svg += line("mark", from, top, from, bottom);
    const double half = width_of(mark.text) / 2.0;
    double middle = mark.from == mark.to ? from + half + 6.0 : (from + to) / 2.0;
    if (mark.from == mark.to && middle + half > frame_right - 4.0) middle = from - half - 6.0;
    middle = std::clamp(middle, frame_left + half + 4.0, frame_right - half - 4.0);
    svg += words("halo", middle, at, "middle", mark.text);
    at += mark_row;
  }
  return svg;
}

// The pen is up over what is not finite and over poles, where a curve leaves on one side and comes back on the other.
std::string path_of(const FigureCurve& curve, const Axis& x, const Axis& y) {
  std::string path;
  bool down = false;
  double before = 0.0;
  const double slack = y.high() - y.low();
  for (std::size_t k = 0; k < curve.x.size(); ++k) {
    if (!is_point(curve, k)) {
      down = false;
      continue;
    }
    const double value = std::clamp(curve.y[k], y.low() - slack, y.high() + slack);
    const bool jumps = (before > y.high() && value < y.low()) || (before < y.low() && value > y.high());
    path += fmt::format("{}{:.2f} {:.2f}", down && !jumps ? "L" : "M", x.place(curve.x[k]), y.place(value));
    down = true;
    before = value;
  }
  return path;
}

std::string legend(const FigurePanel& panel, double baseline) {
  std::string svg;
  double end = frame_right;
  for (std::size_t k = panel.curves.size(); k-- > 0;) {
    const FigureCurve& curve = panel.curves[k];
    if (curve.label.empty()) continue;
    const std::size_t colour = k % line_colours.size();
    svg += words("legend", end, baseline, "end", curve.label);
    const double key = end - width_of(curve.label) - 8.0;
    svg += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{}\" x2=\"{:.1f}\" y2=\"{}\" stroke=\"{}\" stroke-width=\"2.2\" "
        "stroke-dasharray=\"{}\"/>",
        key - 30.0, baseline - 4.5, key, baseline - 4.5, line_colours[colour], dashes_of(panel, k));
    end = key - 46.0;
  }
  return svg;
}

// A picture as it grows downwards.
struct Drawing {
  std::string svg;
  double y = 8.0;
  std::size_t panels = 0;
  nlohmann::json data = nlohmann::json::array();  // of panels, for the page's script
};

void draw(const FigurePanel& panel, Drawing& to) {
  bool is_cut = false;
  Interval values = drawn_values(panel, is_cut);
  to.y += heading_space;
  to.svg += words("heading", frame_left, to.y - 9.0, "start", panel.y_label);
  if (values.empty()) {
    to.svg += words("label", frame_left, to.y + mark_row, "start", "no finite value here");
    to.y += 2.0 * mark_row;
    return;
  }
  const double top = to.y, bottom = top + panel_height;
  const Axis x(places_of(panel), frame_left, frame_right, 11.0);
  FigurePanel shown = panel;
  if (is_cut) shown.marks.push_back({x.low(), x.high(), "cut off: larger values are not drawn"});
  // Words stand above the curves.
  const double words_height = std::min(mark_row * static_cast<double>(shown.marks.size()), panel_height / 2.0);
  values.high += (values.high - values.low) * words_height / (panel_height - words_height);
  const Axis y(values, bottom, top, 7.0);
  to.svg += fmt::format("<g class=\"panel\" data-panel=\"{}\">\n", to.panels);
  to.svg +=
      fmt::format("<clipPath id=\"frame{0}\"><rect x=\"{1}\" y=\"{2:.1f}\" width=\"{3}\" height=\"{4}\"/></clipPath>",
                  to.panels, frame_left, top, frame_right - frame_left, panel_height);
  for (const FigureMark& mark : panel.marks) {
    if (mark.from == mark.to) continue;
    const double from = std::clamp(x.place(mark.from), frame_left, frame_right);
    const double end = std::clamp(x.place(mark.to), frame_left, frame_right);
    to.svg += fmt::format("<rect class=\"shade\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{}\"/>", from, top,
                          end - from, panel_height);
  }
  to.svg += axes(panel, x, y, top, bottom);
  for (std::size_t k = 0; k < panel.curves.size(); ++k) {
    const std::size_t colour = k % line_colours.size();
    to.svg += fmt::format(
        "<path class=\"curve\" clip-path=\"url(#frame{})\" stroke=\"{}\" stroke-dasharray=\"{}\" d=\"{}\"/>\n",
        to.panels, line_colours[colour], dashes_of(panel, k), path_of(panel.curves[k], x, y));
  }
  to.svg += fmt::format("<rect class=\"frame\" x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\"/>", frame_left, top,
                        frame_right - frame_left, panel_height);
  to.svg += words_of_marks(shown, x, top, bottom) + legend(panel, top - 9.0) + "</g>\n";
  nlohmann::json curves = nlohmann::json::array();
  for (const FigureCurve& curve : panel.curves)
    curves.push_back({{"label", curve.label}, {"x", curve.x}, {"y", curve.y}});
  to.data.push_back({{"frame", {frame_left, top, frame_right, bottom}},
                     {"x", {x.low(), x.high()}},
                     {"y", {y.low(), y.high()}},
                     {"x_label", panel.x_label},
                     {"y_label", panel.y_label},
                     {"is_path", panel.is_path},
                     {"curves", curves}});
  ++to.panels;
  to.y = bottom + below;
}

// Breaks between words.
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::string_view rest = text;
  while (length_of(rest) > note_letters) {
    std::size_t end = rest.rfind(' ', note_letters);
    if (end == std::string_view::npos || end == 0) break;
    lines.emplace_back(rest.substr(0, end));
    rest.remove_prefix(end + 1);
  }
  lines.emplace_back(rest);
  return lines;
}

Drawing draw(const std::vector<Figure>& figures) {
  Drawing drawing;
  for (const Figure& figure : figures) {
    drawing.y += title_line;
    drawing.svg += words("title", 16.0, drawing.y - 6.0, "start", figure.title);
    for (const std::string& note : figure.notes) {
      for (const std::string& each : lines_of(note)) {
        drawing.y += note_line;
        drawing.svg += words("note", 16.0, drawing.y - 5.0, "start", each);
      }
    }
    for (const FigurePanel& panel : figure.panels) draw(panel, drawing);
    drawing.y += 14.0;
  }
  drawing.svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1:.0f}\" width=\"{0}\" height=\"{1:.0f}\">\n{2}"
      "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{3}</svg>\n",
      page_width, drawing.y, figure_style, drawing.svg);
  return drawing;
}

}  // namespace

std::string svg_of(const std::vector<Figure>& figures) { return draw(figures).svg; }

std::string page_of(const std::string& title, const std::vector<Figure>& figures) {
  const Drawing drawing = draw(figures);
  // JSON in a script element must not end it.
  std::string data = drawing.data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = data.find('<'); at != std::string::npos; at = data.find('<', at))
    data.replace(at, 1, "\\u003c");
  return fmt::format(plot_page, escaped(title), drawing.svg, data);
}

}  // namespace springnet::tool
