// One of the tables that a run writes, described once. The text file, the binary file, the estimate of its size, the
// removal of an earlier run's, the help of `springnet run` and the check of core/docs/output.md all read this.
//
// To add a table: write a file beside trajectory.cpp with a function that returns its Table, and name that in list.cpp
// and in core/docs/output.md; a test tells what the page lacks.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/scene.hpp>
#include <springnet/tables.hpp>

#include "record/record.hpp"
#include "tables/table_file.hpp"

namespace springnet::tables {

// Columns of the same unit and meaning, as x, y and z.
struct Columns {
  enum class Cell {
    number,
    flag,   // 0 or 1
    count,  // a whole number, below RowCount::counts
    text    // RowCount::text says how long
  };
  std::vector<std::string_view> names;
  std::string_view unit;     // empty: none, or that of the element
  std::string_view meaning;  // as it stands in core/docs/output.md
  Cell cell = Cell::number;
  bool (*wanted)(const OutputOptions&) = nullptr;  // null: always
};

// At most this in a record, for the estimate.
struct RowCount {
  double rows = 0.0;
  double counts = 1.0;  // every number in the columns of counts is below this
  double text = 0.0;    // characters in the columns of text, of all rows
};

// Writes the rows of a record. It may keep what it needs from one record to the next.
using RowWriter = std::function<void(const Record&, TableFile&)>;

struct Table {
  std::string_view name;     // the file's without its ending
  std::string_view content;  // for the help, a few words
  // Behind the time; the first one says what a row belongs to.
  std::vector<Columns> columns;
  bool (*wanted)(const Network&, const OutputOptions&);
  std::string_view leave_out;     // "{}" is the file: how to do without it where the disk has no room
  std::string_view smaller = {};  // how to have less of it, if there is a way
  // Numbers in the first column, rising, where each record has the same rows, and nothing but numbers and flags behind
  // them: such a table has a binary form. Null for others.
  std::vector<std::uint32_t> (*numbers)(const Network&, const OutputOptions&) = nullptr;
  // Null where `numbers` says it, or where there is no telling beforehand: not estimated.
  RowCount (*rows)(const Network&, const OutputOptions&) = nullptr;
  RowWriter (*writer)(const Network&, const OutputOptions&);
};

// All that there are, in the order in which a run makes them.
[[nodiscard]] const std::vector<Table>& all();

// "trajectory.csv", or "trajectory.bin" if the options ask for it and the table has that form.
[[nodiscard]] std::string file_name(const Table& table, const OutputOptions& options);
// Every name that its file may have.
[[nodiscard]] std::vector<std::string> file_names(const Table& table);

// Row, columns and units as the options have them.
[[nodiscard]] TableForm form_of(const Table& table, const Network& network, const OutputOptions& options);
[[nodiscard]] std::unique_ptr<TableFile> create(const Table& table, const OutputFile& file, const Network& network,
                                                const OutputOptions& options);

// Of a run with so many records; nothing for a table whose length depends on what happens.
[[nodiscard]] std::optional<FileEstimate> estimate(const Table& table, const Network& network,
                                                   const OutputOptions& options, double records);

// 0, 1, …, or those chosen if there are any.
[[nodiscard]] std::vector<std::uint32_t> chosen_or_all(const std::vector<std::uint32_t>& chosen, std::size_t count);

}  // namespace springnet::tables
