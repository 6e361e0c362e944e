#include "validation/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace springnet {

namespace {

constexpr double width = 760.0, height = 440.0;
constexpr double left = 84.0, right = 20.0, bottom = 52.0;
// The legend is above the frame, in lines.
constexpr double legend_line = 20.0;
constexpr const char* dashes = " stroke-dasharray=\"6 4\"";
// Distinguishable with colour vision deficiencies (Okabe and Ito).
constexpr std::array<const char*, 7> colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                             "#e69f00", "#56b4e9", "#6b6b6b"};

// Maps values to coordinates on the page.
class Scale {
 public:
  Scale(bool logarithmic, double smallest, double largest, double from, double to)
      : logarithmic_(logarithmic), from_(from), to_(to) {
    low_ = transform(smallest);
    high_ = transform(largest);
    if (logarithmic_) {
      // A third of a decade around the points, one decade at least.
      low_ -= 0.15;
      high_ += 0.15;
      if (high_ - low_ < 1.0) {
        const double middle = (low_ + high_) / 2.0;
        low_ = middle - 0.5;
        high_ = middle + 0.5;
      }
    } else if (!(high_ > low_)) {
      low_ -= 0.5;
      high_ += 0.5;
    }
  }

  [[nodiscard]] double place(double value) const {
    return from_ + (transform(value) - low_) / (high_ - low_) * (to_ - from_);
  }

  // Round values within the range, and whether they are labelled.
  struct Tick {
    double value;
    bool labelled;
  };
  [[nodiscard]] std::vector<Tick> ticks() const { return logarithmic_ ? logarithmic_ticks() : linear_ticks(); }

 private:
  [[nodiscard]] double transform(double value) const { return logarithmic_ ? std::log10(value) : value; }

  [[nodiscard]] std::vector<Tick> linear_ticks() const {
    const double raw = (high_ - low_) / 7.0;
    const double power = std::pow(10.0, std::floor(std::log10(raw)));
    double step = 10.0 * power;
    for (const double factor : {5.0, 2.0, 1.0}) {
      if (factor * power >= raw) step = factor * power;
    }
    std::vector<Tick> result;
    for (double k = std::ceil(low_ / step - 1e-9); k * step <= high_ + 1e-9 * step; k += 1.0) {
      result.push_back({k * step + 0.0, true});  // + 0.0: no "-0"
    }
    return result;
  }

  [[nodiscard]] std::vector<Tick> logarithmic_ticks() const {
    const double decades = high_ - low_;
    const double every = std::ceil(decades / 8.0);
    std::vector<Tick> result;
    for (double decade = std::floor(low_); decade <= std::ceil(high_); decade += 1.0) {
      for (const double factor : {1.0, 2.0, 5.0}) {
        const double value = factor * std::pow(10.0, decade);
        const double place = std::log10(value);
        if (place < low_ || place > high_) continue;
        const bool whole = factor == 1.0;
        if (!whole && decades > 3.5) continue;
        result.push_back({value, whole ? std::fmod(std::abs(decade), every) == 0.0 : decades < 2.2});
      }
    }
    return result;
  }

  bool logarithmic_;
  double from_, to_;
  double low_, high_;
};

bool drawable(const Plot& plot, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!plot.x.logarithmic || x > 0.0) && (!plot.y.logarithmic || y > 0.0);
}

// Keeps the largest y of each of `buckets` groups of neighbours, because the peaks of an error matter.
PlotSeries thinned(const PlotSeries& series) {
  constexpr std::size_t buckets = 400;
  if (series.x.size() <= 2 * buckets) return series;
  PlotSeries result{series.label, {}, {}, series.markers, series.dashed};
  const std::size_t count = series.x.size();
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    const std::size_t first = bucket * count / buckets, end = (bucket + 1) * count / buckets;
    std::size_t best = first;
    for (std::size_t k = first; k < end; ++k) {
      if (series.y[k] > series.y[best]) best = k;
    }
    result.x.push_back(series.x[best]);
    result.y.push_back(series.y[best]);
  }
  return result;
}

struct Bounds {
  double x_low = INFINITY, x_high = -INFINITY, y_low = INFINITY, y_high = -INFINITY;
};

Bounds bounds_of(const Plot& plot) {
  Bounds bounds;
  for (const PlotSeries& series : plot.series) {
    for (std::size_t k = 0; k < series.x.size(); ++k) {
      const bool drawn = drawable(plot, series.x[k], series.y[k]);
      // A linear x axis shows its whole range, also where nothing is drawn.
      if (drawn || (!plot.x.logarithmic && std::isfinite(series.x[k]))) {
        bounds.x_low = std::min(bounds.x_low, series.x[k]);
        bounds.x_high = std::max(bounds.x_high, series.x[k]);
      }
      if (!drawn) continue;
      bounds.y_low = std::min(bounds.y_low, series.y[k]);
      bounds.y_high = std::max(bounds.y_high, series.y[k]);
    }
  }
  if (!plot.y.logarithmic) bounds.y_low = std::min(bounds.y_low, 0.0);
  return bounds;
}

std::string draw_axes(const Plot& plot, double top, const Scale& x, const Scale& y) {
  std::string svg;
  for (const Scale::Tick& tick : x.ticks()) {
    const double place = x.place(tick.value);
    svg += fmt::format("<line class=\"grid\" x1=\"{0:.1f}\" y1=\"{1}\" x2=\"{0:.1f}\" y2=\"{2}\"/>", place, top,
                       height - bottom);
    if (!tick.labelled) continue;
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:g}</text>", place, height - bottom + 18.0,
                       tick.value);
  }
  for (const Scale::Tick& tick : y.ticks()) {
    const double place = y.place(tick.value);
    svg += fmt::format("<line class=\"grid\" x1=\"{1}\" y1=\"{0:.1f}\" x2=\"{2}\" y2=\"{0:.1f}\"/>", place, left,
                       width - right);
    if (!tick.labelled) continue;
    svg +=
        fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>", left - 8.0, place + 4.0, tick.value);
  }
  svg += fmt::format("<rect class=\"frame\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>", left, top,
                     width - left - right, height - top - bottom);
  svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>", (left + width - right) / 2.0,
                     height - 10.0, escape_html(plot.x.label));
  svg += fmt::format("<text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     (top + height - bottom) / 2.0, escape_html(plot.y.label));
  return svg;
}

// Above the frame, whose upper end is `top`.
std::string draw_legend(const Plot& plot, double& top) {
  constexpr double key = 34.0, gap = 18.0, letter = 7.2;  // mean width of a letter
  std::string svg;
  double x = left, line = legend_line;
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    const PlotSeries& series = plot.series[k];
    if (series.label.empty()) continue;
    const double length = key + letter * static_cast<double>(series.label.size());
    if (x > left && x + length > width - right) {
      x = left;
      line += legend_line;
    }
    svg += fmt::format(
        "<line x1=\"{0}\" y1=\"{1}\" x2=\"{2}\" y2=\"{1}\" stroke=\"{3}\" stroke-width=\"2.5\"{4}/>"
        "<text x=\"{5}\" y=\"{6}\">{7}</text>\n",
        x, line - 4.0, x + key - 8.0, colours[k % colours.size()], series.dashed ? dashes : "", x + key, line,
        escape_html(series.label));
    x += length + gap;
  }
  top = line + 12.0;
  return svg;
}

std::string draw_series(const Plot& plot, const PlotSeries& series, const char* colour, const Scale& x,
                        const Scale& y) {
  std::string path, dots;
  bool pen_down = false;
  for (std::size_t k = 0; k < series.x.size(); ++k) {
    if (!drawable(plot, series.x[k], series.y[k])) {
      pen_down = false;
      continue;
    }
    const double px = x.place(series.x[k]), py = y.place(series.y[k]);
    path += fmt::format("{}{:.1f} {:.1f}", pen_down ? "L" : "M", px, py);
    pen_down = true;
    if (series.markers)
      dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>", px, py, colour);
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\"{}/>{}\n", path, colour,
                     series.dashed ? dashes : "", dots);
}

}  // namespace

std::string escape_html(std::string_view text) {
  std::string result;
  for (const char character : text) {
    switch (character) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += character;
    }
  }
  return result;
}

std::string to_svg(const Plot& plot) {
  const Bounds bounds = bounds_of(plot);
  const bool empty = !(bounds.y_low <= bounds.y_high);
  std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{} over {}\">\n", width,
                                empty ? 30.0 : height, escape_html(plot.y.label), escape_html(plot.x.label));
  if (empty) return svg + "<text x=\"0\" y=\"20\">nothing to draw</text></svg>\n";
  double top = 0.0;
  svg += draw_legend(plot, top);
  const Scale x(plot.x.logarithmic, bounds.x_low, bounds.x_high, left, width - right);
  const Scale y(plot.y.logarithmic, bounds.y_low, bounds.y_high, height - bottom, top);
  svg += draw_axes(plot, top, x, y);
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    svg += draw_series(plot, thinned(plot.series[k]), colours[k % colours.size()], x, y);
  }
  return svg + "</svg>\n";
}

}  // namespace springnet
