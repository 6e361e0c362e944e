// The tables of a run (core/docs/output.md), for programs that simulate on their own.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/network.hpp>
#include <springnet/output_folder.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// "trajectory", "reactions", …: those that a TableWriter writes, as files without their endings.
[[nodiscard]] SPRINGNET_API std::vector<std::string> table_names();

// What a table has, with the default options.
struct TableSummary {
  std::string name;
  std::string file;     // "trajectory.csv"
  std::string header;   // "time,node,x,y,z"
  std::string content;  // a few words
  bool has_binary_form = false;
};
// Of all tables, in the order of table_names().
[[nodiscard]] SPRINGNET_API std::vector<TableSummary> table_summaries();

// Writes one of the tables, as `springnet run` does: comma separated values below a header line, or the binary form of
// springnet/records.hpp where the table has one and the options say so. Numbers in text are the shortest decimals that
// read back as the same double. Nodes, springs and so on have the user's numbers.
//
// record() and close() throw Error(simulation) if the file cannot be written, on a full disk for instance. The file
// then ends with its last complete record, whose time the message gives, and takes no more. Text is flushed at most a
// second after record(), if more records follow; binary records are flushed at once.
class SPRINGNET_API TableWriter {
 public:
  // Replaces an existing file. The options select rows and columns; whether the scene requests the table does not
  // matter. Throws Error(input) if there is no table of this name or the file cannot be created,
  // Error(simulation) if its header cannot be written.
  TableWriter(std::string_view table, const OutputFile& file, const Network& network,
              const OutputOptions& options = {});
  ~TableWriter();
  TableWriter(TableWriter&&) noexcept;
  TableWriter& operator=(TableWriter&&) noexcept;

  // Writes the present state of a simulation of the network.
  void record(const Simulation& simulation);
  void close();

 private:
  struct SPRINGNET_LOCAL Impl;
  std::unique_ptr<Impl> impl_;
};

// How large a file of a run becomes, at most. Text is overestimated: each number counts as the longest that there is.
struct FileEstimate {
  std::string file;  // name in the folder
  double bytes = 0.0;
  bool exact = false;
};

}  // namespace springnet
