#include "validation/plot.hpp"

#include <cmath>

#include <doctest/doctest.h>

using namespace springnet;

namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t result = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++result;
  return result;
}

}  // namespace

TEST_CASE("points that cannot be drawn interrupt a line") {
  Plot plot{{"x", false}, {"y", true}, {{"line", {0, 1, 2, 3, 4, 5}, {0.0, 1.0, 2.0, NAN, 3.0, 4.0}, true, false}}};
  const std::string svg = to_svg(plot);
  const std::string path = svg.substr(svg.find("<path d=\""));
  CHECK(count(path.substr(0, path.find("fill")), "M") == 2);
  CHECK(count(svg, "<circle") == 4);
  CHECK(svg.find("nan") == std::string::npos);
  CHECK(svg.find("inf") == std::string::npos);
}

TEST_CASE("a straight line on logarithmic axes is drawn straight") {
  Plot plot{{"t", true}, {"e", true}, {{"", {0.01, 0.1, 1.0}, {1e-6, 1e-4, 1e-2}, false, false}}};
  const std::string svg = to_svg(plot);
  double x[3], y[3];
  REQUIRE(std::sscanf(svg.c_str() + svg.find("<path d=\""), "<path d=\"M%lf %lfL%lf %lfL%lf %lf", &x[0], &y[0], &x[1],
                      &y[1], &x[2], &y[2]) == 6);
  // Coordinates have one decimal.
  CHECK(std::abs(x[1] - (x[0] + x[2]) / 2.0) <= 0.11);
  CHECK(std::abs(y[1] - (y[0] + y[2]) / 2.0) <= 0.11);
  CHECK(x[0] < x[2]);
  CHECK(y[0] > y[2]);  // larger values are higher up
}

TEST_CASE("long series are thinned, peaks stay") {
  PlotSeries series{"long", {}, {}, false, false};
  for (int k = 0; k < 100000; ++k) {
    series.x.push_back(k);
    series.y.push_back(k == 54321 ? 1000.0 : 1.0);
  }
  const std::string svg = to_svg({{"x", false}, {"y", false}, {series}});
  CHECK(svg.size() < 20000);
  // The axis reaches the peak, and so does the line: its smallest y is that of the frame.
  CHECK(svg.find(">1000<") != std::string::npos);
  const std::string path = svg.substr(svg.find("<path d=\""));
  CHECK(count(path.substr(0, path.find("fill")), " 32.0L") == 1);
}

TEST_CASE("nothing to draw is said") {
  CHECK(to_svg({{"x", false}, {"y", true}, {}}).find("nothing to draw") != std::string::npos);
  CHECK(to_svg({{"x", false}, {"y", true}, {{"a", {0, 1}, {0.0, NAN}, false, false}}}).find("nothing to draw") !=
        std::string::npos);
}

TEST_CASE("labels are text, not markup") {
  CHECK(escape_html("a < b & \"c\" > d") == "a &lt; b &amp; &quot;c&quot; &gt; d");
  const std::string svg = to_svg({{"<x>", false}, {"y", false}, {{"<script>", {0, 1}, {1.0, 2.0}, false, false}}});
  CHECK(svg.find("<script>") == std::string::npos);
  CHECK(svg.find("&lt;script&gt;") != std::string::npos);
}
