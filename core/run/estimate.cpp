#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <springnet/output.hpp>
#include <springnet/view.hpp>

#include "tables/csv_file.hpp"
#include "run/recorder.hpp"
#include "tables/table_file.hpp"
#include "vtk/vtk_series.hpp"

namespace springnet {

namespace {

// Characters of the longest number, "-2.2250738585072014e-308", and of its comma.
constexpr double number_length = 25.0;
// Those of the longest time, which has no sign; its comma is counted with the row.
constexpr double time_length = 23.0;

double digits_of(double count) { return std::floor(std::log10(std::max(count - 1.0, 1.0))) + 1.0; }

// Characters of the name of each surface and its comma, or of its number.
std::vector<double> name_lengths(const Network& network) {
  std::vector<double> lengths;
  const auto add = [&](const auto& surface) {
    const double number = digits_of(static_cast<double>(lengths.size()) + 1.0);
    lengths.push_back(1.0 + (surface.name.empty() ? number : static_cast<double>(csv_cell(surface.name).size())));
  };
  for (const Plane& plane : network.planes()) add(plane);
  for (const Instrument& instrument : network.instruments()) add(instrument);
  return lengths;
}

// Those of the longest names together; as many surfaces as a node can touch at once.
double longest_together(std::vector<double> lengths) {
  constexpr std::size_t most = 3;
  std::sort(lengths.begin(), lengths.end(), std::greater<>());
  lengths.resize(std::min(lengths.size(), most));
  return std::accumulate(lengths.begin(), lengths.end(), 0.0);
}

}  // namespace

namespace {

// One at the start, one each interval, and one at the end where that falls between.
double count_records(double duration, double interval) {
  const double intervals = duration / interval;
  const double whole = std::floor(intervals * (1.0 + 1e-12));
  return whole + 1.0 + (intervals - whole > 1e-9 * intervals ? 1.0 : 0.0);
}

class Estimate {
 public:
  explicit Estimate(const Scene& scene) : options_(scene.output) {
    result_.records = count_records(scene.duration, std::max(options_.interval, scene.options.time_step));
  }

  void add(const std::string& file, double bytes, bool exact) {
    result_.files.push_back({file, bytes, exact});
    result_.bytes += bytes;
  }
  // `record`: characters of a record.
  void add_text(const std::string& file, double record) { add(file, result_.records * record, false); }
  // `cells`: characters of the numbers of a row but time and row number, commas included.
  void add_table(const std::string& stem, const TableForm& form, double cells) {
    const std::string file = table_name(stem, options_);
    if (options_.format == OutputOptions::Format::csv) {
      const auto rows = static_cast<double>(form.numbers.size());
      add_text(file, rows == 0.0 ? 0.0 : rows * (time_length + digits_of(form.numbers.back() + 1.0) + 2.0 + cells));
    } else {
      const auto header = static_cast<double>(binary_header(form, options_.precision).size());
      add(file, header + result_.records * static_cast<double>(record_bytes(form, options_.precision)), true);
    }
  }
  [[nodiscard]] double records() const { return result_.records; }
  [[nodiscard]] OutputEstimate take() { return std::move(result_); }

 private:
  const OutputOptions& options_;
  OutputEstimate result_;
};

}  // namespace

OutputEstimate estimate_output(const Scene& scene) {
  const Network& network = scene.network;
  const OutputOptions& options = scene.output;
  Estimate estimate(scene);
  const TableForm trajectory = trajectory_form(network, options);
  if (options.trajectory) {
    estimate.add_table("trajectory", trajectory, static_cast<double>(trajectory.columns.size()) * number_length);
  }
  const auto surfaces = static_cast<double>(network.planes().size() + network.instruments().size());
  if (options.reactions) {
    // Any node may come to rest on a surface.
    const auto rows =
        static_cast<double>(std::count_if(trajectory.numbers.begin(), trajectory.numbers.end(), [&](NodeIndex node) {
          return surfaces > 0.0 || network.nodes()[node].fixed;
        }));
    const double nodes = static_cast<double>(network.nodes().size());
    estimate.add_text("reactions.csv", rows * (time_length + digits_of(nodes) + 9.0 * number_length + 3.0 +
                                               longest_together(name_lengths(network))));
  }
  if (options.surfaces && surfaces > 0.0) {
    const auto nodes = static_cast<double>(network.nodes().size());
    const std::vector<double> names = name_lengths(network);
    estimate.add_text("surfaces.csv", surfaces * (time_length + 12.0 * number_length + digits_of(nodes) + 2.0) +
                                          std::accumulate(names.begin(), names.end(), 0.0));
  }
  if (options.rigid && !network.rigids().empty()) {
    const auto rigids = static_cast<double>(network.rigids().size());
    estimate.add_text("rigid.csv", rigids * (time_length + digits_of(rigids) + number_length + 2.0));
  }
  if (!options.springs.empty()) {
    estimate.add_table("springs", spring_form(options), 3.0 * number_length + 2.0);
  }
  if (options.elements && !network.elements().empty()) {
    estimate.add_table("elements", element_form(network, options), 2.0 * number_length + 2.0);
  }
  if (options.view) estimate.add(view_file, estimate_view(scene), false);
  if (options.vtk) {
    const double interval = std::max({options.vtk_interval, options.interval, scene.options.time_step});
    const double records = std::min(estimate.records(), count_records(scene.duration, interval));
    estimate.add(std::string(vtk_folder) + "/",
                 records * vtk_record_bytes(network, options) + vtk_index_bytes(network, records), false);
  }
  return estimate.take();
}

std::string readable_bytes(double bytes) {
  constexpr std::array<const char*, 6> units{"bytes", "kB", "MB", "GB", "TB", "PB"};
  std::size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < units.size()) {
    bytes /= 1000.0;
    ++unit;
  }
  return unit == 0 ? fmt::format("{:.0f} bytes", bytes) : fmt::format("{:.3g} {}", bytes, units[unit]);
}

}  // namespace springnet
