// All files that a run writes beside its summary.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// Something that each record goes into.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void record(const Simulation& simulation) = 0;
  // The run ends here, whatever ends it; the last record has been made. For those that leave out records.
  virtual void finish(const Simulation&) {}
  virtual void close() = 0;
  [[nodiscard]] virtual std::uintmax_t bytes() const = 0;  // written, once closed
  // The run failed. For those that tell their reader how it went.
  virtual void failed(const std::string& /*reason*/) {}
  // What was left out, in sentences, once closed.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
};

class Recorder {
 public:
  // Removes what an earlier run has left in the folder, and makes the files that the scene asks for. Throws
  // Error(input) if the folder or a file cannot be made.
  Recorder(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const std::filesystem::path& folder);

  void record(const Simulation& simulation);
  void finish(const Simulation& simulation);  // after the last record
  void failed(const std::string& reason);
  // Closes every file, then throws what the first one that failed has thrown.
  void close();

  [[nodiscard]] const std::vector<std::string>& files() const noexcept { return files_; }  // names in the folder
  [[nodiscard]] std::uintmax_t bytes() const;                                              // of these
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  void add(std::string file, std::unique_ptr<Sink> sink);

  std::vector<std::string> files_;
  std::vector<std::unique_ptr<Sink>> sinks_;
};

// What an earlier run has left in the folder and the next one removes.
[[nodiscard]] std::vector<std::filesystem::path> earlier_files(const std::filesystem::path& folder);
[[nodiscard]] std::uintmax_t earlier_bytes(const std::filesystem::path& folder);

inline constexpr const char* view_file = "view.html";
inline constexpr const char* summary_file = "summary.json";

}  // namespace springnet
