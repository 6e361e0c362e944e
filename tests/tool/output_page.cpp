// The page about the files that are written names every key that is in them.
#include <doctest/doctest.h>

#include "tool.hpp"

using namespace springnet;
using testing::TemporaryFolder;

namespace {

void check_keys(const nlohmann::json& object, const std::string& page) {
  for (const auto& [key, value] : object.items()) {
    CAPTURE(key);
    CHECK(page.find("`" + key + "`") != std::string::npos);
  }
}

}  // namespace

TEST_CASE("the page about output is complete") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const std::string page = testing::read_text(SPRINGNET_OUTPUT_PAGE);
  REQUIRE_FALSE(page.empty());
  check_keys(testing::springnet(folder, "run pair.toml --json").json(), page);
  const auto validation = testing::springnet(folder, "validate pair.toml --json").json();
  check_keys(validation, page);
  check_keys(validation["reference"], page);
  check_keys(validation["runs"][0], page);
}
