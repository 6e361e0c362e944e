// All files that a run writes beside its summary.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <springnet/output.hpp>
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
  [[nodiscard]] virtual std::uintmax_t bytes() const = 0;       // written, once closed
  [[nodiscard]] virtual bool is_there() const { return true; }  // once closed; not what could not be written at all
  // The run failed. For those that tell their reader how it went.
  virtual void failed(const std::string& /*reason*/) {}
  // What was left out, in sentences, once closed.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
};

class Recorder {
 public:
  // Removes what an earlier run has left in the folder, and makes the files that the scene asks for. Throws
  // Error(input) if a file cannot be made.
  Recorder(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, OutputFolder::Pointer folder);

  // Into every file, also where one fails; that one ends there and takes no more. Throws what the first one has thrown
  // that fails at this record.
  void record(const Simulation& simulation);
  void finish(const Simulation& simulation);  // after the last record
  void failed(const std::string& reason);
  // Closes every file, then throws what the first one that failed has thrown.
  void close();

  // Once closed: names in the folder of the files that are there, those that end early, bytes of all.
  [[nodiscard]] std::vector<std::string> files() const;
  [[nodiscard]] std::vector<CutShort> cut_short() const;
  [[nodiscard]] std::uintmax_t bytes() const;
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  struct Output {
    std::string file;
    std::unique_ptr<Sink> sink;
    double kept_until = std::numeric_limits<double>::quiet_NaN();  // s
    bool failed = false;
    bool lost = false;
  };
  void add(std::string file, std::unique_ptr<Sink> sink);
  // On every file that has not failed.
  template <class Work>
  void each(const Work& work);

  OutputFolder::Pointer folder_;
  std::vector<Output> outputs_;
};

// Bytes of what an earlier run has left in the folder and the next one removes.
[[nodiscard]] std::uintmax_t earlier_bytes(const std::filesystem::path& folder);

inline constexpr const char* view_file = "view.html";
inline constexpr const char* summary_file = "summary.json";

}  // namespace springnet
