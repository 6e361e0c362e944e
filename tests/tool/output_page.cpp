// The page about the files that are written names every key that is in them.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tool.hpp"

using namespace springnet;
using testing::TemporaryFolder;

namespace {

void check_keys(const nlohmann::json& object, const std::string& page) {
  for (const auto& entry : object.items()) {
    const std::string key = entry.key();
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

  folder.write("all.toml", std::string(testing::pair_scene) +
                               "[output]\nreactions = true\n[[rigid]]\nsprings = {}\n"
                               "[[plane]]\npoint = [0, 0, -9]\nnormal = [0, 0, 1]\n");
  const auto files = testing::springnet(folder, "run all.toml --json").json()["files"];
  CHECK(files.size() == 7);
  for (const std::string file : files) {
    CAPTURE(file);
    CHECK(page.find(file) != std::string::npos);
    if (!file.ends_with(".csv")) continue;
    const std::string table = testing::read_text(folder.path() / "results/all" / file);
    CHECK(page.find(fmt::format("`{}`", table.substr(0, table.find('\n')))) != std::string::npos);
  }
}
