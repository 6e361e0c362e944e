// Columns of numbers in CSV files: a header line with the names of the columns, then a row each line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace springnet::scene {

// Bytes, rows and columns of a file, and cells of all files of a scene.
inline constexpr std::size_t largest_csv = 64'000'000;
inline constexpr std::size_t most_csv_rows = 1'000'000;
inline constexpr std::size_t most_csv_columns = 16'384;
inline constexpr std::size_t most_csv_cells = 20'000'000;

struct CsvColumns {
  std::vector<std::vector<double>> values;  // [column][row], columns as asked for
  std::string file;                         // the place of a row in messages: "file:line"
  std::vector<std::uint32_t> lines;         // [row], from 1
  [[nodiscard]] std::string place(std::size_t row) const { return file + ":" + std::to_string(lines[row]); }
};

// A file, read once, whatever number of its columns is asked for. Messages quote nothing from the file: a scene may
// name any file, even one that the reader of the message must not see.
class CsvTable {
 public:
  // `name` is the file in messages. Cells are separated by commas; spaces around them, blank lines and lines that begin
  // with '#' are skipped. Every row has as many cells as the header line. Throws Error(input), "file:line: what; what
  // to do".
  CsvTable(std::string_view text, std::string name, std::size_t most_cells = most_csv_cells);

  // The columns with these names. Throws Error(input) for one that is missing or there twice, or has a cell that is not
  // a finite number; cells of other columns may be anything.
  [[nodiscard]] CsvColumns columns(const std::vector<std::string>& names) const;
  [[nodiscard]] bool has(std::string_view name) const;
  // The number of the first column, from 1, that has none of these names; 0 if there is none.
  [[nodiscard]] std::size_t first_other_than(const std::vector<std::string>& names) const;
  [[nodiscard]] std::size_t cells() const noexcept { return columns_.size() * lines_.size(); }

 private:
  struct Column {
    std::string name;
    std::vector<double> values;
    std::uint32_t wrong_line = 0;  // the first with a cell that is not a finite number; 0 if there is none
    std::string_view wrong{};      // about that cell
  };

  std::string file_;
  std::uint32_t header_line_ = 0;
  std::vector<Column> columns_;
  std::vector<std::uint32_t> lines_;  // [row]
};

// The CSV files of a scene.
class CsvFiles {
 public:
  // Throws Error(input) as CsvTable does, and for a file that is not a regular one or too large.
  [[nodiscard]] const CsvTable& read(const std::filesystem::path& file);

 private:
  std::map<std::filesystem::path, CsvTable> known_;
  std::size_t cells_ = 0;
};

}  // namespace springnet::scene
