// A binary table: refused, or every record can be read.
#include <springnet/records.hpp>

#include "target.hpp"

using namespace springnet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path& file = testing::file_of(data, size, "table.bin");
  testing::read_or_refuse(file.native(), [&] {
    RecordReader records(file);
    std::vector<double> values;
    for (std::size_t record = 0; record < records.records(); ++record) {
      records.read(record, values);
      testing::require(values.size() == records.rows().size() * records.columns().size(), "a record has all values");
    }
    // As many bytes stand in the file.
    testing::require(records.rows().size() * sizeof(float) <= size, "rows are there");
    write_csv(records, file.parent_path() / "table.csv");
  });
  return 0;
}
