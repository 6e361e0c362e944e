#include "learn_page.hpp"

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "figure_page.hpp"

namespace springnet::tool {

namespace {

using figure::Figure;
using figure::FigureCurve;
using figure::FigurePanel;

// Of each stage a curve: each learns from more of the motion.
Figure course_of(const LearnedNet& learned) {
  Figure result{
      "Course of the search",
      {fmt::format("{} variables, {} observed values. {}", learned.variables, learned.observed, learned.reason)},
      {}};
  FigurePanel panel;
  panel.x_label = "iteration";
  panel.y_label = "log10 of the rms of weighted differences";
  panel.has_plain_lines = true;
  double share = -1.0;
  for (const LearnProgress& each : learned.history) {
    if (each.share != share && (panel.curves.empty() || learned.history.front().share < 1.0) &&
        panel.curves.size() < 8) {
      share = each.share;
      panel.curves.push_back({fmt::format("{:g} % of the time", 100.0 * share), {}, {}, false, true});
    }
    panel.curves.back().x.push_back(each.iteration);
    panel.curves.back().y.push_back(std::log10(each.rms));
  }
  if (!panel.curves.empty()) result.panels.push_back(std::move(panel));
  return result;
}

// Values of one kind over their members: start, learned, ends of the intervals.
std::vector<Figure> values_of(const LearnedNet& learned) {
  std::map<std::string, std::vector<const LearnedParameter*>> kinds;
  for (const LearnedParameter& each : learned.parameters) kinds[name_of(each)].push_back(&each);
  std::vector<Figure> result;
  for (const auto& [name, list] : kinds) {
    const LearnedParameter& first = *list.front();
    FigurePanel panel;
    panel.x_label = member_name(first.kind, first.of_elements);
    panel.y_label = name;
    FigureCurve start{"start", {}, {}, true, false}, value{"learned", {}, {}, false, true};
    FigureCurve lower{"95 % interval", {}, {}, true, false}, upper{"", {}, {}, true, false};
    std::size_t open = 0;
    for (const LearnedParameter* const each : list) {
      for (FigureCurve* const curve : {&start, &value, &lower, &upper}) curve->x.push_back(each->member);
      start.y.push_back(each->start);
      value.y.push_back(each->value);
      lower.y.push_back(each->lower);
      upper.y.push_back(each->upper);
      if (!std::isfinite(each->upper)) ++open;
    }
    panel.curves = {std::move(start), std::move(value), std::move(lower), std::move(upper)};
    Figure figure{name, {}, {}};
    if (open > 0)
      figure.notes.push_back(
          fmt::format("{} of {} have no interval: the data do not determine them.", open, list.size()));
    figure.panels.push_back(std::move(panel));
    result.push_back(std::move(figure));
  }
  return result;
}

}  // namespace

std::string page_of(const std::string& title, const LearnedNet& learned) {
  std::vector<Figure> figures{course_of(learned)};
  for (Figure& each : values_of(learned)) figures.push_back(std::move(each));
  figures.front().notes.insert(figures.front().notes.end(), learned.notes.begin(), learned.notes.end());
  return page_of(title, figures);
}

}  // namespace springnet::tool
