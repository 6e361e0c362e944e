#include <cmath>

#include <fmt/format.h>
#include <springnet/validation.hpp>
#include <springnet/version.hpp>

#include "figure/figure.hpp"
#include "text/counted.hpp"
#include "text/markup.hpp"
#include "validation/scale.hpp"
#include "validation/table.hpp"

namespace springnet {

namespace {

constexpr const char* style = R"(
:root { color-scheme: light dark; --ink: #1d2329; --paper: #ffffff; --faint: #d9dee3; --soft: #59636e; }
@media (prefers-color-scheme: dark) { :root { --ink: #e3e7eb; --paper: #15191d; --faint: #343c44; --soft: #9aa5b1; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 60rem;
       margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; }
h2 { font-size: 1.15rem; margin-top: 2.2rem; }
.soft { color: var(--soft); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; white-space: nowrap; }
th, td { padding: .3rem .9rem .3rem 0; border-bottom: 1px solid var(--faint); text-align: right; }
th { font-weight: 600; }
th:first-child, td:first-child, th:last-child, td:last-child { text-align: left; }
td:last-child { white-space: normal; }
)";

std::string html_table(const Validation& validation) {
  std::string html = "<div class=\"wide\"><table>\n";
  bool heading = true;
  for (const TableRow& row : table_rows(validation)) {
    const char* const cell = heading ? "th" : "td";
    html += "<tr>";
    for (const std::string& text : row) html += fmt::format("<{0}>{1}</{0}>", cell, escape_html(text));
    html += "</tr>\n";
    heading = false;
  }
  return html + "</table></div>\n";
}

// A picture of one panel, drawn by the page's styles.
std::string picture(figure::FigurePanel panel, const std::string& ids) {
  panel.height = 340.0;
  panel.y_logarithmic = panel.has_plain_lines = true;
  return figure::draw({{"", {}, {std::move(panel)}}}, {.is_embedded = true, .ids = ids}).svg;
}

std::string error_over_time(const Validation& validation) {
  figure::FigurePanel panel{"time, s", "greatest distance of a node from the reference, m", {}, {}};
  const auto add = [&](const std::string& label, const std::vector<double>& errors, bool dashed) {
    figure::FigureCurve curve{label, {}, errors, dashed};
    curve.x.assign(validation.times.begin(), validation.times.begin() + static_cast<std::ptrdiff_t>(errors.size()));
    panel.curves.push_back(std::move(curve));
  };
  for (const ValidationRun& run : validation.runs) {
    add(fmt::format("time step {:g} s", run.time_step), run.error.max_by_time, false);
  }
  if (validation.second_order) {
    add(fmt::format("time step {:g} s, theta = 0.5", validation.second_order->time_step),
        validation.second_order->error.max_by_time, false);
  }
  add("uncertainty of the reference", validation.certification.max_by_time, true);
  return picture(std::move(panel), "over_time");
}

std::string error_over_time_step(const Validation& validation) {
  figure::FigurePanel panel{"time step, s", "error, m", {}, {}};
  panel.x_logarithmic = true;
  figure::FigureCurve max{"max over nodes and times", {}, {}, false, true};
  figure::FigureCurve rms{fmt::format("rms, slope {}", order_text(validation.observed_order)), {}, {}, false, true};
  for (const ValidationRun& run : validation.runs) {
    if (!run.finished()) continue;
    max.x.push_back(run.time_step);
    max.y.push_back(run.error.max);
    rms.x.push_back(run.time_step);
    rms.y.push_back(run.error.rms);
  }
  if (rms.x.size() >= 2 && rms.y.front() > 0.0) {
    // First order, for comparison.
    const double ratio = rms.x.back() / rms.x.front();
    panel.curves.push_back(
        {"first order", {rms.x.front(), rms.x.back()}, {rms.y.front(), rms.y.front() * ratio}, true, false});
  }
  if (validation.second_order && validation.second_order->finished()) {
    const ValidationRun& run = *validation.second_order;
    panel.curves.push_back({"max with theta = 0.5", {run.time_step}, {run.error.max}, false, true});
  }
  panel.curves.insert(panel.curves.begin(), {max, rms});
  return picture(std::move(panel), "over_time_step");
}

}  // namespace

std::string to_html(const Validation& validation) {
  const std::string name = validation.title.empty() ? validation.scene : validation.title;
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Validation: {0}</title>\n"
      "<style>{1}{8}</style></head><body>\n<h1>{0}</h1>\n"
      "<p class=\"soft\">{2}: {3}, {4}, {5:g} s, compared at {6}. springnet {7}</p>\n",
      escape_html(name), style, escape_html(validation.scene), counted(validation.nodes, "node"),
      counted(validation.springs, "spring"), validation.duration, counted(validation.times.size(), "time"), version(),
      figure::embedded_style);

  const ValidationRun& own = validation.run_of_scene();
  if (own.finished()) {
    html += fmt::format(
        "<p>With the scene's time step of {:g} s, no node is farther than <strong>{}</strong> from the "
        "reference at any of these times (greatest for node {} at {:g} s; rms {}). That is <strong>{}</strong> of {}, "
        "the greatest displacement of the reference from the start.</p>\n",
        own.time_step, length_text(own.error.max), own.error.node, own.error.time, length_text(own.error.rms),
        share_text(validation.share_of_displacement(own.error.max)), length_text(validation.displacement.max));
  } else {
    html += fmt::format("<p>With the scene's time step of {:g} s the run ended at {:g} s: <strong>{}</strong>.</p>\n",
                        own.time_step, own.reached, escape_html(own.outcome));
  }
  html += fmt::format(
      "<p>Reference: {}, relative tolerance {:g}. A second run with {:g} differs from it by at most {}: the "
      "uncertainty of the reference. Both took {:.3g} s. Observed order: {}.</p>\n",
      escape_html(validation.reference), validation.relative_tolerance, validation.certifying_tolerance,
      length_text(validation.uncertainty()), validation.reference_wall, order_text(validation.observed_order));

  if (const std::string advice = second_order_advice(validation); !advice.empty()) {
    html += fmt::format("<p><strong>Better:</strong> {}</p>\n", escape_html(advice));
  }

  html += "<h2>Runs</h2>\n" + html_table(validation);
  html += "<p class=\"soft\">* the scene's own time step. Order: from the run above to this one, by rms error.</p>\n";
  html += "<h2>Error over time</h2>\n" + error_over_time(validation);
  html += "<h2>Error over time step</h2>\n" + error_over_time_step(validation);
  if (!validation.notes.empty()) {
    html += "<h2>Notes</h2>\n<ul>\n";
    for (const std::string& note : validation.notes) html += fmt::format("<li>{}</li>\n", escape_html(note));
    html += "</ul>\n";
  }
  return html + "</body></html>\n";
}

}  // namespace springnet
