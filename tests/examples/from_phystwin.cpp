// A case of PhysTwin's data becomes a scene with observations, which can be learned from.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "csv.hpp"
#include "temporary_folder.hpp"

using namespace springnet::testing;

namespace {

int run_tool(const std::string& command, const std::string& log) {
  return std::system((command + " >" + log + " 2>&1").c_str());
}

// One with numpy, which the packages of the tests have; null: none.
const char* python() {
  for (const char* each : {"/usr/bin/python3", "python3"})
    if (std::system((std::string(each) + " -c 'import numpy' >/dev/null 2>&1").c_str()) == 0) return each;
  return nullptr;
}

}  // namespace

TEST_CASE("a case of PhysTwin's data is turned into a scene and observations of it") {
  const char* const interpreter = python();
  REQUIRE_MESSAGE(interpreter != nullptr, "there is no python3 with numpy: install python3-numpy");
  const TemporaryFolder folder;
  const std::filesystem::path at = folder.path();
  const std::string log = (at / "log").string(), tool = SPRINGNET_TOOL;
  const std::string make = std::string(interpreter) + " " + TESTS + "/examples/phystwin_case.py ";
  const std::string convert = std::string(interpreter) + " " EXAMPLES "/twin/from_phystwin ";
  REQUIRE(run_tool(make + (at / "case").string(), log) == 0);
  const int status = run_tool(convert + (at / "case").string() + " " + (at / "out").string(), log);
  CAPTURE(read_text(log));
  REQUIRE(status == 0);
  // Up is z; a point behind the table lies on it.
  const Csv toy = read_csv(at / "out/toy.csv");
  CHECK(toy.header == "x,y,z");
  REQUIRE(toy.rows.size() == 72 + 3);
  CHECK(toy.rows[4] == std::vector<std::string>{"0", "-0.012", "0.013"});
  CHECK(toy.rows[72][2] == "0");
  // A fifth is hidden; what was not followed to a frame is a point there.
  const Csv tracks = read_csv(at / "out/tracks.csv"), points = read_csv(at / "out/points.csv");
  CHECK(tracks.rows.size() + points.rows.size() == 8 * 57);
  REQUIRE(points.rows.size() == 4);
  CHECK(points.number(0, 0) == doctest::Approx(4.0 / 30.0));
  CHECK(points.number(0, 3) == doctest::Approx(0.013 + 4 * 0.002));
  const std::string scene = (at / "out/toy.toml").string();
  const int learned =
      run_tool(tool + " learn " + scene + " --observations " + (at / "out/tracks.csv").string() + " " +
                   (at / "out/points.csv").string() +
                   " --parameters spring.stiffness@toy:together --iterations 2 --output " + (at / "learned").string(),
               log);
  CAPTURE(read_text(log));
  CHECK(learned == 0);
  CHECK(std::filesystem::exists(at / "learned/learned.toml"));

  // No program of a stranger's file is run_tool.
  REQUIRE(run_tool(make + (at / "hostile").string() + " hostile", log) == 0);
  CHECK(run_tool(convert + (at / "hostile").string() + " " + (at / "none").string(), log) != 0);
  CHECK(read_text(log).find("where only arrays are expected") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(at / "hostile/was_run"));
  CHECK_FALSE(std::filesystem::exists(at / "none"));
  CHECK(run_tool(convert + (at / "nowhere").string() + " " + (at / "none").string(), log) != 0);
  CHECK(read_text(log).find("final_data.pkl: No such file") != std::string::npos);
}
