#include "run/space.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/run.hpp>

#include "run/outputs.hpp"
#include "run/record_times.hpp"

namespace springnet {

namespace {

// Rounded up to two digits.
double rounded_up(double number) {
  const double digit = std::pow(10.0, std::floor(std::log10(number)) - 1.0);
  return digit * std::ceil(number / digit - 1e-9);
}

}  // namespace

OutputEstimate estimate_output(const Scene& scene) {
  OutputEstimate estimate;
  estimate.records = count_records(scene.duration, record_interval(scene));
  for (OutputSize& size : output_sizes(scene)) {
    estimate.bytes += size.file.bytes;
    estimate.files.push_back(std::move(size.file));
  }
  return estimate;
}

std::optional<double> interval_for(const Scene& scene, double bytes) {
  Scene trial = scene;
  const auto estimate_with = [&trial](double interval) {
    trial.output.interval = interval;
    return estimate_output(trial);
  };
  const double shortest = std::max(scene.output.interval, scene.options.time_step);
  const double longest = std::max(scene.duration, shortest);
  const OutputEstimate smallest = estimate_with(longest);
  if (!(smallest.bytes <= bytes)) return std::nullopt;
  const OutputEstimate largest = estimate_with(shortest);
  if (!(largest.records > smallest.records && largest.bytes > smallest.bytes)) return std::nullopt;
  // Sizes are nearly linear in the number of records, but pictures may have an interval of their own, and a single
  // record more may matter. So start from the linear estimate and increase the interval until the output fits.
  const double record = (largest.bytes - smallest.bytes) / (largest.records - smallest.records);
  double interval = std::max(shortest, longest / (1.0 + (bytes - smallest.bytes) / record));
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
  const std::vector<OutputSize> sizes = output_sizes(scene);
  const auto largest = std::max_element(
      sizes.begin(), sizes.end(), [](const OutputSize& a, const OutputSize& b) { return a.file.bytes < b.file.bytes; });
  std::vector<std::string> enough, others;
  const auto offer = [&](double bytes, std::string remedy) {
    (bytes <= space.available() ? enough : others).push_back(std::move(remedy));
  };
  offer(estimate.bytes - largest->file.bytes, largest->output->leave_out_hint(scene));
  if (const std::optional<double> interval = interval_for(scene, space.available()))
    enough.push_back(fmt::format("record less often (output.interval = {:.2g})", *interval));
  for (const OutputSize& size : sizes) {
    if (std::string remedy = size.output->shrink_hint(); !remedy.empty()) {
      offer(estimate.bytes - size.file.bytes, std::move(remedy));
    }
  }
  Scene shorter = scene;
  if (scene.output.format == OutputOptions::Format::csv) {
    shorter.output.format = OutputOptions::Format::binary;
    offer(estimate_output(shorter).bytes, "write the binary form (output.format = \"binary\")");
  } else if (scene.output.precision == OutputOptions::Precision::float64) {
    shorter.output.precision = OutputOptions::Precision::float32;
    offer(estimate_output(shorter).bytes, "write shorter numbers (output.precision = \"single\")");
  }
  const std::string remedies = enough.empty() ? fmt::format("several of these together: {}", fmt::join(others, ", "))
                                              : fmt::format("{}", fmt::join(enough, ", "));
  return fmt::format(
      "the output would take about {} ({:.3g} records, most of it in {}), but only {} are free in {}{}; {}, or write "
      "to another disk",
      readable_bytes(estimate.bytes), estimate.records, largest->file.file, readable_bytes(space.free), folder,
      space.earlier > 0.0 ? fmt::format(", and {} in files of an earlier run", readable_bytes(space.earlier)) : "",
      remedies);
}

}  // namespace springnet
