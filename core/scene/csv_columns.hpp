// Columns of numbers in a CSV file: a header line with the names of the columns, then a row each line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace springnet::scene {

// Bytes and rows of a file.
inline constexpr std::size_t largest_csv = 64'000'000;
inline constexpr std::size_t most_csv_rows = 1'000'000;

struct CsvColumns {
  std::vector<std::vector<double>> values;  // [column][row], columns as asked for
  std::vector<std::uint32_t> lines;         // [row] of the file, from 1: for messages
};

// Reads the columns with these names. Cells are separated by commas; spaces around them, blank lines and lines that
// begin with '#' are skipped. Every row has as many cells as the header line; cells of other columns may be anything.
// Throws Error(input), "file:line: what; what to do", for a column that is missing or there twice, a row with more or
// fewer cells, a cell that is not a finite number, a file that is not a regular one or too large. Messages quote
// nothing from the file: a scene may name any file, even one that the reader of the message must not see.
[[nodiscard]] CsvColumns read_csv_columns(const std::filesystem::path& file, const std::vector<std::string>& names);

// The same from text; `name` replaces the file in messages.
[[nodiscard]] CsvColumns parse_csv_columns(std::string_view text, std::string_view name,
                                           const std::vector<std::string>& names);

}  // namespace springnet::scene
