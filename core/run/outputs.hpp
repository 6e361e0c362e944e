// What a run may write besides its summary: each of the tables, the page, the pictures. Creating, recording,
// estimating, cleaning up after an earlier run and refusing for lack of space all go through this list.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <springnet/output_folder.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>
#include <springnet/tables.hpp>

#include "record/record.hpp"
#include "text/archive.hpp"

namespace springnet {

// An open output, which takes every record of a run.
class Sink {
 public:
  // `file`: name of the file that the summary lists for it.
  explicit Sink(std::string file) : file_(std::move(file)) {}
  virtual ~Sink() = default;

  [[nodiscard]] const std::string& file() const noexcept { return file_; }

  // How far it is, with all records in its files; or, of one that was opened to resume, finds its files, in which
  // nothing changes yet. Throws Error(input) if they are not there, or shorter.
  virtual void archive(Archive& archive) = 0;
  // Of one that was opened to resume: what its files have beyond is cut off, and records follow.
  virtual void go_on() = 0;

  virtual void record(const Record& record) = 0;
  // Called with the last record, which has been recorded, however the run ends. For sinks that skip records.
  virtual void finish(const Record&) {}
  virtual void close() = 0;
  // Called before close() if the run failed. For sinks that show the reason.
  virtual void failed(const std::string& /*reason*/) {}

  // Once closed.
  [[nodiscard]] virtual std::uintmax_t bytes() const = 0;
  [[nodiscard]] virtual bool exists() const { return true; }  // false if it could not be written at all
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }  // what it leaves out, in sentences

 private:
  std::string file_;
};

class Output {
 public:
  virtual ~Output() = default;

  [[nodiscard]] virtual bool wanted(const Scene& scene) const = 0;
  // resumes: Sink::archive() opens the files, which are those of an earlier run.
  [[nodiscard]] virtual std::unique_ptr<Sink> open(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                                                   const OutputFolder::Pointer& folder, bool resumes) const = 0;

  // For a run with this many records; empty if the size depends on events.
  [[nodiscard]] virtual std::optional<FileEstimate> estimate(const Scene& scene, double records) const = 0;
  // Remedies for lack of space: how to leave it out, and how to make it smaller (empty if it cannot be).
  [[nodiscard]] virtual std::string leave_out_hint(const Scene& scene) const = 0;
  [[nodiscard]] virtual std::string shrink_hint() const { return ""; }

  // Name of the file that it writes under these options, and what is in it that a resumed run has to go on with.
  [[nodiscard]] virtual std::pair<std::string, std::string> form(const Scene& scene) const = 0;
  // Every name that its files in the folder itself can have.
  [[nodiscard]] virtual std::vector<std::string> file_names() const = 0;
  // Calls `visit` for each file or link of an earlier run, that is one with a name that this output uses.
  using Visit = std::function<void(const OutputFolder& folder, const std::string& name)>;
  virtual void visit_earlier(const OutputFolder::Pointer& folder, const Visit& visit) const;
  // Removes them.
  virtual void clear(const OutputFolder::Pointer& folder) const;
};

// In the order in which a run makes them.
[[nodiscard]] const std::vector<std::unique_ptr<const Output>>& outputs();

inline constexpr const char* summary_file = "summary.json";
inline constexpr const char* profile_file = "profile.json";
inline constexpr const char* trace_file = "trace.json";
inline constexpr const char* checkpoint_file = "checkpoint";

// Bytes of an earlier run's files in the folder, which the next one removes.
[[nodiscard]] std::uintmax_t earlier_bytes(const std::filesystem::path& folder);
// Removes them, so that nobody takes them for part of the next run. Throws Error(input), before anything is removed, if
// a folder has the name of a file that a run writes.
void remove_earlier(const OutputFolder::Pointer& folder);
// The reports of a run, which one that resumes it writes anew.
void remove_reports(const OutputFolder::Pointer& folder);

struct OutputSize {
  const Output* output;
  FileEstimate file;
};
// Of the outputs that the scene requests and whose size can be estimated.
[[nodiscard]] std::vector<OutputSize> output_sizes(const Scene& scene);

}  // namespace springnet
