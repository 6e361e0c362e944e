#include "run/recorder.hpp"

#include <cmath>
#include <exception>
#include <limits>

#include <fmt/format.h>
#include <springnet/output.hpp>
#include <springnet/view.hpp>

#include "files/output_error.hpp"
#include "tables/table_file.hpp"
#include "vtk/vtk_series.hpp"

namespace springnet {

namespace {

// A writer of one file.
template <class Writer>
class FileSink : public Sink {
 public:
  template <class... Arguments>
  explicit FileSink(const OutputFile& file, const Arguments&... arguments) : file_(file), writer_(file, arguments...) {}

  void record(const Simulation& simulation) override { writer_.record(simulation); }
  void close() override { writer_.close(); }
  [[nodiscard]] std::uintmax_t bytes() const override { return file_.folder()->size(file_.name()); }

 private:
  OutputFile file_;
  Writer writer_;
};

class VtkSink : public Sink {
 public:
  VtkSink(const OutputFile& folder, const Scene& scene)
      : folder_(folder),
        writer_(folder, scene.network, scene.output),
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
  [[nodiscard]] bool is_there() const override {
    return OutputFolder::find_inside(folder_.folder(), folder_.name()) != nullptr;
  }

 private:
  void take(const Simulation& simulation) {
    writer_.record(simulation);
    last_ = simulation.time();
    if (interval_ > 0.0) next_ = interval_ * (std::floor((simulation.time() + slack_) / interval_) + 1.0);
  }

  OutputFile folder_;
  VtkWriter writer_;
  double interval_, slack_;                                 // s
  double next_ = 0.0;                                       // s
  double last_ = -std::numeric_limits<double>::infinity();  // s, of the last picture
};

class ViewSink : public Sink {
 public:
  ViewSink(const OutputFile& file, const Scene& scene, const std::shared_ptr<const PluginHost>& plugins)
      : file_(file), writer_(file, scene, ViewOptions{scene.output.view_size, plugins}) {}

  void record(const Simulation& simulation) override { writer_.record(simulation); }
  void close() override { writer_.close(); }
  [[nodiscard]] std::uintmax_t bytes() const override { return file_.folder()->size(file_.name()); }
  [[nodiscard]] bool is_there() const override {
    return file_.folder()->kind(file_.name()) != OutputFolder::Kind::none;
  }
  void failed(const std::string& reason) override { writer_.failed(reason); }
  [[nodiscard]] std::vector<std::string> notes() const override {
    std::vector<std::string> notes = writer_.left_out();
    for (std::string& note : notes) note = fmt::format("{}: {}", view_file, note);
    return notes;
  }

 private:
  OutputFile file_;
  ViewWriter writer_;
};

std::vector<std::string> file_names() {
  std::vector<std::string> names;
  for (const char* name : {"trajectory", "reactions", "surfaces", "rigid", "springs", "elements", "events"}) {
    for (const char* ending : {".csv", ".bin"}) names.push_back(std::string(name) + ending);
  }
  for (const char* name : {view_file, summary_file}) {
    names.emplace_back(name);
    names.push_back(part_name(name));
  }
  return names;
}

// Calls `file(folder, name)` for what an earlier run has left: regular files and links with the names that a run gives.
template <class Work>
void for_earlier(const OutputFolder::Pointer& folder, const Work& file) {
  const auto take = [&](const OutputFolder& in, const std::string& name) {
    const OutputFolder::Kind kind = in.kind(name);
    if (kind == OutputFolder::Kind::file || kind == OutputFolder::Kind::link) file(in, name);
  };
  for (const std::string& name : file_names()) take(*folder, name);
  if (folder->kind(vtk_folder) == OutputFolder::Kind::link) file(*folder, vtk_folder);
  if (const OutputFolder::Pointer vtk = OutputFolder::find_inside(folder, vtk_folder)) {
    for (const std::string& name : vtk_series_files(*vtk)) take(*vtk, name);
  }
}

// Files of an earlier run would be taken for those of this one.
void clear(const OutputFolder::Pointer& folder) {
  for_earlier(folder, [](const OutputFolder& in, const std::string& name) { in.remove(name); });
  folder->remove_empty_folder(vtk_folder);
}

}  // namespace

std::uintmax_t earlier_bytes(const std::filesystem::path& path) {
  std::uintmax_t sum = 0;
  const OutputFolder::Pointer folder = OutputFolder::find(path);
  if (!folder) return sum;
  for_earlier(folder, [&](const OutputFolder& in, const std::string& name) { sum += in.size(name); });
  return sum;
}

Recorder::Recorder(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, OutputFolder::Pointer folder)
    : folder_(std::move(folder)) {
  for (const std::string& name : file_names()) folder_->require_no_folder(name);  // before anything is removed
  clear(folder_);
  const Network& network = scene.network;
  const OutputOptions& options = scene.output;
  const auto table = [&]<class Writer>(const std::string& name, const auto&... arguments) {
    add(name, std::make_unique<FileSink<Writer>>(OutputFile(folder_, name), arguments...));
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
  if (options.view) add(view_file, std::make_unique<ViewSink>(OutputFile(folder_, view_file), scene, plugins));
  if (options.vtk) add(vtk_index_name(), std::make_unique<VtkSink>(OutputFile(folder_, vtk_folder), scene));
}

void Recorder::add(std::string file, std::unique_ptr<Sink> sink) {
  outputs_.push_back({std::move(file), std::move(sink)});
}

template <class Work>
void Recorder::each(const Work& work) {
  std::exception_ptr first;
  for (Output& output : outputs_) {
    if (output.failed) continue;
    try {
      work(output);
    } catch (const OutputError& error) {
      output.failed = true;
      output.lost = error.lost();
      output.kept_until = error.kept_until();
      if (!first) first = std::current_exception();
    } catch (...) {  // out of memory, for instance
      output.failed = true;
      if (!first) first = std::current_exception();
    }
  }
  if (first) std::rethrow_exception(first);
}

void Recorder::record(const Simulation& simulation) {
  each([&](Output& output) {
    output.sink->record(simulation);
    output.kept_until = simulation.time();
  });
}

void Recorder::finish(const Simulation& simulation) {
  each([&](Output& output) { output.sink->finish(simulation); });
}

void Recorder::failed(const std::string& reason) {
  for (const Output& output : outputs_) output.sink->failed(reason);
}

std::vector<std::string> Recorder::notes() const {
  std::vector<std::string> all;
  for (const Output& output : outputs_) {
    const std::vector<std::string> notes = output.sink->notes();
    all.insert(all.end(), notes.begin(), notes.end());
  }
  return all;
}

void Recorder::close() {
  // One that has failed as well: its buffers are written as far as they are whole.
  for (const Output& output : outputs_) {
    if (!output.failed) continue;
    try {
      output.sink->close();
    } catch (...) {  // its first failure has been told
    }
  }
  each([](Output& output) { output.sink->close(); });
}

std::vector<std::string> Recorder::files() const {
  std::vector<std::string> names;
  for (const Output& output : outputs_) {
    if (!output.lost && output.sink->is_there()) names.push_back(output.file);
  }
  return names;
}

std::vector<CutShort> Recorder::cut_short() const {
  std::vector<CutShort> files;
  for (const Output& output : outputs_) {
    if (output.failed && !output.lost && output.sink->is_there()) files.push_back({output.file, output.kept_until});
  }
  return files;
}

std::uintmax_t Recorder::bytes() const {
  std::uintmax_t sum = 0;
  for (const Output& output : outputs_) sum += output.sink->bytes();
  return sum;
}

}  // namespace springnet
