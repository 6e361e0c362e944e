#include "run/space.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/output.hpp>

#include "run/recorder.hpp"
#include "tables/table_file.hpp"
#include "vtk/vtk_series.hpp"

namespace springnet {

namespace {

double bytes_of(const OutputEstimate& estimate, const std::string& file) {
  for (const FileEstimate& each : estimate.files)
    if (each.file == file) return each.bytes;
  return 0.0;
}

// Up to the next number of two digits.
double rounded_up(double number) {
  const double digit = std::pow(10.0, std::floor(std::log10(number)) - 1.0);
  return digit * std::ceil(number / digit - 1e-9);
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
  Scene trial = scene;
  const auto estimate_with = [&trial](double interval) {
    trial.output.interval = interval;
    return estimate_output(trial);
  };
  const double shortest = std::max(scene.output.interval, scene.options.time_step);
  const double longest = std::max(scene.duration, shortest);
  const OutputEstimate least = estimate_with(longest);
  if (!(least.bytes <= bytes)) return std::nullopt;
  const OutputEstimate most = estimate_with(shortest);
  if (!(most.records > least.records && most.bytes > least.bytes)) return std::nullopt;
  // Files have shares that do not depend on the interval, and grow with the records; from the estimate of that on, up
  // to where it fits (pictures may have an interval of their own, and a record more or less counts).
  const double record = (most.bytes - least.bytes) / (most.records - least.records);
  double interval = std::max(shortest, longest / (1.0 + (bytes - least.bytes) / record));
  for (int tries = 0; interval < longest; ++tries) {
    interval = rounded_up(interval);
    if (estimate_with(interval).bytes <= bytes) return interval;
    interval *= tries < 10 ? 1.005 : 1.2;
  }
  return rounded_up(longest);
}

std::optional<std::string> space_refusal(const Scene& scene, const Space& space, const std::string& folder) {
  const OutputEstimate estimate = estimate_output(scene);
  if (estimate.bytes <= space.available()) return std::nullopt;
  const auto largest = std::max_element(estimate.files.begin(), estimate.files.end(),
                                        [](const FileEstimate& a, const FileEstimate& b) { return a.bytes < b.bytes; });
  const OutputOptions& options = scene.output;
  std::vector<std::string> enough, others;
  const auto offer = [&](double bytes, std::string remedy) {
    (bytes <= space.available() ? enough : others).push_back(std::move(remedy));
  };
  offer(estimate.bytes - largest->bytes, leave_out(largest->file));
  if (const std::optional<double> interval = interval_for(scene, space.available()))
    enough.push_back(fmt::format("record less often (output.interval = {:.2g})", *interval));
  if (largest->file == view_file) offer(estimate.bytes - largest->bytes, "make the page smaller (output.view_size)");
  const double pictures = bytes_of(estimate, std::string(vtk_folder) + "/");
  if (pictures > 0.0) offer(estimate.bytes - pictures, "make fewer pictures (output.vtk_interval)");
  Scene shorter = scene;
  if (options.format == OutputOptions::Format::csv) {
    shorter.output.format = OutputOptions::Format::binary;
    offer(estimate_output(shorter).bytes, "write the binary form (output.format = \"binary\")");
  } else if (options.precision == OutputOptions::Precision::float64) {
    shorter.output.precision = OutputOptions::Precision::float32;
    offer(estimate_output(shorter).bytes, "write shorter numbers (output.precision = \"single\")");
  }
  if (options.trajectory)
    offer(estimate.bytes - bytes_of(estimate, table_name("trajectory", options)), "write fewer nodes (output.nodes)");
  const std::string remedies = enough.empty() ? fmt::format("several of these together: {}", fmt::join(others, ", "))
                                              : fmt::format("{}", fmt::join(enough, ", "));
  return fmt::format(
      "the output would be about {} ({:.3g} records, most of it {}), but only {} are free in {}{}; {}, or write to "
      "another disk",
      readable_bytes(estimate.bytes), estimate.records, largest->file, readable_bytes(space.free), folder,
      space.earlier > 0.0 ? fmt::format(", and {} in files of an earlier run", readable_bytes(space.earlier)) : "",
      remedies);
}

}  // namespace springnet
