// The files of one run, besides its summary: every record goes into each of them.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <springnet/run.hpp>

#include "run/outputs.hpp"

namespace springnet {

class Recorder {
 public:
  // Removes the files of an earlier run and creates those that the scene requests. Throws Error(input) if one cannot be
  // created. resumes: archive() opens those of an earlier run instead.
  Recorder(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const OutputFolder::Pointer& folder,
           bool resumes = false);
  // How far each of them is, between two records; or goes on from there.
  void archive(Archive& archive);
  // Of one that resumes, once all is there: see Sink.
  void go_on();

  // Writes the record to every file. A file that fails ends with its last complete record; the others go on. Then
  // throws the first error of this record.
  void record(const Record& record);
  void finish(const Record& record);  // after the last record
  void failed(const std::string& reason);
  // Closes every file, then throws the first error.
  void close();

  // Once closed: names of the existing files, those that end early, bytes of all.
  [[nodiscard]] std::vector<std::string> files() const;
  [[nodiscard]] std::vector<CutShort> cut_short() const;
  [[nodiscard]] std::uintmax_t bytes() const;
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  struct Entry {
    std::unique_ptr<Sink> sink;
    double kept_until = std::numeric_limits<double>::quiet_NaN();  // s
    bool failed = false;
    bool lost = false;
  };
  // Calls `work` for every file that has not failed.
  template <class Work>
  void each(const Work& work);

  std::vector<Entry> entries_;
};

}  // namespace springnet
