#include "figure/figure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "figure/axis.hpp"
#include "text/markup.hpp"

namespace springnet::figure {

namespace {

constexpr double page_width = 760.0, frame_left = 78.0, frame_right = 742.0;
constexpr double title_line = 28.0, note_line = 19.0, heading_space = 30.0, below = 50.0, mark_row = 17.0;
constexpr std::size_t note_letters = 104;  // a line of notes
constexpr double letter = 6.9;             // mean width, of 13 px

// Distinguishable with colour vision deficiencies (after Okabe and Ito), on white and on black, and by their dashes
// without colours.
constexpr std::array<const char*, 7> line_colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                  "#b58900", "#56b4e9", "#7a7a7a"};
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

bool is_point(const FigurePanel& panel, const FigureCurve& curve, std::size_t k) {
  return std::isfinite(curve.x[k]) && std::isfinite(curve.y[k]) && (!panel.x_logarithmic || curve.x[k] > 0.0) &&
         (!panel.y_logarithmic || curve.y[k] > 0.0);
}

bool has_bar(const FigureCurve& curve, std::size_t k) {
  return k < curve.from.size() && std::isfinite(curve.from[k]) && std::isfinite(curve.to[k]);
}

// Of y, without what exceeds nine tenths of all values by far; `is_cut`: there is such.
Interval drawn_values(const FigurePanel& panel, bool& is_cut) {
  constexpr double by_far = 12.0, drawn = 4.0;
  std::vector<double> sizes;
  Interval all;
  for (const FigureCurve& curve : panel.curves) {
    for (std::size_t k = 0; k < curve.x.size(); ++k) {
      if (!is_point(panel, curve, k)) continue;
      all.include(curve.y[k]);
      sizes.push_back(std::abs(curve.y[k]));
      if (!has_bar(curve, k)) continue;
      for (const double end : {curve.from[k], curve.to[k]}) {
        all.include(end);
        sizes.push_back(std::abs(end));
      }
    }
  }
  is_cut = false;
  if (sizes.empty() || panel.y_logarithmic) return all;
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
    for (const double x : curve.x)  // also where nothing is drawn
      if (std::isfinite(x) && (!panel.x_logarithmic || x > 0.0)) all.include(x);
  if (panel.x_logarithmic) return all;
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
  return panel.is_path || panel.has_plain_lines ? line_dashes[0] : line_dashes[k % line_dashes.size()];
}

std::string line(const char* kind, double x1, double y1, double x2, double y2) {
  return fmt::format("<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>", kind, x1, y1, x2,
                     y2);
}
std::string words(const char* kind, double x, double y, const char* anchor, std::string_view text) {
  return fmt::format("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", kind, x, y, anchor,
                     escape_html(text));
}

std::string axes(const FigurePanel& panel, const Axis& x, const Axis& y, double top, double bottom) {
  std::string svg;
  for (const auto& [value, is_labelled] : x.ticks()) {
    svg += line("grid", x.place(value), top, x.place(value), bottom);
    if (is_labelled) svg += words("tick", x.place(value), bottom + 18.0, "middle", number_text(value));
  }
  for (const auto& [value, is_labelled] : y.ticks()) {
    svg += line(value == 0.0 ? "zero" : "grid", frame_left, y.place(value), frame_right, y.place(value));
    if (is_labelled) svg += words("tick", frame_left - 8.0, y.place(value) + 4.5, "end", number_text(value));
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
    if (mark.text.empty()) continue;
    const double half = width_of(mark.text) / 2.0;
    double middle = mark.from == mark.to ? from + half + 6.0 : (from + to) / 2.0;
    if (mark.from == mark.to && middle + half > frame_right - 4.0) middle = from - half - 6.0;
    middle = std::clamp(middle, frame_left + half + 4.0, frame_right - half - 4.0);
    svg += words("halo", middle, at, "middle", mark.text);
    at += mark_row;
  }
  return svg;
}

// The largest value of each of `buckets` groups of neighbours, because peaks matter.
FigureCurve thinned(const FigurePanel& panel, const FigureCurve& curve) {
  constexpr std::size_t buckets = 400;
  if (panel.is_path || !curve.has_line || curve.x.size() <= 2 * buckets) return curve;
  FigureCurve result{curve.label, {}, {}, curve.dashed, curve.markers, true, {}, {}};
  const std::size_t count = curve.x.size();
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    const std::size_t first = bucket * count / buckets, end = (bucket + 1) * count / buckets;
    std::size_t best = first;
    for (std::size_t k = first; k < end; ++k)
      if (curve.y[k] > curve.y[best]) best = k;
    result.x.push_back(curve.x[best]);
    result.y.push_back(curve.y[best]);
  }
  return result;
}

// The pen is up over what is no point and over poles, where a curve leaves on one side and comes back on the other.
std::string path_of(const FigurePanel& panel, const FigureCurve& curve, const Axis& x, const Axis& y) {
  std::string path;
  bool down = false;
  double before = 0.0;
  const double slack = y.high() - y.low();
  for (std::size_t k = 0; k < curve.x.size(); ++k) {
    if (!is_point(panel, curve, k)) {
      down = false;
      continue;
    }
    const double value = panel.y_logarithmic ? curve.y[k] : std::clamp(curve.y[k], y.low() - slack, y.high() + slack);
    const bool jumps = (before > y.high() && value < y.low()) || (before < y.low() && value > y.high());
    path += fmt::format("{}{:.2f} {:.2f}", down && !jumps ? "L" : "M", x.place(curve.x[k]), y.place(value));
    down = true;
    before = value;
  }
  return path;
}

// Of points alone, of many smaller ones; a dashed curve has rings.
std::string marker(const FigureCurve& curve, double x, double y, const char* colour) {
  constexpr std::size_t many = 100;
  const double radius = curve.has_line || curve.x.size() <= many ? 4.0 : 2.5;
  if (curve.dashed && !curve.has_line)
    return fmt::format(
        "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"/>\n", x, y,
        radius, colour);
  return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\" fill=\"{}\"/>\n", x, y, radius, colour);
}

std::string bars_of(const FigureCurve& curve, const Axis& x, const Axis& y, const char* colour,
                    const std::string& frame) {
  std::string path;
  for (std::size_t k = 0; k < curve.x.size(); ++k)
    if (has_bar(curve, k))
      path += fmt::format("M{0:.2f} {1:.2f}V{2:.2f}M{3:.2f} {1:.2f}h6M{3:.2f} {2:.2f}h6", x.place(curve.x[k]),
                          y.place(curve.from[k]), y.place(curve.to[k]), x.place(curve.x[k]) - 3.0);
  if (path.empty()) return {};
  return fmt::format("<path clip-path=\"url(#{})\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.2\" d=\"{}\"/>\n",
                     frame, colour, path);
}

std::string curve_of(const FigurePanel& panel, std::size_t k, const Axis& x, const Axis& y, const std::string& frame) {
  const FigureCurve curve = thinned(panel, panel.curves[k]);
  const char* const colour = line_colours[k % line_colours.size()];
  std::string svg;
  if (curve.has_line)
    svg +=
        fmt::format("<path class=\"curve\" clip-path=\"url(#{})\" stroke=\"{}\" stroke-dasharray=\"{}\" d=\"{}\"/>\n",
                    frame, colour, dashes_of(panel, k), path_of(panel, curve, x, y));
  svg += bars_of(curve, x, y, colour, frame);
  if (!curve.markers && curve.has_line) return svg;
  for (std::size_t i = 0; i < curve.x.size(); ++i)
    if (is_point(panel, curve, i)) svg += marker(curve, x.place(curve.x[i]), y.place(curve.y[i]), colour);
  return svg;
}

// Beside the heading at the right, or, where it has no room there, in rows between heading and frame.
class Legend {
 public:
  explicit Legend(const FigurePanel& panel) : panel_(panel) {
    double all = 0.0;
    for (const FigureCurve& curve : panel.curves) all += width(curve);
    const double heading = 1.1 * width_of(panel.y_label);  // it is bold
    is_beside_ = frame_left + heading + all <= frame_right;
    left_ = is_beside_ ? frame_right - all + gap : frame_left;
    double end = left_;
    for (const FigureCurve& curve : panel.curves) {
      if (end > left_ && end + width(curve) - gap > frame_right) {
        end = left_;
        ++rows_;
      }
      end += width(curve);
    }
  }
  // Below the row of the heading.
  [[nodiscard]] double height() const { return is_beside_ ? 0.0 : row * rows_; }
  // The last row's letters stand on `baseline`.
  [[nodiscard]] std::string svg(double baseline) const {
    std::string svg;
    double x = left_, y = baseline - row * (rows_ - 1.0);
    for (std::size_t k = 0; k < panel_.curves.size(); ++k) {
      const FigureCurve& curve = panel_.curves[k];
      if (curve.label.empty()) continue;
      if (x > left_ && x + width(curve) - gap > frame_right) {
        x = left_;
        y += row;
      }
      if (!curve.has_line) {
        svg += marker(curve, x + key - 14.0, y - 4.5, line_colours[k % line_colours.size()]);
        svg += words("legend", x + key, y, "start", curve.label);
        x += width(curve);
        continue;
      }
      svg += fmt::format(
          "<line x1=\"{:.1f}\" y1=\"{}\" x2=\"{:.1f}\" y2=\"{}\" stroke=\"{}\" stroke-width=\"2.2\" "
          "stroke-dasharray=\"{}\"/>",
          x, y - 4.5, x + key - 8.0, y - 4.5, line_colours[k % line_colours.size()], dashes_of(panel_, k));
      svg += words("legend", x + key, y, "start", curve.label);
      x += width(curve);
    }
    return svg;
  }

 private:
  static constexpr double key = 38.0, gap = 16.0, row = 19.0;
  static double width(const FigureCurve& curve) {
    return curve.label.empty() ? 0.0 : key + width_of(curve.label) + gap;
  }

  const FigurePanel& panel_;
  bool is_beside_ = true;
  double left_ = 0.0, rows_ = 1.0;
};

// A picture as it grows downwards.
struct Growing {
  const Look& look;
  Drawing drawing;
  double y = 8.0;
};

void draw(const FigurePanel& panel, Growing& to) {
  std::string& svg = to.drawing.svg;
  bool is_cut = false;
  Interval values = drawn_values(panel, is_cut);
  to.y += heading_space;
  svg += words("heading", frame_left, to.y - 9.0, "start", panel.y_label);
  if (values.empty()) {
    svg += words("label", frame_left, to.y + mark_row, "start", "no finite value here");
    to.y += 2.0 * mark_row;
    return;
  }
  const Legend legend(panel);
  to.y += legend.height();
  const double top = to.y, bottom = top + panel.height;
  const Axis x(places_of(panel), panel.x_logarithmic, frame_left, frame_right, 11.0);
  FigurePanel shown = panel;
  if (is_cut) shown.marks.push_back({x.low(), x.high(), "cut off: larger values are not drawn"});
  // Words stand above the curves.
  const auto rows =
      std::count_if(shown.marks.begin(), shown.marks.end(), [](const FigureMark& mark) { return !mark.text.empty(); });
  const double words_height = std::min(mark_row * static_cast<double>(rows), panel.height / 2.0);
  if (words_height > 0.0) values.high += (values.high - values.low) * words_height / (panel.height - words_height);
  const Axis y(values, panel.y_logarithmic, bottom, top, 7.0);
  const std::size_t number = to.drawing.panels.size();
  const std::string frame = fmt::format("{}{}", to.look.ids, number);
  svg += fmt::format("<g class=\"panel\" data-panel=\"{}\">\n", number);
  svg += fmt::format("<clipPath id=\"{}\"><rect x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\"/></clipPath>", frame,
                     frame_left, top, frame_right - frame_left, panel.height);
  for (const FigureMark& mark : panel.marks) {
    if (mark.from == mark.to) continue;
    const double from = std::clamp(x.place(mark.from), frame_left, frame_right);
    const double end = std::clamp(x.place(mark.to), frame_left, frame_right);
    svg += fmt::format("<rect class=\"shade\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{}\"/>", from, top,
                       end - from, panel.height);
  }
  svg += axes(panel, x, y, top, bottom);
  for (std::size_t k = 0; k < panel.curves.size(); ++k) svg += curve_of(panel, k, x, y, frame);
  svg += fmt::format("<rect class=\"frame\" x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\"/>", frame_left, top,
                     frame_right - frame_left, panel.height);
  svg += words_of_marks(shown, x, top, bottom) + legend.svg(top - 9.0) + "</g>\n";
  to.drawing.panels.push_back({&panel, frame_left, top, frame_right, bottom, x.low(), x.high(), y.low(), y.high()});
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

}  // namespace

const char* const embedded_style = R"(svg { width: 100%; height: auto; font-size: 13px; }
svg text { fill: var(--ink); }
svg .title { font-size: 16px; font-weight: 600; }
svg .heading { font-weight: 600; }
svg .grid, svg .zero { stroke: var(--faint); }
svg .frame { fill: none; stroke: var(--soft); }
svg .mark { stroke: var(--soft); stroke-dasharray: 3 3; }
svg .curve { fill: none; stroke-width: 1.8; stroke-linejoin: round; }
)";

Drawing draw(const std::vector<Figure>& figures, const Look& look) {
  Growing growing{look, {}, look.is_embedded ? -8.0 : 8.0};
  for (const Figure& figure : figures) {
    if (!figure.title.empty()) {
      growing.y += title_line;
      growing.drawing.svg += words("title", 16.0, growing.y - 6.0, "start", figure.title);
    }
    for (const std::string& note : figure.notes) {
      for (const std::string& each : lines_of(note)) {
        growing.y += note_line;
        growing.drawing.svg += words("note", 16.0, growing.y - 5.0, "start", each);
      }
    }
    for (const FigurePanel& panel : figure.panels) draw(panel, growing);
    growing.y += look.is_embedded ? 0.0 : 14.0;
  }
  std::string& svg = growing.drawing.svg;
  if (look.is_embedded) {
    std::string label;
    for (const PlacedPanel& each : growing.drawing.panels)
      label += fmt::format("{}{} over {}", label.empty() ? "" : "; ", each.panel->y_label, each.panel->x_label);
    svg = fmt::format("<svg viewBox=\"0 0 {} {:.0f}\" role=\"img\" aria-label=\"{}\">\n{}</svg>\n", page_width,
                      growing.y, escape_html(label), svg);
  } else {
    svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1:.0f}\" width=\"{0}\" height=\"{1:.0f}\">\n{2}"
        "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{3}</svg>\n",
        page_width, growing.y, figure_style, svg);
  }
  return std::move(growing.drawing);
}

}  // namespace springnet::figure
