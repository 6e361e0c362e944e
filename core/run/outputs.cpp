#include "run/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <springnet/view.hpp>

#include "run/record_times.hpp"
#include "tables/table.hpp"
#include "view/page_writer.hpp"
#include "vtk/vtk_series.hpp"

namespace springnet {

namespace {

class TableSink : public Sink {
 public:
  TableSink(const tables::Table& table, const OutputFile& file, const Scene& scene, bool resumes)
      : Sink(file.name()),
        table_(table),
        options_(scene.output),
        path_(file),
        file_(resumes ? nullptr : tables::create(table, file, scene.network, scene.output)),
        rows_(table.writer(scene.network, scene.output)) {}

  void archive(Archive& archive) override {
    CheckedFile::End end;
    if (!archive.reads()) end = file_->flushed_end();
    end.archive(archive);
    rows_.archive(archive);
    if (archive.reads()) file_ = tables::reopen(table_, path_, options_, end);
  }
  void go_on() override { file_->go_on(); }

  void record(const Record& record) override {
    file_->begin_record(record.time());
    rows_(record, *file_);
    file_->end_record();
  }
  void close() override {
    if (file_) file_->close();
  }
  [[nodiscard]] std::uintmax_t bytes() const override { return path_.folder()->size(path_.name()); }

 private:
  const tables::Table& table_;
  const OutputOptions& options_;
  OutputFile path_;
  std::unique_ptr<TableFile> file_;  // null: to be resumed
  tables::RowWriter rows_;
};

class TableOutput : public Output {
 public:
  explicit TableOutput(const tables::Table& table) : table_(table) {}

  [[nodiscard]] bool wanted(const Scene& scene) const override { return table_.wanted(scene.network, scene.output); }
  [[nodiscard]] std::unique_ptr<Sink> open(const Scene& scene, const std::shared_ptr<const PluginHost>&,
                                           const OutputFolder::Pointer& folder, bool resumes) const override {
    const std::string name = tables::file_name(table_, scene.output);
    // A new file replaces what has its name, a resumed one does not.
    return std::make_unique<TableSink>(table_, OutputFile(folder, name), scene, resumes);
  }
  [[nodiscard]] std::optional<FileEstimate> estimate(const Scene& scene, double records) const override {
    return tables::estimate(table_, scene.network, scene.output, records);
  }
  [[nodiscard]] std::string leave_out_hint(const Scene& scene) const override {
    return fmt::format(fmt::runtime(table_.leave_out_hint), tables::file_name(table_, scene.output));
  }
  [[nodiscard]] std::string shrink_hint() const override { return std::string(table_.shrink_hint); }
  [[nodiscard]] std::pair<std::string, std::string> form(const Scene& scene) const override {
    return {tables::file_name(table_, scene.output), csv_header(tables::form_of(table_, scene.network, scene.output))};
  }
  [[nodiscard]] std::vector<std::string> file_names() const override { return tables::file_names(table_); }

 private:
  const tables::Table& table_;
};

constexpr const char* view_file = "view.html";

class PageSink : public Sink {
 public:
  PageSink(const OutputFile& file, const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, bool resumes)
      : Sink(file.name()), path_(file), page_(file, scene, ViewOptions{scene.output.view_size, plugins}, resumes) {}

  void archive(Archive& archive) override { page_.archive(archive); }
  void go_on() override { page_.go_on(); }
  void record(const Record& record) override { page_.record(record); }
  void close() override { page_.close(); }
  void failed(const std::string& reason) override { page_.failed(reason); }
  [[nodiscard]] std::uintmax_t bytes() const override { return path_.folder()->size(path_.name()); }
  [[nodiscard]] bool exists() const override { return path_.folder()->kind(path_.name()) != OutputFolder::Kind::none; }
  [[nodiscard]] std::vector<std::string> notes() const override {
    std::vector<std::string> notes = page_.left_out();
    for (std::string& note : notes) note = fmt::format("{}: {}", file(), note);
    return notes;
  }

 private:
  OutputFile path_;
  view::PageWriter page_;
};

class PageOutput : public Output {
 public:
  [[nodiscard]] bool wanted(const Scene& scene) const override { return scene.output.view; }
  [[nodiscard]] std::unique_ptr<Sink> open(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                                           const OutputFolder::Pointer& folder, bool resumes) const override {
    return std::make_unique<PageSink>(OutputFile(folder, view_file), scene, plugins, resumes);
  }
  [[nodiscard]] std::optional<FileEstimate> estimate(const Scene& scene, double) const override {
    return FileEstimate{view_file, estimate_view(scene), false};
  }
  [[nodiscard]] std::string leave_out_hint(const Scene&) const override {
    return fmt::format("leave out {} (output.view = false)", view_file);
  }
  [[nodiscard]] std::string shrink_hint() const override { return "make the page smaller (output.view_size)"; }
  [[nodiscard]] std::pair<std::string, std::string> form(const Scene&) const override { return {view_file, ""}; }
  [[nodiscard]] std::vector<std::string> file_names() const override { return {view_file, part_name(view_file)}; }
};

// Writes records at an interval of its own, and the last one.
class VtkSink : public Sink {
 public:
  VtkSink(const OutputFile& folder, const Scene& scene, bool resumes)
      : Sink(vtk_index_name()),
        folder_(folder),
        series_(folder, scene.network, scene.output, resumes),
        interval_(scene.output.vtk_interval),
        slack_(time_slack(scene.options.time_step, scene.duration)) {}

  void archive(Archive& archive) override {
    archive.number(next_);
    archive.number(last_);
    series_.archive(archive);
  }
  void go_on() override { series_.go_on(); }
  void record(const Record& record) override {
    if (record.time() >= next_ - slack_) take(record);
  }
  void finish(const Record& record) override {
    if (record.time() > last_) take(record);
  }
  void close() override { series_.close(); }
  [[nodiscard]] std::uintmax_t bytes() const override { return series_.bytes(); }
  [[nodiscard]] bool exists() const override {
    return OutputFolder::find_inside(folder_.folder(), folder_.name()) != nullptr;
  }

 private:
  void take(const Record& record) {
    series_.record(record);
    last_ = record.time();
    if (interval_ > 0.0) next_ = next_multiple(interval_, record.time(), slack_);
  }

  OutputFile folder_;
  VtkSeries series_;
  double interval_, slack_;                                 // s
  double next_ = 0.0;                                       // s
  double last_ = -std::numeric_limits<double>::infinity();  // s, of the last picture
};

class VtkOutput : public Output {
 public:
  [[nodiscard]] bool wanted(const Scene& scene) const override { return scene.output.vtk; }
  [[nodiscard]] std::unique_ptr<Sink> open(const Scene& scene, const std::shared_ptr<const PluginHost>&,
                                           const OutputFolder::Pointer& folder, bool resumes) const override {
    return std::make_unique<VtkSink>(OutputFile(folder, vtk_folder), scene, resumes);
  }
  [[nodiscard]] std::optional<FileEstimate> estimate(const Scene& scene, double records) const override {
    const OutputOptions& options = scene.output;
    const double interval = std::max({options.vtk_interval, options.interval, scene.options.time_step});
    const double pictures = std::min(records, count_records(scene.duration, interval));
    return FileEstimate{
        name(), pictures * vtk_record_bytes(scene.network, options) + vtk_index_bytes(scene.network, pictures), false};
  }
  [[nodiscard]] std::string leave_out_hint(const Scene&) const override {
    return fmt::format("leave out {} (output.vtk = false)", name());
  }
  [[nodiscard]] std::string shrink_hint() const override { return "make fewer pictures (output.vtk_interval)"; }
  [[nodiscard]] std::pair<std::string, std::string> form(const Scene&) const override { return {vtk_index_name(), ""}; }
  [[nodiscard]] std::vector<std::string> file_names() const override { return {}; }
  void visit_earlier(const OutputFolder::Pointer& folder, const Visit& visit) const override;
  void clear(const OutputFolder::Pointer& folder) const override {
    Output::clear(folder);
    folder->remove_empty_folder(vtk_folder);
  }

 private:
  static std::string name() { return std::string(vtk_folder) + "/"; }
};

void visit_file(const OutputFolder& folder, const std::string& name, const Output::Visit& visit) {
  const OutputFolder::Kind kind = folder.kind(name);
  if (kind == OutputFolder::Kind::file || kind == OutputFolder::Kind::link) visit(folder, name);
}

void VtkOutput::visit_earlier(const OutputFolder::Pointer& folder, const Visit& visit) const {
  if (folder->kind(vtk_folder) == OutputFolder::Kind::link) visit(*folder, vtk_folder);
  if (const OutputFolder::Pointer series = OutputFolder::find_inside(folder, vtk_folder)) {
    for (const std::string& name : vtk_series_files(*series)) visit_file(*series, name, visit);
  }
}

// Of files about the run itself, which are written when it has ended.
std::vector<std::string> report_names() {
  std::vector<std::string> names;
  for (const char* file : {summary_file, profile_file, trace_file}) {
    names.emplace_back(file);
    names.push_back(part_name(file));
  }
  return names;
}

}  // namespace

void Output::visit_earlier(const OutputFolder::Pointer& folder, const Visit& visit) const {
  for (const std::string& name : file_names()) visit_file(*folder, name, visit);
}

void Output::clear(const OutputFolder::Pointer& folder) const {
  visit_earlier(folder, [](const OutputFolder& in, const std::string& name) { in.remove(name); });
}

const std::vector<std::unique_ptr<const Output>>& outputs() {
  static const std::vector<std::unique_ptr<const Output>> list = [] {
    std::vector<std::unique_ptr<const Output>> made;
    for (const tables::Table& table : tables::all()) made.push_back(std::make_unique<const TableOutput>(table));
    made.push_back(std::make_unique<const PageOutput>());
    made.push_back(std::make_unique<const VtkOutput>());
    return made;
  }();
  return list;
}

std::uintmax_t earlier_bytes(const std::filesystem::path& path) {
  std::uintmax_t sum = 0;
  const OutputFolder::Pointer folder = OutputFolder::find(path);
  if (!folder) return sum;
  const auto add = [&](const OutputFolder& in, const std::string& name) { sum += in.size(name); };
  for (const auto& output : outputs()) output->visit_earlier(folder, add);
  for (const std::string& name : report_names()) visit_file(*folder, name, add);
  visit_file(*folder, checkpoint_file, add);
  return sum;
}

void remove_earlier(const OutputFolder::Pointer& folder) {
  for (const auto& output : outputs()) {
    for (const std::string& name : output->file_names()) folder->require_no_folder(name);
  }
  for (const std::string& name : report_names()) folder->require_no_folder(name);
  folder->require_no_folder(checkpoint_file);
  for (const auto& output : outputs()) output->clear(folder);
  remove_reports(folder);
  for (const std::string& name : {std::string(checkpoint_file), part_name(checkpoint_file)}) folder->remove(name);
}

void remove_reports(const OutputFolder::Pointer& folder) {
  for (const std::string& name : report_names()) {
    visit_file(*folder, name, [](const OutputFolder& in, const std::string& file) { in.remove(file); });
  }
}

std::vector<OutputSize> output_sizes(const Scene& scene) {
  const double records = count_records(scene.duration, record_interval(scene));
  std::vector<OutputSize> sizes;
  for (const auto& output : outputs()) {
    if (!output->wanted(scene)) continue;
    if (std::optional<FileEstimate> file = output->estimate(scene, records)) sizes.push_back({output.get(), *file});
  }
  return sizes;
}

}  // namespace springnet
