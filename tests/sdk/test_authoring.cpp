// The promise to authors: a plugin with a new law is at most twenty lines.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace {
int lines_of(const std::string& file) {
  std::ifstream stream(std::filesystem::path(SPRINGNET_SOURCES) / file);
  REQUIRE_MESSAGE(stream.is_open(), file);
  int count = 0;
  for (std::string line; std::getline(stream, line);) ++count;
  return count;
}
}  // namespace

TEST_CASE("a law is at most twenty lines, comments and empty lines included") {
  for (const char* file : {"plugins/springs/linear/linear.cpp", "sdk/template/my_law.cpp"}) {
    CAPTURE(std::string(file));
    CHECK(lines_of(file) > 0);
    CHECK(lines_of(file) <= 20);
  }
}
