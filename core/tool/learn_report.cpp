#include "learn_report.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "learn_compare.hpp"
#include "learn_page.hpp"
#include "text/counted.hpp"
#include "text/markup.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

// With the width alone where the ends do not differ in the digits that are shown.
std::string interval_of(const LearnedParameter& each) {
  const std::string lower = fmt::format("{:.6g}", each.lower), upper = fmt::format("{:.6g}", each.upper);
  if (lower != upper) return lower + " to " + upper;
  return fmt::format("{} ± {:.1g}", lower, 0.5 * (each.upper - each.lower));
}

// One row for each variable; two for a field, where it is least and greatest.
struct Table {
  std::vector<std::vector<std::string>> rows{{"value", "start", "learned", "95 % interval", "half the time step adds"}};
  std::size_t left_out = 0;
};

std::vector<std::string> row_of(const LearnedParameter& each, const std::string& which) {
  std::string interval = std::isfinite(each.determined) ? "not determined" : "not known";
  if (std::isfinite(each.upper)) interval = interval_of(each);
  if (each.at_bound) interval += ", at its bound";
  if (each.is_outside) interval += ", value outside";
  return {value_title(each) + which, fmt::format("{:.6g}", each.start), fmt::format("{:.8g}", each.value), interval,
          !each.has_influence                ? ""
          : std::isfinite(each.by_time_step) ? fmt::format("{:+.2g}", each.by_time_step)
                                             : "not known"};
}

Table table_of(const LearnedNet& learned) {
  constexpr std::size_t most = 12;
  Table table;
  std::size_t variable = 0;
  const auto add = [&](const LearnedParameter& each, const std::string& which) {
    if (table.rows.size() > most)
      ++table.left_out;
    else
      table.rows.push_back(row_of(each, which));
  };
  for (const LearnedParameter& each : learned.parameters) {
    if (each.variable != variable) continue;  // of one that stands there already
    variable += each.variables;
    if (each.variables == 1) {
      const bool is_one_value =
          !each.together ||
          std::all_of(learned.parameters.begin(), learned.parameters.end(), [&](const LearnedParameter& other) {
            return other.variable != each.variable || other.value == each.value;
          });
      add(each, is_one_value ? "" : fmt::format(", of {} {}", member_name(each.kind, each.of_elements), each.member));
      continue;
    }
    const LearnedParameter *least = &each, *greatest = &each;
    for (const LearnedParameter& other : learned.parameters) {
      if (other.variable != each.variable) continue;
      if (other.value < least->value) least = &other;
      if (other.value > greatest->value) greatest = &other;
    }
    add(*least, ", least of the field");
    add(*greatest, ", greatest of the field");
  }
  return table;
}

std::string text_of(Table table, const std::string& rest_in) {
  for (std::string& title : table.rows.front())
    std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string text = align_columns(table.rows);
  if (table.left_out > 0) text += fmt::format("  and {} more, in {}\n", table.left_out, rest_in);
  return text;
}

// Iterations of the whole motion are counted by themselves, as --iterations does.
std::string iterations_text(const LearnedNet& learned) {
  if (learned.history.empty()) return "no iteration";
  const int all = learned.history.back().iteration;
  if (learned.method == "online") return counted(static_cast<std::uint64_t>(all), "time step");
  const auto first = std::find_if(learned.history.begin(), learned.history.end(),
                                  [](const LearnProgress& each) { return each.share >= 1.0; });
  const int before = first == learned.history.end() ? all : first->iteration;
  const std::string text = counted(static_cast<std::uint64_t>(all), "iteration");
  return before == 0 ? text : fmt::format("{}, {} of them over parts of the motion", text, before);
}

}  // namespace

std::string report_of(const LearnedNet& learned, const std::string& rest_in) {
  std::string text = fmt::format(
      "{} from {}\n  cost {:.6g} at first, {:.6g} at the end, rms of the "
      "weighted differences {:.4g}, {}\n  {}\n{}\n{}",
      counted(learned.variables, "variable"), counted(learned.observed, "observed value"), learned.start_cost,
      learned.cost, learned.rms, iterations_text(learned), learned.reason,
      learned.fit.warning.empty() ? "" : fmt::format("\n  warning: {}\n", learned.fit.warning),
      text_of(table_of(learned), rest_in));
  if (learned.undetermined > 0) {
    text += fmt::format(
        "\n  {} of the variables {} no influence on what was observed: values that {} touch{} are not determined, and "
        "what they are says nothing.\n",
        counted(learned.undetermined, "combination"), learned.undetermined == 1 ? "has" : "have",
        learned.undetermined == 1 ? "it" : "they", learned.undetermined == 1 ? "es" : "");
  }
  if (!learned.guess_curve.empty())
    text += fmt::format("\n  weight of the guess: {:.4g}, from {} tried\n", learned.guess_weight,
                        learned.guess_curve.size());
  if (learned.held_out.observed > 0) {
    text += fmt::format("\n  held out: {} values, rms of their weighted differences {:.4g} at first, {:.4g} at the end",
                        learned.held_out.observed, learned.held_out.start_rms, learned.held_out.rms);
    if (std::isfinite(learned.held_out.half_step_rms))
      text += fmt::format(", about {:.4g} with half the time step", learned.held_out.half_step_rms);
    text += "\n";
  }
  if (!learned.courses.empty()) text += comparison_table(learned.courses);
  for (const std::string& note : learned.notes) text += fmt::format("  note: {}\n", note);
  return text;
}

std::string learned_table(const LearnedNet& learned) {
  const Table table = table_of(learned);
  std::string html =
      "<style>\n#learned { overflow-x: auto; }\n#learned table { border-collapse: collapse; }\n"
      "#learned th { text-align: left; font-weight: 600; }\n"
      "#learned td, #learned th { padding: 3px 18px 3px 0; border-bottom: 1px solid var(--faint); white-space: nowrap; "
      "}\n"
      "#learned td { font-variant-numeric: tabular-nums; }\n"
      "#learned .warning { border-left: 4px solid #d55e00; padding: 2px 10px; max-width: 80ch; }\n</style>\n"
      "<section id=\"learned\">\n";
  if (!learned.fit.warning.empty())
    html += fmt::format("<p class=\"warning\" role=\"alert\">{}</p>\n", escape_html(learned.fit.warning));
  html += "<table>\n";
  const char* cell = "th";
  for (const std::vector<std::string>& row : table.rows) {
    html += "<tr>";
    for (const std::string& each : row) html += fmt::format("<{0}>{1}</{0}>", cell, escape_html(each));
    html += "</tr>\n";
    cell = "td";
  }
  html += "</table>\n";
  if (table.left_out > 0) html += fmt::format("<p>and {} more</p>\n", table.left_out);
  return html + "</section>\n";
}

}  // namespace springnet::tool
