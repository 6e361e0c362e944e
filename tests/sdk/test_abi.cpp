#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "abi_sizes.h"

TEST_CASE("structs of ABI 2.x end at their frozen sizes, in C and in C++") {
#define CHECK_END(type, last, end)               \
  {                                              \
    INFO(#type " up to " #last);                 \
    CHECK(SPRINGNET_SIZE_TO(type, last) == end); \
  }
  SPRINGNET_ENDS_2_0(CHECK_END)
  SPRINGNET_ENDS_2_1(CHECK_END)
  CHECK(springnet_ends_wrong_in_c() == 0);
}

namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

}  // namespace

// A struct that is not listed may grow in its middle without notice.
TEST_CASE("every struct of the ABI is listed with its end") {
  const std::filesystem::path sources = SPRINGNET_SOURCES;
  const std::string listed = text_of(sources / "tests/sdk/abi_sizes.h");
  const std::regex definition("typedef struct (springnet_\\w+) \\{");
  std::size_t found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sources / "sdk/include/springnet/sdk/abi")) {
    const std::string header = text_of(entry.path());
    for (std::sregex_iterator match(header.begin(), header.end(), definition), end; match != end; ++match, ++found) {
      const std::string name = (*match)[1];
      CAPTURE(name);
      CHECK(listed.find("check(" + name + ",") != std::string::npos);
    }
  }
  CHECK(found >= 60);
}

TEST_CASE("the magic number reads SPRNGNET in memory") {
  const std::uint64_t magic = SPRINGNET_MAGIC;
  CHECK(std::memcmp(&magic, "SPRNGNET", sizeof magic) == 0);
}

TEST_CASE("HAS_FIELD is false for fields beyond struct_size") {
  springnet_integrator integrator{};
  integrator.struct_size = SPRINGNET_SIZE_TO(springnet_integrator, destroy);
  CHECK(SPRINGNET_HAS_FIELD(springnet_integrator, &integrator, destroy));
  CHECK_FALSE(SPRINGNET_HAS_FIELD(springnet_integrator, &integrator, advance));
}
