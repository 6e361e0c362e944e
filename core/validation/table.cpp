#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <springnet/validation.hpp>

#include "validation/table.hpp"

namespace springnet {

std::string order_text(double order) { return std::isfinite(order) ? fmt::format("{:.2f}", order) : "-"; }

std::string error_text(double error) { return std::isfinite(error) ? fmt::format("{:.3g} m", error) : "-"; }

std::vector<TableRow> table_rows(const Validation& validation) {
  std::vector<TableRow> rows{
      {"integrator", "time step", "max error", "rms error", "order", "sweeps/step", "wall", "outcome"}};
  for (const ValidationRun& run : validation.runs) {
    const double sweeps = run.steps > 0 ? static_cast<double>(run.sweeps) / static_cast<double>(run.steps) : 0.0;
    rows.push_back({run.integrator.id, fmt::format("{:g} s{}", run.time_step, run.of_scene ? " *" : ""),
                    error_text(run.error.max), error_text(run.error.rms), order_text(run.order),
                    fmt::format("{:.1f}", sweeps), fmt::format("{:.3g} s", run.wall),
                    run.finished() ? run.outcome : fmt::format("{} at {:.4g} s", run.outcome, run.reached)});
  }
  return rows;
}

std::string to_table(const Validation& validation) {
  const std::vector<TableRow> rows = table_rows(validation);
  std::array<std::size_t, std::tuple_size_v<TableRow>> widths{};
  for (const TableRow& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
  }

  std::string text = fmt::format("{}: {} nodes, {} springs, {:g} s, compared at {} times\n\n", validation.scene,
                                 validation.nodes, validation.springs, validation.duration, validation.times.size());
  for (const TableRow& row : rows) {
    text += " ";
    for (std::size_t k = 0; k < row.size(); ++k) {
      // Words to the left, numbers to the right.
      const bool words = k == 0 || k + 1 == row.size();
      text += words ? fmt::format(" {:<{}} ", row[k], widths[k]) : fmt::format(" {:>{}} ", row[k], widths[k]);
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  const ValidationRun& own = validation.run_of_scene();
  text += "\n  * the scene's own";
  if (std::isfinite(own.error.max)) {
    text += fmt::format("; its greatest error is at node {}, {:g} s", own.error.node, own.error.time);
  }
  text += fmt::format(
      "\n  reference: {}, relative tolerance {:g}, uncertain by {:.2g} m (difference to a run with {:g}), {:.3g} s\n"
      "  observed order: {}\n",
      validation.reference, validation.relative_tolerance, validation.uncertainty(), validation.certifying_tolerance,
      validation.reference_wall, order_text(validation.observed_order));
  for (const std::string& note : validation.notes) text += fmt::format("  note: {}\n", note);
  return text;
}

}  // namespace springnet
