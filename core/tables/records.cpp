#include <springnet/records.hpp>

#include <charconv>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/error.hpp>

#include "files/checked_file.hpp"
#include "tables/csv_file.hpp"
#include "tables/table_form.hpp"

namespace springnet {

RecordReader::RecordReader(const std::filesystem::path& file) : path_(file) {
  std::error_code unknown;
  // Opening a pipe would block.
  if (std::filesystem::exists(file, unknown) && !std::filesystem::is_regular_file(file, unknown)) {
    refuse("is not a regular file; name a .bin file of a run");
  }
  const std::uintmax_t size = std::filesystem::file_size(file, unknown);
  file_.open(file, std::ios::binary);
  if (!file_ || unknown) refuse("cannot be read; check its name and its permissions");
  constexpr std::string_view magic = "springnet records ";
  std::string line;
  // A foreign file may be one long line.
  for (char c; line.size() < 64 && file_.get(c) && c != '\n';) line += c;
  if (!line.starts_with(magic)) {
    refuse("is not a binary table of springnet; name a .bin file that a run with output.format = \"binary\" wrote");
  }
  if (!line.starts_with("springnet records 1 ")) {
    refuse("has another version of the format; read it with the version of springnet that wrote it");
  }
  const char *const digits = line.data() + 20, *const last = line.data() + line.size();
  const auto [end, failed] = std::from_chars(digits, last, header_bytes_);
  if (last - digits != 8 || end != last || failed != std::errc() || header_bytes_ <= line.size() + 1) {
    refuse("has a damaged header");
  }
  if (header_bytes_ > size) refuse("ends within its header; the run that wrote it ended before its first record");

  std::string text(header_bytes_ - line.size() - 1, '\0');
  file_.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file_) refuse("cannot be read");
  try {
    describe(text, static_cast<std::size_t>(size - header_bytes_));
  } catch (const nlohmann::json::exception&) {
    refuse("has a damaged header");
  }
}

// Reads the header, which `bytes` bytes follow. Row numbers are allocated only if the file has a complete record.
void RecordReader::describe(const std::string& header, std::size_t bytes) {
  const auto check = [&](bool ok) {
    if (!ok) refuse("has a damaged header");
  };
  // Lists of numbers and names, nothing deeper: nested JSON takes forty times its bytes in memory.
  const auto limit_depth = [&](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
    check(depth <= 2);
    return true;
  };
  const auto description = nlohmann::json::parse(header, limit_depth);
  const auto number = [&](const nlohmann::json& value, std::uint64_t largest) {
    check(value.is_number_unsigned() && value.get<std::uint64_t>() <= largest);
    return value.get<std::uint64_t>();
  };
  row_ = description.at("row").get<std::string>();
  columns_ = description.at("columns").get<std::vector<std::string>>();
  units_ = description.at("units").get<std::vector<std::string>>();
  const std::string type = description.at("type").get<std::string>();
  if (type != "<f8" && type != "<f4") refuse("has numbers of an unknown type");
  single_ = type == "<f4";
  const std::uint64_t rows = number(description.at("rows"), UINT32_MAX);
  record_bytes_ = number(description.at("record_bytes"), SIZE_MAX);
  check(units_.size() == columns_.size() && !columns_.empty());
  const std::size_t row_bytes = columns_.size() * (single_ ? sizeof(float) : sizeof(double));
  check(record_bytes_ >= sizeof(double) && (record_bytes_ - sizeof(double)) % row_bytes == 0 &&
        (record_bytes_ - sizeof(double)) / row_bytes == rows);
  records_ = bytes / record_bytes_;
  if (records_ == 0) refuse("has no complete record; the run that wrote it ended before its first one");

  const nlohmann::json& numbers = description.at("numbers");
  if (numbers.is_null()) {
    numbers_.resize(static_cast<std::size_t>(rows));
    std::iota(numbers_.begin(), numbers_.end(), 0U);
    return;
  }
  check(numbers.is_array() && numbers.size() == rows);
  for (const nlohmann::json& value : numbers) {
    numbers_.push_back(static_cast<std::uint32_t>(number(value, UINT32_MAX)));
  }
}

double RecordReader::read(std::size_t record, std::vector<double>& values) {
  if (record >= records_)
    refuse(fmt::format("has {} records, numbered from 0; there is no record {}", records_, record));
  buffer_.resize(record_bytes_);
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(header_bytes_ + record * record_bytes_));
  file_.read(buffer_.data(), static_cast<std::streamsize>(record_bytes_));
  if (!file_) refuse(fmt::format("record {} cannot be read", record));
  values.resize(numbers_.size() * columns_.size());
  const char* place = buffer_.data() + sizeof(double);
  for (double& value : values) {
    value = single_ ? static_cast<double>(read_number<float>(place)) : read_number<double>(place);
    place += single_ ? sizeof(float) : sizeof(double);
  }
  return read_number<double>(buffer_.data());
}

void RecordReader::refuse(const std::string& reason) const {
  throw Error(ErrorKind::input, fmt::format("{}: {}", path_.string(), reason));
}

void write_csv(RecordReader& records, const OutputFile& file) {
  CsvFile out(file, csv_header({records.row_name(), {}, records.columns(), {}}));
  std::vector<double> values;
  for (std::size_t record = 0; record < records.records(); ++record) {
    const double time = records.read(record, values);
    const double* value = values.data();
    for (const std::uint32_t number : records.rows()) {
      out << time << ',' << number;
      for (std::size_t column = 0; column < records.columns().size(); ++column, ++value) {
        out << ',';
        if (records.single_precision()) {
          out << static_cast<float>(*value);
        } else {
          out << *value;
        }
      }
      out << '\n';
    }
    out.end_record(time);
  }
  out.close();
}

}  // namespace springnet
