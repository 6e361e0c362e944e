// The series of pictures that a run writes for ParaView, and its size.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <springnet/scene.hpp>

#include "files/checked_file.hpp"
#include "record/record.hpp"
#include "vtk/vtk_data.hpp"

namespace springnet {

inline constexpr const char* vtk_folder = "vtk";
[[nodiscard]] std::string vtk_index_name();  // run.pvd in that folder

// Names of the files in the folder that belong to an earlier series.
[[nodiscard]] std::vector<std::string> vtk_series_files(const OutputFolder& folder);

// Bytes of one record; an upper bound for the bytes of the index.
[[nodiscard]] double vtk_record_bytes(const Network& network, const OutputOptions& options);
[[nodiscard]] double vtk_index_bytes(const Network& network, double records);

class VtkSeries {
 public:
  // resumes: archive() opens the files of an earlier run in place of new ones.
  VtkSeries(const OutputFile& folder, const Network& network, const OutputOptions& options, bool resumes = false);
  // How far it is, between two pictures; or finds the files, in which nothing changes before go_on(): then those of
  // pictures that came later are removed.
  void archive(Archive& archive);
  void go_on();
  // Throws OutputError if a picture cannot be written; the series then ends with the one before.
  void record(const Record& record);
  void close() { index_->close(); }
  [[nodiscard]] std::uintmax_t bytes() const noexcept { return bytes_; }

 private:
  void write_pictures(const Record& record);
  void drop_last();

  OutputFolder::Pointer folder_;
  OutputOptions::Precision precision_;
  VtkNet net_;
  VtkSurfaces surfaces_;
  std::optional<CheckedFile> index_;  // none until it is opened
  std::uint64_t index_end_ = 0;       // where the next entry goes
  std::uintmax_t bytes_ = 0;
  std::size_t records_ = 0;
  double last_ = std::numeric_limits<double>::quiet_NaN();  // s, of the last picture
};

}  // namespace springnet
