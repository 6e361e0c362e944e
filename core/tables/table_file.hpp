// Tables that have the same rows of numbers at each record, as text or in the binary form of springnet/records.hpp.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <springnet/output_folder.hpp>
#include <springnet/scene.hpp>

namespace springnet {

struct TableForm {
  std::string row;                     // "node"
  std::vector<std::uint32_t> numbers;  // of the rows, rising
  std::vector<std::string> columns;
  std::vector<std::string> units;
};

// What the options make of each table.
[[nodiscard]] TableForm trajectory_form(const Network& network, const OutputOptions& options);
[[nodiscard]] TableForm spring_form(const OutputOptions& options);
[[nodiscard]] TableForm element_form(const Network& network, const OutputOptions& options);

class TableFile {
 public:
  virtual ~TableFile() = default;
  // `values`: [row][column]
  virtual void record(double time, std::span<const double> values) = 0;
  virtual void close() = 0;
};

// Throws Error(input) if the file cannot be created.
[[nodiscard]] std::unique_ptr<TableFile> create_table(const OutputFile& file, TableForm form,
                                                      const OutputOptions& options);
// "trajectory.csv", or "trajectory.bin"
[[nodiscard]] std::string table_name(const std::string& stem, const OutputOptions& options);

// "time,node,x,y,z"
[[nodiscard]] std::string csv_header(const TableForm& form);

// The binary form: a header of text, and what a record takes.
[[nodiscard]] std::string binary_header(const TableForm& form, OutputOptions::Precision precision);
[[nodiscard]] std::size_t record_bytes(const TableForm& form, OutputOptions::Precision precision);

}  // namespace springnet
