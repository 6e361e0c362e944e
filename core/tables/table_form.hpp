// Layout of a table's file: text, or the binary form of springnet/records.hpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <springnet/scene.hpp>

namespace springnet {

struct TableForm {
  std::string row;                     // name of the column that identifies a row: "node"
  std::vector<std::uint32_t> numbers;  // of the rows, ascending; empty if rows differ from record to record
  std::vector<std::string> columns;    // the other columns, without the time
  std::vector<std::string> units;      // of `columns`
};

// "time,node,x,y,z"
[[nodiscard]] std::string csv_header(const TableForm& form);

// The binary form: a header of text, and the size of a record.
[[nodiscard]] std::string binary_header(const TableForm& form, OutputOptions::Precision precision);
[[nodiscard]] std::size_t record_bytes(const TableForm& form, OutputOptions::Precision precision);

}  // namespace springnet
