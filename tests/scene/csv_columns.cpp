// Columns of numbers from a CSV file.
#include "scene/csv_columns.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "facts.hpp"
#include "temporary_folder.hpp"

using springnet::Error;
using springnet::scene::CsvColumns;
using springnet::scene::CsvFiles;
using springnet::scene::CsvTable;
using springnet::testing::has_facts;

namespace {

std::string refusal(const std::string& text, const std::vector<std::string>& names = {"time", "value"}) {
  try {
    static_cast<void>(CsvTable(text, "a.csv").columns(names));
  } catch (const Error& error) {
    CHECK(error.kind() == springnet::ErrorKind::input);
    return error.what();
  }
  return {};
}

std::string refusal_of_file(const std::filesystem::path& file) {
  try {
    static_cast<void>(CsvFiles().read(file).columns({"time"}));
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("columns come by name, in the order asked for, with the lines of their rows") {
  const CsvColumns read =
      CsvTable(
          "\xEF\xBB\xBF# measured on Monday\r\n\r\n \"value\", note ,time\r\n 1.5 ,first,\t0\r\n# a "
          "break\n\n-2e-3,,+1\n4,x,2",
          "a.csv")
          .columns({"time", "value"});
  REQUIRE(read.values.size() == 2);
  CHECK(read.values[0] == std::vector<double>{0, 1, 2});
  CHECK(read.values[1] == std::vector<double>{1.5, -2e-3, 4});
  CHECK(read.lines == std::vector<std::uint32_t>{4, 7, 8});
}

TEST_CASE("a header line alone has no rows; one column may be asked for") {
  CHECK(CsvTable("time,value\n", "a.csv").columns({"time", "value"}).lines.empty());
  CHECK(CsvTable("time\n1\n2\n", "a.csv").columns({"time"}).values[0] == std::vector<double>{1, 2});
}

TEST_CASE("what is wrong is told with its line, and nothing of the file is quoted") {
  CHECK(has_facts(refusal(""), "a.csv:1: | header line"));
  CHECK(has_facts(refusal("# nothing\n\n"), "a.csv:2: | header line"));
  CHECK(has_facts(refusal("\ntime,secret\n"), "a.csv:2: | no column | 'value' | 2 names"));
  CHECK(has_facts(refusal("time,value,time\n"), "a.csv:1: | two columns | 'time'"));
  CHECK(has_facts(refusal("time,value\n1,2\n1,2,3\n"), "a.csv:3: | 3 cells | 2"));
  CHECK(has_facts(refusal("time,value\n1,2\n\n1\n"), "a.csv:4: | 1 cells | 2"));
  CHECK(has_facts(refusal("time,value\n1,secret\n"), "a.csv:2: | 'value' | number"));
  CHECK(has_facts(refusal("time,value\n1,2 3\n"), "a.csv:2: | 'value' | number"));
  CHECK(has_facts(refusal("time;value\n1;2\n"), "a.csv:1: | no column | 'time' | commas"));
  CHECK(has_facts(refusal("time,value\n1,\n"), "a.csv:2: | 'value' | no value"));
  for (const char* bad : {"nan", "inf", "-inf", "1e999"}) {
    CHECK(has_facts(refusal(std::string("time,value\n1,2\n1,") + bad + "\n"), "a.csv:3: | 'value' | finite"));
  }
  for (const char* text : {"time,secret\n", "time,value\n1,secret\n", "secret\n1\n"})
    CHECK(refusal(text).find("secret") == std::string::npos);
  CHECK(has_facts(refusal(std::string("time,value\n1,2\0\n", 16)), "a.csv:2: | 'value' | number"));
}

TEST_CASE("a file has at most a million rows, which take a moment") {
  std::string text = "time\n";
  for (std::size_t k = 0; k < springnet::scene::most_csv_rows; ++k) text += "1\n";
  const auto begin = std::chrono::steady_clock::now();
  CHECK(CsvTable(text, "a.csv").columns({"time"}).lines.size() == springnet::scene::most_csv_rows);
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(10));
  CHECK(has_facts(refusal(text + "1\n", {"time"}), "a.csv:1000002: | more than 1,000,000 rows"));
}

TEST_CASE("a file is read once; its other columns may be anything") {
  const springnet::testing::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.csv";
  std::ofstream(file) << "time,note,value\n0,first,5\n1,second,\n";
  CsvFiles files;
  CHECK(files.read(file).columns({"time"}).values[0] == std::vector<double>{0, 1});
  std::filesystem::remove(file);
  const CsvTable& again = files.read(file);
  CHECK(again.cells() == 6);
  CHECK_THROWS_WITH(static_cast<void>(again.columns({"time", "value"})),
                    doctest::Contains("a.csv:3: column 'value' has no value"));
  CHECK_THROWS_WITH(static_cast<void>(again.columns({"value", "note"})),
                    doctest::Contains("a.csv:2: column 'note' must"));
}

TEST_CASE("wide files and many cells are refused") {
  std::string wide = "time";
  for (std::size_t k = 1; k < springnet::scene::most_csv_columns; ++k) wide += ",";
  CHECK(refusal(wide, {"time"}).empty());
  CHECK(has_facts(refusal(wide + ",", {"time"}), "a.csv:1: | more than 16,384 columns"));
  CHECK_THROWS_WITH(CsvTable("a,b\n1,2\n3,4\n", "a.csv", 3),
                    doctest::Contains("a.csv:3: the CSV files of the scene have more than"));
}

TEST_CASE("only regular files of a size are read") {
  const springnet::testing::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.csv";
  CHECK(has_facts(refusal_of_file(file), "a.csv: | no such file"));
  CHECK(has_facts(refusal_of_file(folder.path()), "not a file"));
  CHECK(has_facts(refusal_of_file("/dev/zero"), "/dev/zero: | not a file"));
  std::ofstream(file) << "time\n1\n";
  CHECK(refusal_of_file(file).empty());
  std::filesystem::resize_file(file, springnet::scene::largest_csv + 1);
  CHECK(has_facts(refusal_of_file(file), "a.csv: | more than 64,000,000 bytes"));
}
