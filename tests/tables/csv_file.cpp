#include "tables/csv_file.hpp"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>
#include <thread>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "csv.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::TemporaryFolder;

TEST_CASE("a text is one cell, whatever characters it has") {
  CHECK(csv_cell("floor") == "floor");
  CHECK(csv_cell("") == "");
  CHECK(csv_cell("left, lower") == "\"left, lower\"");
  CHECK(csv_cell("4\" pipe") == "\"4\"\" pipe\"");
  CHECK(csv_cell("two\nlines") == "\"two\nlines\"");
}

TEST_CASE("numbers in a table read back as the same doubles") {
  const TemporaryFolder folder;
  std::mt19937_64 random(7);
  std::vector<double> values{0.0,      -0.0,
                             0.1,      1.0 / 3.0,
                             1e-300,   std::numeric_limits<double>::denorm_min(),
                             -1.7e308, 1e308,
                             22.5001,  std::numeric_limits<double>::lowest()};
  for (int k = 0; k < 20000; ++k) {
    const std::uint64_t bits = random();
    double value;
    static_assert(sizeof value == sizeof bits);
    std::memcpy(&value, &bits, sizeof value);
    if (std::isfinite(value)) values.push_back(value);
  }
  {
    CsvFile file(folder.path() / "table.csv", "value,number");
    for (std::uint32_t k = 0; k < values.size(); ++k) file << values[k] << ',' << k << '\n';
    file.end_record(0.0);
    file.close();
  }
  const testing::Csv csv = testing::read_csv(folder.path() / "table.csv");
  CHECK(csv.header == "value,number");
  REQUIRE(csv.rows.size() == values.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    REQUIRE(std::strtod(csv.rows[k][0].c_str(), nullptr) == values[k]);
    REQUIRE(csv.rows[k][1] == std::to_string(k));
  }
}

TEST_CASE("a table left open by an exception keeps its complete records, a closed one has only those") {
  const TemporaryFolder folder;
  for (const bool closed : {false, true}) {
    for (const bool flushed : {false, true}) {
      {
        CsvFile file(folder.path() / "table.csv", "a");
        file << 1.5 << '\n';
        file.end_record(0.1);
        file << 2.5 << '\n' << 3.5;
        if (flushed) file.flush();
        if (closed) file.close();
      }
      CHECK(testing::read_text(folder.path() / "table.csv") == "a\n1.5\n");
    }
  }
}

TEST_CASE("a full buffer writes complete records only") {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "table.csv";
  CsvFile file(path, "a", std::chrono::hours(1));
  std::size_t rows = 0;
  for (int record = 0; record < 200; ++record) {
    for (int row = 0; row < 100; ++row) {
      file << 0.123456789 << '\n';
      const std::string text = testing::read_text(path);
      REQUIRE(text.size() % (100 * 12) == 2);  // records of 100 rows of 12 characters, after "a\n"
      rows = std::max(rows, text.size() / 12);
    }
    file.end_record(record);
  }
  CHECK(rows > 10000);
}

TEST_CASE("the header is in the file at once, records after a while") {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "table.csv";
  {
    CsvFile file(path, "a", std::chrono::hours(1));
    CHECK(testing::read_text(path) == "a\n");
    file << 1.5 << '\n';
    file.end_record(0.0);
    CHECK(testing::read_text(path) == "a\n1.5\n");  // the first one
    file << 2.5 << '\n';
    file.end_record(0.0);
    CHECK(testing::read_text(path) == "a\n1.5\n");  // not written at each record
    file.flush();
    CHECK(testing::read_text(path) == "a\n1.5\n2.5\n");
  }
  CsvFile file(path, "a", std::chrono::milliseconds(20));
  for (const char* text : {"a\n1\n", "a\n1\n1\n"}) {
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
    file << 1.0 << '\n';
    file.end_record(0.0);
    CHECK(testing::read_text(path) == text);
  }
}

TEST_CASE("a file that cannot be created is an input error that names it") {
  const TemporaryFolder folder;
  try {
    CsvFile file(folder.path() / "nowhere" / "table.csv", "a");
    FAIL("created");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    CHECK(std::string(error.what()).find("nowhere") != std::string::npos);
  }
}

TEST_CASE("a full disk is a failure of the run, with a remedy") {
  if (!std::filesystem::exists("/dev/full")) return;
  try {
    CsvFile file("/dev/full", "a");
    FAIL("written");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::simulation);
    const std::string message = error.what();
    CHECK(message.find("No space left") != std::string::npos);
    CHECK(message.find("none of its records was written") != std::string::npos);
    CHECK(message.find("output.interval") != std::string::npos);
  }
}
