// Pictures of curves: axes, lines that are interrupted, long curves, legends, texts.
#include "figure/figure.hpp"

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "figure/axis.hpp"
#include "text/markup.hpp"

using namespace springnet;
using namespace springnet::figure;

namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t result = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++result;
  return result;
}

Drawing drawn(FigurePanel panel, const Look& look = {}) { return draw({{"title", {}, {std::move(panel)}}}, look); }
FigurePanel panel_of(FigureCurve curve, bool x_logarithmic, bool y_logarithmic) {
  FigurePanel panel{"x", "y", {std::move(curve)}, {}};
  panel.x_logarithmic = x_logarithmic;
  panel.y_logarithmic = y_logarithmic;
  return panel;
}
// Of the first curve.
std::string path_in(const std::string& svg) {
  const std::size_t begin = svg.find(" d=\"", svg.find("<path")) + 4;
  return svg.substr(begin, svg.find('"', begin) - begin);
}
std::vector<double> labelled(const Axis& axis) {
  std::vector<double> values;
  for (const Tick& tick : axis.ticks())
    if (tick.is_labelled) values.push_back(tick.value);
  return values;
}

}  // namespace

TEST_CASE("ticks are round, and as many as asked for at most") {
  CHECK(labelled({{0.0, 1.0}, false, 0.0, 100.0, 5.0}) ==
        std::vector<double>{0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0});
  CHECK(labelled({{-3.0, 7.0}, false, 0.0, 100.0, 5.0}) == std::vector<double>{-2.0, 0.0, 2.0, 4.0, 6.0});
  CHECK(labelled({{1e-8, 1e-2}, true, 0.0, 100.0, 5.0}).size() == 7);  // each decade
  const Axis narrow({2.0, 2.0}, true, 0.0, 100.0, 5.0);
  CHECK(narrow.high() / narrow.low() == doctest::Approx(10.0));  // one decade at least, around the value
  CHECK(narrow.place(2.0) == doctest::Approx(50.0));
  CHECK(labelled(narrow) == std::vector<double>{1.0, 2.0, 5.0});
}

TEST_CASE("points that cannot be drawn interrupt a line") {
  const std::string svg =
      drawn(panel_of({"line", {0, 1, 2, 3, 4, 5}, {0.0, 1.0, 2.0, NAN, 3.0, 4.0}, false, true}, false, true)).svg;
  CHECK(count(path_in(svg), "M") == 2);
  CHECK(count(svg, "<circle") == 4);
  CHECK(svg.find("nan") == std::string::npos);
  CHECK(svg.find("inf") == std::string::npos);
}

TEST_CASE("a straight line on logarithmic axes is drawn straight") {
  const Drawing drawing = drawn(panel_of({"", {0.01, 0.1, 1.0}, {1e-6, 1e-4, 1e-2}}, true, true));
  double x[3], y[3];
  REQUIRE(std::sscanf(path_in(drawing.svg).c_str(), "M%lf %lfL%lf %lfL%lf %lf", &x[0], &y[0], &x[1], &y[1], &x[2],
                      &y[2]) == 6);
  // Coordinates have two decimals.
  CHECK(std::abs(x[1] - (x[0] + x[2]) / 2.0) <= 0.011);
  CHECK(std::abs(y[1] - (y[0] + y[2]) / 2.0) <= 0.011);
  CHECK(x[0] < x[2]);
  CHECK(y[0] > y[2]);  // larger values are higher up
  REQUIRE(drawing.panels.size() == 1);
  CHECK(drawing.panels[0].x_low < 0.01);
  CHECK(drawing.panels[0].x_high > 1.0);
}

TEST_CASE("long curves are thinned, peaks stay; paths are drawn in full") {
  FigureCurve curve{"long", {}, {}};
  for (int k = 0; k < 100000; ++k) {
    curve.x.push_back(k);
    curve.y.push_back(k == 54321 ? 1000.0 : 1.0);
  }
  FigurePanel panel = panel_of(curve, false, true);
  const Drawing drawing = drawn(panel);
  CHECK(drawing.svg.size() < 20000);
  // From 1 to 1000 with 0.15 decades around: the peak is at this height, once.
  const double peak = drawing.panels[0].top + 0.15 / 3.3 * (drawing.panels[0].bottom - drawing.panels[0].top);
  char place[32];
  std::snprintf(place, sizeof place, " %.2fL", peak);
  CHECK(count(path_in(drawing.svg), place) == 1);
  panel.is_path = true;
  CHECK(count(path_in(drawn(panel).svg), "L") == 99999);
}

TEST_CASE("values that exceed all others by far are cut off, and it is said") {
  FigureCurve pole{"", {}, {}};
  for (int k = 0; k <= 1000; ++k) {
    pole.x.push_back(0.001 * k);
    pole.y.push_back(1.0 / (0.5005 - pole.x.back()));
  }
  CHECK(drawn(panel_of(pole, false, false)).svg.find("cut off") != std::string::npos);
  CHECK(drawn(panel_of(pole, false, true)).svg.find("cut off") == std::string::npos);
}

TEST_CASE("nothing to draw is said") {
  CHECK(drawn({"x", "y", {}, {}}).svg.find("no finite value here") != std::string::npos);
  const Drawing drawing = drawn(panel_of({"a", {0, 1}, {0.0, NAN}}, false, true));
  CHECK(drawing.svg.find("no finite value here") != std::string::npos);
  CHECK(drawing.panels.empty());
}

TEST_CASE("a legend that has no room beside the heading gets rows of its own, within the picture") {
  FigurePanel panel{"x", "a heading of some words", {}, {}};
  const auto height = [&panel] { return drawn(panel).panels[0].top; };
  panel.curves.push_back({"one", {0, 1}, {1, 2}});
  const double beside = height();
  panel.curves.assign(7, {"a curve with a long name", {0, 1}, {1, 2}});
  const Drawing drawing = drawn(panel);
  CHECK(height() == beside + 3 * 19.0);  // three in a row
  const std::string word = "<text class=\"legend\" x=\"";
  for (std::size_t at = drawing.svg.find(word); at != std::string::npos; at = drawing.svg.find(word, at + 1))
    CHECK(std::stod(drawing.svg.substr(at + word.size())) < 600.0);
}

TEST_CASE("pictures in a page have ids of their own and the page's styles") {
  const FigurePanel panel = panel_of({"a", {0, 1}, {1.0, 2.0}}, false, false);
  const std::string svg = drawn(panel, {.is_embedded = true, .ids = "first"}).svg;
  CHECK(svg.find("id=\"first0\"") != std::string::npos);
  CHECK(svg.find("<style>") == std::string::npos);
  CHECK(svg.find("aria-label=\"y over x\"") != std::string::npos);
  CHECK(drawn(panel).svg.find("<style>") != std::string::npos);
}

TEST_CASE("labels are text, not markup") {
  CHECK(escape_html("a < b & \"c\" > d") == "a &lt; b &amp; &quot;c&quot; &gt; d");
  const std::string svg = drawn({"<x>", "y", {{"<script>", {0, 1}, {1.0, 2.0}}}, {}}).svg;
  CHECK(svg.find("<script>") == std::string::npos);
  CHECK(svg.find("&lt;script&gt;") != std::string::npos);
  CHECK(svg.find("&lt;x&gt;") != std::string::npos);
}
