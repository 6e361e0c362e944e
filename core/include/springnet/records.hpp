// Reading the binary tables of a run (output.format = "binary"): the same rows of numbers at many times.
// core/docs/output.md has the layout, which suits programs that map files into memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/output_folder.hpp>

namespace springnet {

// Reads a table up to its last complete record, also that of a run that failed or is still in progress.
class SPRINGNET_API RecordReader {
 public:
  // Throws Error(input) if the file cannot be read, is not such a table, or has no complete record yet.
  explicit RecordReader(const std::filesystem::path& file);

  [[nodiscard]] const std::string& row_name() const noexcept { return row_; }  // "node", "spring", "element"
  [[nodiscard]] const std::vector<std::uint32_t>& rows() const noexcept { return numbers_; }  // the scene's numbers
  [[nodiscard]] const std::vector<std::string>& columns() const noexcept { return columns_; }
  [[nodiscard]] const std::vector<std::string>& units() const noexcept { return units_; }
  [[nodiscard]] bool single_precision() const noexcept { return single_; }
  [[nodiscard]] std::size_t records() const noexcept { return records_; }

  // Replaces `values` by the [row][column] of a record and returns its time, s. Throws Error(input) if there is no such
  // record or the file can no longer be read.
  double read(std::size_t record, std::vector<double>& values);

 private:
  void describe(const std::string& header, std::size_t bytes);
  [[noreturn]] void refuse(const std::string& reason) const;

  std::filesystem::path path_;
  std::ifstream file_;
  std::string row_;
  std::vector<std::uint32_t> numbers_;
  std::vector<std::string> columns_;
  std::vector<std::string> units_;
  bool single_ = false;
  std::size_t header_bytes_ = 0;
  std::size_t record_bytes_ = 0;
  std::size_t records_ = 0;
  std::vector<char> buffer_;
};

// Writes the table as text: what the run would have written with output.format = "csv", but single precision numbers
// with their fewer digits. Replaces an existing file. Throws Error(input) if a file cannot be read or created,
// Error(simulation) if writing fails; the text then ends with its last complete record.
SPRINGNET_API void write_csv(RecordReader& records, const OutputFile& file);

}  // namespace springnet
