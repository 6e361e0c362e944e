#include "tables/table_file.hpp"

#include <limits>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "tables/csv_file.hpp"

namespace springnet {

namespace {

using Precision = OutputOptions::Precision;

std::vector<std::uint32_t> all(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

class TextTable : public TableFile {
 public:
  TextTable(const OutputFile& file, TableForm form) : form_(std::move(form)), file_(file, csv_header(form_)) {}

  void record(double time, std::span<const double> values) override {
    const double* value = values.data();
    for (const std::uint32_t number : form_.numbers) {
      file_ << time << ',' << number;
      for (std::size_t column = 0; column < form_.columns.size(); ++column) file_ << ',' << *value++;
      file_ << '\n';
    }
    file_.end_record(time);
  }
  void close() override { file_.close(); }

 private:
  TableForm form_;
  CsvFile file_;
};

class BinaryTable : public TableFile {
 public:
  BinaryTable(const OutputFile& file, const TableForm& form, Precision precision) : file_(file), precision_(precision) {
    const std::string header = binary_header(form, precision);
    file_.write(header.data(), header.size());
    file_.end_record(std::numeric_limits<double>::quiet_NaN());
    file_.flush();
  }

  void record(double time, std::span<const double> values) override {
    write_numbers<double>(file_, std::span<const double>(&time, 1));
    if (precision_ == Precision::float64) {
      write_numbers<double>(file_, values);
    } else {
      write_numbers<float>(file_, values);
    }
    file_.end_record(time);
    file_.flush();  // a reader beside the run, or after its end by force, finds whole records
  }
  void close() override { file_.close(); }

 private:
  CheckedFile file_;
  Precision precision_;
};

}  // namespace

TableForm trajectory_form(const Network& network, const OutputOptions& options) {
  TableForm form{"node", options.nodes, {}, {}};
  if (form.numbers.empty()) form.numbers = all(network.nodes().size());
  const auto add = [&](bool wanted, std::initializer_list<const char*> columns, const char* unit) {
    if (!wanted) return;
    form.columns.insert(form.columns.end(), columns.begin(), columns.end());
    form.units.insert(form.units.end(), columns.size(), unit);
  };
  add(options.position, {"x", "y", "z"}, "m");
  add(options.velocity, {"vx", "vy", "vz"}, "m/s");
  add(options.force, {"fx", "fy", "fz"}, "N");
  return form;
}

TableForm spring_form(const OutputOptions& options) {
  return {"spring", options.springs, {"length", "tension", "energy", "alive"}, {"m", "N", "J", ""}};
}

// Elements of different invariants have different units.
TableForm element_form(const Network& network, const OutputOptions& options) {
  const bool everything = options.element_numbers.empty();
  return {"element",
          everything ? all(network.elements().size()) : options.element_numbers,
          {"value", "force", "alive"},
          {"", "", ""}};
}

std::unique_ptr<TableFile> create_table(const OutputFile& file, TableForm form, const OutputOptions& options) {
  if (options.format == OutputOptions::Format::csv) return std::make_unique<TextTable>(file, std::move(form));
  return std::make_unique<BinaryTable>(file, form, options.precision);
}

std::string table_name(const std::string& stem, const OutputOptions& options) {
  return stem + (options.format == OutputOptions::Format::csv ? ".csv" : ".bin");
}

std::string csv_header(const TableForm& form) {
  return fmt::format("time,{},{}", form.row, fmt::join(form.columns, ","));
}

std::size_t record_bytes(const TableForm& form, Precision precision) {
  const std::size_t number = precision == Precision::float64 ? sizeof(double) : sizeof(float);
  return sizeof(double) + form.numbers.size() * form.columns.size() * number;
}

std::string binary_header(const TableForm& form, Precision precision) {
  const bool everything = form.numbers == all(form.numbers.size());
  nlohmann::ordered_json description{{"row", form.row},
                                     {"rows", form.numbers.size()},
                                     {"columns", form.columns},
                                     {"units", form.units},
                                     {"type", precision == Precision::float64 ? "<f8" : "<f4"},
                                     {"record_bytes", record_bytes(form, precision)}};
  description["numbers"] = everything ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(form.numbers);
  const std::string text = description.dump();
  // Records start at a multiple of 64 bytes, so that numbers of eight bytes lie well in memory.
  constexpr std::size_t first_line = 29;  // "springnet records 1 01234567\n"
  constexpr std::size_t alignment = 64;
  const std::size_t bytes = (first_line + text.size() + 1 + alignment - 1) / alignment * alignment;
  std::string header = fmt::format("springnet records 1 {:08}\n{}", bytes, text);
  header.resize(bytes - 1, ' ');
  return header + '\n';
}

}  // namespace springnet
