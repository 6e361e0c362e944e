// What a run may write beside its summary: each of the tables, the page, the pictures. Whatever treats them alike
// (making, recording, estimating, removing an earlier run's, finding room) goes through this list.
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

namespace springnet {

// An open output, which takes every record of a run.
class Sink {
 public:
  // `file`: name in the folder of the file that stands for it in the summary.
  explicit Sink(std::string file) : file_(std::move(file)) {}
  virtual ~Sink() = default;

  [[nodiscard]] const std::string& file() const noexcept { return file_; }

  virtual void record(const Record& record) = 0;
  // The state at which the run ends, however it ends; it has been recorded. For those that skip records.
  virtual void finish(const Record&) {}
  virtual void close() = 0;
  // The run failed, before close(). For those that tell their reader.
  virtual void failed(const std::string& /*reason*/) {}

  // Once closed.
  [[nodiscard]] virtual std::uintmax_t bytes() const = 0;
  [[nodiscard]] virtual bool is_there() const { return true; }  // false if it could not be written at all
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }  // what it leaves out, in sentences

 private:
  std::string file_;
};

class Output {
 public:
  virtual ~Output() = default;

  [[nodiscard]] virtual bool wanted(const Scene& scene) const = 0;
  [[nodiscard]] virtual std::unique_ptr<Sink> open(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                                                   const OutputFolder::Pointer& folder) const = 0;

  // Of a run with so many records; nothing where there is no telling.
  [[nodiscard]] virtual std::optional<FileEstimate> estimate(const Scene& scene, double records) const = 0;
  // How to do without it, and how to have less of it where there is a way (else empty): what a refusal for want of
  // space offers.
  [[nodiscard]] virtual std::string leave_out(const Scene& scene) const = 0;
  [[nodiscard]] virtual std::string smaller() const { return ""; }

  // Names of the files that it writes into the folder itself.
  [[nodiscard]] virtual std::vector<std::string> file_names() const = 0;
  // Calls `visit` for what an earlier run has left: files and links with the names that it gives.
  using Visit = std::function<void(const OutputFolder& folder, const std::string& name)>;
  virtual void for_earlier(const OutputFolder::Pointer& folder, const Visit& visit) const;
  // Removes that.
  virtual void clear(const OutputFolder::Pointer& folder) const;
};

// In the order in which a run makes them.
[[nodiscard]] const std::vector<std::unique_ptr<const Output>>& outputs();

inline constexpr const char* summary_file = "summary.json";

// Bytes of what an earlier run has left in the folder and the next one removes.
[[nodiscard]] std::uintmax_t earlier_bytes(const std::filesystem::path& folder);
// Removes it, so that it is not taken for a part of the next run. Throws Error(input), before anything is removed, if a
// folder has the name of a file that a run writes.
void remove_earlier(const OutputFolder::Pointer& folder);

struct OutputSize {
  const Output* output;
  FileEstimate file;
};
// Of those outputs that the scene asks for and that can be estimated.
[[nodiscard]] std::vector<OutputSize> output_sizes(const Scene& scene);

}  // namespace springnet
