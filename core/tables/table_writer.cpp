#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/error.hpp>
#include <springnet/tables.hpp>

#include "tables/table.hpp"

namespace springnet {

namespace {

const tables::Table& find(std::string_view name) {
  const std::vector<tables::Table>& all = tables::all();
  const auto table = std::find_if(all.begin(), all.end(), [&](const tables::Table& each) { return each.name == name; });
  if (table != all.end()) return *table;
  throw Error(ErrorKind::input,
              fmt::format("there is no table '{}'; the tables are {}", name, fmt::join(table_names(), ", ")));
}

}  // namespace

std::vector<std::string> table_names() {
  std::vector<std::string> names;
  for (const tables::Table& table : tables::all()) names.emplace_back(table.name);
  return names;
}

std::vector<TableSummary> table_summaries() {
  std::vector<TableSummary> summaries;
  for (const tables::Table& table : tables::all()) {
    summaries.push_back({std::string(table.name), tables::file_name(table, {}),
                         csv_header(tables::form_of(table, {}, {})), std::string(table.content),
                         table.numbers != nullptr});
  }
  return summaries;
}

struct TableWriter::Impl {
  Impl(const tables::Table& table, const OutputFile& path, const Network& network, const OutputOptions& options)
      : state(network), file(tables::create(table, path, network, options)), rows(table.writer(network, options)) {}

  Record state;
  std::unique_ptr<TableFile> file;
  tables::RowWriter rows;
};

TableWriter::TableWriter(std::string_view table, const OutputFile& file, const Network& network,
                         const OutputOptions& options)
    : impl_(std::make_unique<Impl>(find(table), file, network, options)) {}
TableWriter::~TableWriter() = default;
TableWriter::TableWriter(TableWriter&&) noexcept = default;
TableWriter& TableWriter::operator=(TableWriter&&) noexcept = default;

void TableWriter::record(const Simulation& simulation) {
  impl_->state.take(simulation);
  impl_->file->begin_record(simulation.time());
  impl_->rows(impl_->state, *impl_->file);
  impl_->file->end_record();
}

void TableWriter::close() { impl_->file->close(); }

}  // namespace springnet
