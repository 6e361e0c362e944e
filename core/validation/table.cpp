#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <springnet/validation.hpp>

#include "text/counted.hpp"
#include "validation/scale.hpp"
#include "validation/table.hpp"

namespace springnet {

std::string order_text(double order) { return std::isfinite(order) ? fmt::format("{:.2f}", order) : "-"; }

namespace {

TableRow row_of(const Validation& validation, const ValidationRun& run, const LengthUnit& unit) {
  const double sweeps = run.steps > 0 ? static_cast<double>(run.sweeps) / static_cast<double>(run.steps) : 0.0;
  return {run.integrator.id,
          fmt::format("{:g} s{}", run.time_step, run.of_scene ? " *" : ""),
          length_in(unit, run.error.max),
          share_text(validation.share_of_displacement(run.error.max)),
          length_in(unit, run.error.rms),
          order_text(run.order),
          fmt::format("{:.1f}", sweeps),
          fmt::format("{:.3g} s", run.wall),
          run.finished() ? run.outcome : fmt::format("{} at {:.4g} s", run.outcome, run.reached)};
}

// Terminal columns of UTF-8 text without wide characters.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

std::vector<TableRow> table_rows(const Validation& validation) {
  const LengthUnit unit = unit_of_errors(validation);
  std::vector<TableRow> rows{{"integrator", "time step", fmt::format("max error, {}", unit.name), "of displacement",
                              fmt::format("rms error, {}", unit.name), "order", "sweeps/step", "wall", "outcome"}};
  for (const ValidationRun& run : validation.runs) rows.push_back(row_of(validation, run, unit));
  if (validation.second_order) {
    rows.push_back(row_of(validation, *validation.second_order, unit));
    rows.back()[0] += ", theta 0.5";
  }
  return rows;
}

std::string second_order_advice(const Validation& validation) {
  if (!validation.second_order_is_better()) return "";
  const ValidationRun& own = validation.run_of_scene();
  const ValidationRun& other = *validation.second_order;
  const std::string what = "theta = 0.5 in simulation.integrator: with the same time step ";
  if (!own.finished()) {
    return what + fmt::format("the run reaches the end, with a greatest error of {} ({} of the displacement).",
                              length_text(other.error.max),
                              share_text(validation.share_of_displacement(other.error.max)));
  }
  return what +
         fmt::format(
             "the greatest error is {} instead of {}{}, the rms error {} instead of {}, in {:.2g} times the "
             "wall time.",
             length_text(other.error.max), length_text(own.error.max),
             other.error.max > 0.0 ? fmt::format(" ({:.3g} times smaller)", own.error.max / other.error.max) : "",
             length_text(other.error.rms), length_text(own.error.rms), other.wall / own.wall);
}

std::string to_table(const Validation& validation) {
  const std::vector<TableRow> rows = table_rows(validation);
  std::array<std::size_t, std::tuple_size_v<TableRow>> widths{};
  for (const TableRow& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], width_of(row[k]));
  }

  std::string text =
      fmt::format("{}: {}, {}, {:g} s, compared at {}\n\n", validation.scene, counted(validation.nodes, "node"),
                  counted(validation.springs, "spring"), validation.duration, counted(validation.times.size(), "time"));
  for (const TableRow& row : rows) {
    text += " ";
    for (std::size_t k = 0; k < row.size(); ++k) {
      // Aligns text to the left, numbers to the right.
      const bool words = k == 0 || k + 1 == row.size();
      const std::string padding(widths[k] - width_of(row[k]), ' ');
      text += words ? ' ' + row[k] + padding + ' ' : ' ' + padding + row[k] + ' ';
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  const ValidationRun& own = validation.run_of_scene();
  text += "\n  * the scene's own";
  if (std::isfinite(own.error.max)) {
    text += fmt::format("; its greatest error is at node {}, {:g} s", own.error.node, own.error.time);
  }
  const Displacement& moved = validation.displacement;
  text += fmt::format(
      "\n  displacement: the reference moves by up to {} from the start (node {}, {:g} s)\n"
      "  reference: {}, relative tolerance {:g}, uncertain by {} (difference to a run with {:g}), {:.3g} s\n"
      "  observed order: {}\n",
      length_text(moved.max), moved.node, moved.time, validation.reference, validation.relative_tolerance,
      length_text(validation.uncertainty()), validation.certifying_tolerance, validation.reference_wall,
      order_text(validation.observed_order));
  if (const std::string advice = second_order_advice(validation); !advice.empty()) {
    text += fmt::format("  better: {}\n", advice);
  }
  for (const std::string& note : validation.notes) text += fmt::format("  note: {}\n", note);
  return text;
}

}  // namespace springnet
