#include "figure_page.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "plot_page.hpp"
#include "text/markup.hpp"

namespace springnet::tool {

std::string page_of(const std::string& title, const std::vector<figure::Figure>& figures) {
  const figure::Drawing drawing = figure::draw(figures);
  nlohmann::json panels = nlohmann::json::array();
  for (const figure::PlacedPanel& placed : drawing.panels) {
    nlohmann::json curves = nlohmann::json::array();
    for (const figure::FigureCurve& curve : placed.panel->curves)
      curves.push_back({{"label", curve.label}, {"x", curve.x}, {"y", curve.y}});
    panels.push_back({{"frame", {placed.left, placed.top, placed.right, placed.bottom}},
                      {"x", {placed.x_low, placed.x_high}},
                      {"y", {placed.y_low, placed.y_high}},
                      {"x_label", placed.panel->x_label},
                      {"y_label", placed.panel->y_label},
                      {"is_path", placed.panel->is_path},
                      {"curves", curves}});
  }
  // JSON in a script element must not end it.
  std::string data = panels.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = data.find('<'); at != std::string::npos; at = data.find('<', at))
    data.replace(at, 1, "\\u003c");
  return fmt::format(plot_page, escape_html(title), drawing.svg, data);
}

}  // namespace springnet::tool
