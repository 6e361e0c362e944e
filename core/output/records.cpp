#include <springnet/records.hpp>

#include <cstdlib>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/error.hpp>

#include "output/checked_file.hpp"
#include "output/csv_file.hpp"
#include "output/table_file.hpp"

namespace springnet {

RecordReader::RecordReader(const std::filesystem::path& file) : path_(file), file_(file, std::ios::binary) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(file, unknown);
  if (!file_ || unknown) refuse("cannot be read; check its name and its permissions");
  constexpr std::string_view mark = "springnet records ";
  std::string line;
  // Any other file may be one long line.
  for (char c; line.size() < 64 && file_.get(c) && c != '\n';) line += c;
  if (!line.starts_with(mark)) {
    refuse("is no binary table of springnet; name a .bin file that a run with output.format = \"binary\" wrote");
  }
  if (!line.starts_with("springnet records 1 ")) {
    refuse("is of another version of the format; read it with the version of springnet that wrote it");
  }
  const char* const digits = line.c_str() + 20;
  char* end = nullptr;
  header_bytes_ = std::strtoull(digits, &end, 10);
  if (end == digits || *end != '\0' || header_bytes_ <= line.size() + 1) refuse("has a damaged header");
  if (header_bytes_ > size) refuse("ends within its header; the run that wrote it was ended before its first record");

  std::string text(header_bytes_ - line.size() - 1, '\0');
  file_.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file_) refuse("cannot be read");
  std::size_t rows = 0;
  try {
    const auto description = nlohmann::json::parse(text);
    row_ = description.at("row");
    rows = description.at("rows");
    columns_ = description.at("columns").get<std::vector<std::string>>();
    units_ = description.at("units").get<std::vector<std::string>>();
    const std::string type = description.at("type");
    if (type != "<f8" && type != "<f4") refuse(fmt::format("has numbers of the unknown type '{}'", type));
    single_ = type == "<f4";
    record_bytes_ = description.at("record_bytes");
    if (description.at("numbers").is_null()) {
      if (rows > record_bytes_ && !columns_.empty()) refuse("has a damaged header");
      numbers_.resize(rows);
      std::iota(numbers_.begin(), numbers_.end(), 0U);
    } else {
      numbers_ = description.at("numbers").get<std::vector<std::uint32_t>>();
    }
  } catch (const nlohmann::json::exception&) {
    refuse("has a damaged header");
  }
  const std::size_t number = single_ ? sizeof(float) : sizeof(double);
  if (numbers_.size() != rows || units_.size() != columns_.size() || columns_.empty() ||
      record_bytes_ != sizeof(double) + rows * columns_.size() * number) {
    refuse("has a damaged header");
  }
  records_ = static_cast<std::size_t>((size - header_bytes_) / record_bytes_);
}

double RecordReader::read(std::size_t record, std::vector<double>& values) {
  if (record >= records_)
    refuse(fmt::format("has {} records, numbered from 0: there is no record {}", records_, record));
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

void write_csv(RecordReader& records, const std::filesystem::path& file) {
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
  }
  out.close();
}

}  // namespace springnet
