#include "figure_page.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/error.hpp>
#include <springnet/output_folder.hpp>
#include <springnet/printable.hpp>

#include "plot_page.hpp"
#include "text/markup.hpp"

namespace springnet::tool {

namespace {

// For a script element.
std::string panels_of(const figure::Drawing& drawing) {
  nlohmann::json panels = nlohmann::json::array();
  for (const figure::PlacedPanel& placed : drawing.panels) {
    nlohmann::json curves = nlohmann::json::array();
    for (const figure::FigureCurve& curve : placed.panel->curves) {
      curves.push_back({{"label", curve.label}, {"x", curve.x}, {"y", curve.y}});
      if (curve.from.empty()) continue;
      curves.back()["from"] = curve.from;
      curves.back()["to"] = curve.to;
    }
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
  return data;
}

}  // namespace

void require_ending(const std::filesystem::path& file) {
  if (file.extension() != ".svg" && file.extension() != ".html")
    throw Error(ErrorKind::input,
                fmt::format("--plot {}: the name must end in .svg or .html", printable_message(file.string())));
}

void write_figures(const std::filesystem::path& file, const std::string& title,
                   const std::vector<figure::Figure>& figures) {
  const std::string text = file.extension() == ".svg" ? figure::draw(figures).svg : page_of(title, figures);
  write_whole(OutputFile(OutputFolder::containing(file), file.filename().string()), text);
}

std::string page_of(const std::string& title, const std::vector<figure::Figure>& figures) {
  const figure::Drawing drawing = figure::draw(figures);
  return fmt::format(plot_page, escape_html(title), drawing.svg, panels_of(drawing), plot_script, plot_style);
}

std::string part_of_page(const std::vector<figure::Figure>& figures) {
  const figure::Drawing drawing = figure::draw(figures, {true, "figures"});
  return fmt::format(
      "<style>\n{}{}</style>\n<section id=\"figures\">\n{}</section><div id=\"values\" role=\"status\"></div>\n"
      "<script type=\"application/json\" id=\"panels\">{}</script>\n<script>\n{}</script>\n",
      figure::embedded_style, plot_style, drawing.svg, panels_of(drawing), plot_script);
}

}  // namespace springnet::tool
