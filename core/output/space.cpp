#include "output/space.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/output.hpp>

#include "output/recorder.hpp"
#include "output/vtk_series.hpp"

namespace springnet {

namespace {

double bytes_with(Scene& scene, double interval) {
  scene.output.interval = interval;
  return estimate_output(scene).bytes;
}

// "leave out trajectory.csv (output.trajectory = false)"
std::string leave_out(const std::string& file) {
  const std::string stem = file.substr(0, file.find_first_of("./"));
  if (stem == "springs") return fmt::format("write fewer springs to {} (output.springs)", file);
  if (stem == "elements") {
    return fmt::format("leave out {} (output.elements = false, or a list of names of [[element]] for some)", file);
  }
  return fmt::format("leave out {} (output.{} = false)", file, stem);
}

}  // namespace

std::optional<double> interval_for(const Scene& scene, double bytes) {
  // Files have shares that do not depend on the interval, so it is looked for, not computed.
  Scene trial = scene;
  double low = std::max(scene.output.interval, scene.options.time_step);
  double high = std::max(scene.duration, low);
  if (!(bytes_with(trial, high) <= bytes)) return std::nullopt;
  while (high > 1.001 * low) {
    const double middle = std::sqrt(low) * std::sqrt(high);
    (bytes_with(trial, middle) <= bytes ? high : low) = middle;
  }
  const double digit = std::pow(10.0, std::floor(std::log10(high)) - 1.0);
  // Intervals that do not divide the duration have one more record than slightly longer ones.
  for (int k = 0; k < 100; ++k) {
    const double interval = digit * (std::ceil(high / digit) + k);
    if (bytes_with(trial, interval) <= bytes) return interval;
  }
  return std::nullopt;
}

std::optional<std::string> space_refusal(const Scene& scene, const Space& space, const std::string& folder) {
  const OutputEstimate estimate = estimate_output(scene);
  if (estimate.bytes <= space.available()) return std::nullopt;
  const auto largest = std::max_element(estimate.files.begin(), estimate.files.end(),
                                        [](const FileEstimate& a, const FileEstimate& b) { return a.bytes < b.bytes; });
  const OutputOptions& options = scene.output;
  std::vector<std::string> remedies{leave_out(largest->file)};
  if (largest->file == view_file) remedies.emplace_back("make the page smaller (output.view_size)");
  if (options.vtk) remedies.emplace_back("make fewer pictures (output.vtk_interval)");
  if (const std::optional<double> interval = interval_for(scene, space.available())) {
    remedies.push_back(fmt::format("record less often (output.interval = {:.2g})", *interval));
  }
  if (options.format == OutputOptions::Format::csv) {
    remedies.emplace_back("write the binary form (output.format = \"binary\")");
  } else if (options.precision == OutputOptions::Precision::float64) {
    remedies.emplace_back("write shorter numbers (output.precision = \"single\")");
  }
  if (options.trajectory) remedies.emplace_back("write fewer nodes (output.nodes)");
  return fmt::format(
      "the output would be about {} ({:.3g} records, most of it {}), but only {} are free in {}{}; {}, or write to "
      "another disk",
      readable_bytes(estimate.bytes), estimate.records, largest->file, readable_bytes(space.free), folder,
      space.earlier > 0.0 ? fmt::format(", and {} in files of an earlier run", readable_bytes(space.earlier)) : "",
      fmt::join(remedies, ", "));
}

}  // namespace springnet
