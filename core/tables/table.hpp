// The description of a table that a run writes. Text file, binary file, size estimate, clean-up after an earlier run,
// the help of `springnet run` and the check of core/docs/output.md all come from it.
//
// To add a table, write a file beside trajectory.cpp with a function that returns its Table, add that to list.cpp, and
// describe it in core/docs/output.md; a test reports what the page lacks.
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/scene.hpp>
#include <springnet/tables.hpp>

#include "record/record.hpp"
#include "tables/table_file.hpp"
#include "text/archive.hpp"

namespace springnet::tables {

// Columns of the same unit and meaning, such as x, y and z.
struct Columns {
  enum class Cell {
    number,
    flag,   // 0 or 1
    count,  // a whole number below RowCount::count_bound
    text    // of a length within RowCount::text
  };
  std::vector<std::string_view> names;
  std::string_view unit;     // empty: none, or that of the element
  std::string_view meaning;  // as in core/docs/output.md
  Cell cell = Cell::number;
  bool (*wanted)(const OutputOptions&) = nullptr;  // null: always
};

// Upper bounds for a record, for the estimate.
struct RowCount {
  double rows = 0.0;         // nan: not known
  double count_bound = 1.0;  // numbers in columns of counts are below this
  double text = 0.0;         // characters in the columns of text, of all rows
};

// Writes the rows of a record. What it keeps from record to record, its `memory` archives.
class RowWriter {
 public:
  using Write = std::function<void(const Record&, TableFile&)>;
  using Memory = std::function<void(Archive&)>;
  template <class Function>
  requires std::convertible_to<Function, Write> RowWriter(Function write, Memory memory = {})
      : write_(std::move(write)), memory_(std::move(memory)) {}

  void operator()(const Record& record, TableFile& file) const { write_(record, file); }
  void archive(Archive& archive) const {
    if (memory_) memory_(archive);
  }

 private:
  Write write_;
  Memory memory_;
};

struct Table {
  std::string_view name;     // of the file, without its ending
  std::string_view content;  // a few words for the help
  // After the time; the first one identifies the row: node, spring and so on.
  std::vector<Columns> columns;
  bool (*wanted)(const Network&, const OutputOptions&);
  // Remedies for lack of disk space: how to leave it out ("{}" is the file), how to make it smaller (empty if it cannot
  // be).
  std::string_view leave_out_hint;
  std::string_view shrink_hint = {};
  // For a table with a binary form, that is with the same rows in each record, and only numbers and flags after the
  // first column: the numbers in that column, ascending. Null for others.
  std::vector<std::uint32_t> (*numbers)(const Network&, const OutputOptions&) = nullptr;
  // Null if it follows from `numbers`, or depends on events: then there is no estimate.
  RowCount (*rows)(const Network&, const OutputOptions&) = nullptr;
  RowWriter (*writer)(const Network&, const OutputOptions&);
};

// All tables, in the order in which a run creates them.
[[nodiscard]] const std::vector<Table>& all();

// "trajectory.csv", or "trajectory.bin" if the options ask for the binary form and the table has one.
[[nodiscard]] std::string file_name(const Table& table, const OutputOptions& options);
// Every name that its file can have.
[[nodiscard]] std::vector<std::string> file_names(const Table& table);

// Rows, columns and units under these options.
[[nodiscard]] TableForm form_of(const Table& table, const Network& network, const OutputOptions& options);
[[nodiscard]] std::unique_ptr<TableFile> create(const Table& table, const OutputFile& file, const Network& network,
                                                const OutputOptions& options);
// Opens one that ended there; see CheckedFile.
[[nodiscard]] std::unique_ptr<TableFile> reopen(const Table& table, const OutputFile& file,
                                                const OutputOptions& options, const CheckedFile::End& end);

// For a run with this many records; empty if the size depends on events.
[[nodiscard]] std::optional<FileEstimate> estimate(const Table& table, const Network& network,
                                                   const OutputOptions& options, double records);

// The chosen numbers; 0, 1, …, count - 1 if none are chosen.
[[nodiscard]] std::vector<std::uint32_t> chosen_or_all(const std::vector<std::uint32_t>& chosen, std::size_t count);

}  // namespace springnet::tables
