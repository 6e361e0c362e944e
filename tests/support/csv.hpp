// A table of comma separated values, read back.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace springnet::testing {

struct Csv {
  std::string header;
  std::vector<std::vector<std::string>> rows;

  [[nodiscard]] double number(std::size_t row, std::size_t column) const { return std::stod(rows.at(row).at(column)); }
};

inline Csv read_csv(const std::filesystem::path& file) {
  Csv csv;
  std::ifstream in(file);
  std::getline(in, csv.header);
  for (std::string line; std::getline(in, line);) {
    std::stringstream cells(line + ',');  // so that an empty last cell counts
    csv.rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) csv.rows.back().push_back(cell);
  }
  return csv;
}

}  // namespace springnet::testing
