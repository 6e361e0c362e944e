#include "output/recorder.hpp"

#include <cmath>
#include <exception>
#include <limits>
#include <system_error>

#include <fmt/format.h>
#include <springnet/output.hpp>
#include <springnet/view.hpp>

#include "output/table_file.hpp"
#include "output/vtk_series.hpp"

namespace springnet {

namespace {

std::uintmax_t size_of(const std::filesystem::path& file) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(file, unknown);
  return unknown ? 0 : size;
}

// A writer of one file.
template <class Writer>
class FileSink : public Sink {
 public:
  template <class... Arguments>
  explicit FileSink(const std::filesystem::path& file, const Arguments&... arguments)
      : file_(file), writer_(file, arguments...) {}

  void record(const Simulation& simulation) override { writer_.record(simulation); }
  void close() override { writer_.close(); }
  [[nodiscard]] std::uintmax_t bytes() const override { return size_of(file_); }

 private:
  std::filesystem::path file_;
  Writer writer_;
};

class VtkSink : public Sink {
 public:
  VtkSink(const std::filesystem::path& folder, const Scene& scene)
      : writer_(folder, scene.network, scene.output),
        interval_(scene.output.vtk_interval),
        // As small as this is rounding.
        slack_(1e-6 * std::min(scene.options.time_step, scene.duration)) {}

  void record(const Simulation& simulation) override {
    if (simulation.time() >= next_ - slack_) take(simulation);
  }
  void finish(const Simulation& simulation) override {
    if (simulation.time() > last_) take(simulation);
  }
  void close() override { writer_.close(); }
  [[nodiscard]] std::uintmax_t bytes() const override { return writer_.bytes(); }

 private:
  void take(const Simulation& simulation) {
    writer_.record(simulation);
    last_ = simulation.time();
    if (interval_ > 0.0) next_ = interval_ * (std::floor((simulation.time() + slack_) / interval_) + 1.0);
  }

  VtkWriter writer_;
  double interval_, slack_;                                 // s
  double next_ = 0.0;                                       // s
  double last_ = -std::numeric_limits<double>::infinity();  // s, of the last picture
};

class ViewSink : public Sink {
 public:
  ViewSink(const std::filesystem::path& file, const Scene& scene, const std::shared_ptr<const PluginHost>& plugins)
      : file_(file), writer_(file, scene, ViewOptions{scene.output.view_size, plugins}) {}

  void record(const Simulation& simulation) override { writer_.record(simulation); }
  void close() override { writer_.close(); }
  [[nodiscard]] std::uintmax_t bytes() const override { return size_of(file_); }
  void failed(const std::string& reason) override { writer_.failed(reason); }
  [[nodiscard]] std::vector<std::string> notes() const override {
    std::vector<std::string> notes = writer_.left_out();
    for (std::string& note : notes) note = fmt::format("{}: {}", view_file, note);
    return notes;
  }

 private:
  std::filesystem::path file_;
  ViewWriter writer_;
};

// Files of an earlier run would be taken for those of this one.
void clear(const std::filesystem::path& folder) {
  std::error_code ignored;
  for (const std::filesystem::path& file : earlier_files(folder)) std::filesystem::remove(file, ignored);
  if (std::filesystem::is_directory(folder / vtk_folder, ignored)) {
    std::filesystem::remove(folder / vtk_folder, ignored);  // if nothing is left in it
  }
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed || !std::filesystem::is_directory(folder)) {
    throw Error(ErrorKind::input, fmt::format("{}: the folder for the output cannot be made: {}; name another one",
                                              folder.string(), failed ? failed.message() : "a file is in the way"));
  }
}

}  // namespace

std::vector<std::filesystem::path> earlier_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files = vtk_series_files(folder / vtk_folder);
  const auto add = [&](const std::string& name) {
    std::error_code unreadable;
    const auto status = std::filesystem::symlink_status(folder / name, unreadable);
    if (std::filesystem::exists(status)) files.push_back(folder / name);
  };
  for (const char* name : {"trajectory", "reactions", "surfaces", "rigid", "springs", "elements", "events"}) {
    for (const char* ending : {".csv", ".bin"}) add(std::string(name) + ending);
  }
  add(view_file);
  add(summary_file);
  return files;
}

std::uintmax_t earlier_bytes(const std::filesystem::path& folder) {
  std::uintmax_t sum = 0;
  for (const std::filesystem::path& file : earlier_files(folder)) {
    std::error_code unreadable;
    if (!std::filesystem::is_symlink(file, unreadable)) sum += size_of(file);  // what it names is not removed
  }
  return sum;
}

Recorder::Recorder(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                   const std::filesystem::path& folder) {
  make_folder(folder);
  clear(folder);
  const Network& network = scene.network;
  const OutputOptions& options = scene.output;
  const auto table = [&]<class Writer>(const std::string& name, const auto&... arguments) {
    add(name, std::make_unique<FileSink<Writer>>(folder / name, arguments...));
  };
  table.operator()<EventWriter>("events.csv");
  if (options.trajectory) table.operator()<TrajectoryWriter>(table_name("trajectory", options), network, options);
  if (options.reactions) table.operator()<ReactionWriter>("reactions.csv", network, options);
  if (options.surfaces && network.planes().size() + network.instruments().size() > 0) {
    table.operator()<SurfaceWriter>("surfaces.csv");
  }
  if (options.rigid && !network.rigids().empty()) table.operator()<RigidWriter>("rigid.csv", network);
  if (!options.springs.empty()) table.operator()<SpringWriter>(table_name("springs", options), network, options);
  if (options.elements && !network.elements().empty()) {
    table.operator()<ElementWriter>(table_name("elements", options), network, options);
  }
  if (options.view) add(view_file, std::make_unique<ViewSink>(folder / view_file, scene, plugins));
  if (options.vtk) add(vtk_index_name(), std::make_unique<VtkSink>(folder / vtk_folder, scene));
}

void Recorder::add(std::string file, std::unique_ptr<Sink> sink) {
  files_.push_back(std::move(file));
  sinks_.push_back(std::move(sink));
}

void Recorder::record(const Simulation& simulation) {
  for (const auto& sink : sinks_) sink->record(simulation);
}

void Recorder::finish(const Simulation& simulation) {
  for (const auto& sink : sinks_) sink->finish(simulation);
}

void Recorder::failed(const std::string& reason) {
  for (const auto& sink : sinks_) sink->failed(reason);
}

std::vector<std::string> Recorder::notes() const {
  std::vector<std::string> all;
  for (const auto& sink : sinks_) {
    const std::vector<std::string> notes = sink->notes();
    all.insert(all.end(), notes.begin(), notes.end());
  }
  return all;
}

void Recorder::close() {
  std::exception_ptr first;
  for (const auto& sink : sinks_) {
    try {
      sink->close();
    } catch (const Error&) {
      if (!first) first = std::current_exception();
    }
  }
  if (first) std::rethrow_exception(first);
}

std::uintmax_t Recorder::bytes() const {
  std::uintmax_t sum = 0;
  for (const auto& sink : sinks_) sum += sink->bytes();
  return sum;
}

}  // namespace springnet
