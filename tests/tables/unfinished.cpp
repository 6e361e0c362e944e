// What a crash leaves of a file: whole records, however large they are.
#include <string>

#include <doctest/doctest.h>

#include <springnet/output_folder.hpp>
#include <springnet/whole_records.hpp>

#include "files/checked_file.hpp"
#include "temporary_folder.hpp"

using namespace springnet;

TEST_CASE("a crash within a record larger than the buffer leaves the whole records before it") {
  const testing::TemporaryFolder folder;
  const std::string first(300, 'a'), large(200'000, 'b');
  const auto left = [&](bool in_parts) {
    CheckedFile file(folder.path() / "large.csv");
    file.write(first.data(), first.size());
    file.end_record(0.0);
    if (in_parts)
      for (std::size_t at = 0; at < large.size(); at += 100) file.write(large.data() + at, 100);
    else
      file.write(large.data(), large.size());
    CHECK(testing::read_text(folder.path() / "large.csv").size() > first.size());
    write_whole_records();
    return testing::read_text(folder.path() / "large.csv");
  };
  CHECK(left(false) == first);
  CHECK(left(true) == first);
}

TEST_CASE("a crash leaves a record larger than the buffer that has ended") {
  const testing::TemporaryFolder folder;
  CheckedFile file(folder.path() / "large.csv");
  const std::string large(200'000, 'b');
  for (std::size_t at = 0; at < large.size(); at += 100) file.write(large.data() + at, 100);
  file.end_record(1.0);
  file.write("torn", 4);
  write_whole_records();
  CHECK(testing::read_text(folder.path() / "large.csv") == large);
}
