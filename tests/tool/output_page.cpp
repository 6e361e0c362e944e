// The page about output files lists every key in them.
#include <sstream>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "csv.hpp"
#include "tool.hpp"

using namespace springnet;
using testing::Answer;
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
  check_keys(validation["displacement"], page);
  check_keys(validation["second_order"], page);

  check_keys(testing::springnet(folder, "run pair.toml --json --realtime=100").json()["pace"], page);

  const std::string all = std::string(testing::pair_scene) +
                          "[output]\nreactions = true\nsprings = {}\nvtk = true\n[[rigid]]\nsprings = {}\n"
                          "[[plane]]\npoint = [0, 0, -9]\nnormal = [0, 0, 1]\n";
  folder.write("all.toml", all);
  const auto files = testing::springnet(folder, "run all.toml --json").json()["files"];
  CHECK(files.size() == 9);
  for (const std::string file : files) {
    CAPTURE(file);
    CHECK(page.find(file) != std::string::npos);
    if (!file.ends_with(".csv")) continue;
    const std::string table = testing::read_text(folder.path() / "results/all" / file);
    CHECK(page.find(fmt::format("`{}`", table.substr(0, table.find('\n')))) != std::string::npos);
  }
  // Names of all data in the pictures.
  for (const char* file : {"net_000000.vtu", "surfaces_000000.vtp"}) {
    CAPTURE(file);
    CHECK(page.find(file) != std::string::npos);
    const std::string text = testing::read_text(folder.path() / "results/all/vtk" / file);
    for (const char* section : {"<PointData>", "<CellData>"}) {
      const std::size_t end = text.find("</", text.find(section));
      for (std::size_t name = text.find("Name=\"", text.find(section)); name < end; name = text.find("Name=\"", name)) {
        name += 6;
        const std::string data = text.substr(name, text.find('"', name) - name);
        CAPTURE(data);
        CHECK(page.find("`" + data + "`") != std::string::npos);
      }
    }
  }
  // The header of a binary table.
  REQUIRE(testing::springnet(folder, "run all.toml -q --set 'output.format=\"binary\"'").status == 0);
  for (const char* file : {"trajectory.bin", "springs.bin"}) {
    CAPTURE(file);
    CHECK(page.find(fmt::format("`{}`", file)) != std::string::npos);
    const std::string text = testing::read_text(folder.path() / "results/all" / file);
    const std::size_t line = text.find('\n') + 1;
    check_keys(nlohmann::json::parse(text.substr(line, text.find('\n', line) - line)), page);
  }
}

TEST_CASE("the page's Python code for binary tables works") {
  const TemporaryFolder folder;
  if (testing::shell(folder, "/usr/bin/python3 -c 'import numpy'").status != 0) return;  // no NumPy here
  const std::string page = testing::read_text(SPRINGNET_OUTPUT_PAGE);
  const std::size_t begin = page.find("```python\n") + 10;
  folder.write("read.py", page.substr(begin, page.find("```", begin) - begin) +
                              "print(len(data), repr(float(data['time'][3])), table['numbers'])\n"
                              "np.savetxt('values', data['values'].reshape(-1, 6), '%.17g', ',')\n");
  folder.write("pair.toml", testing::pair_scene);
  REQUIRE(testing::springnet(folder, "run pair.toml -q -o . --set 'output.format=\"binary\"'").status == 0);
  // As a killed run may leave it.
  const std::filesystem::path file = folder.path() / "trajectory.bin";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 5);
  const Answer answer = testing::shell(folder, "/usr/bin/python3 read.py && \"$SPRINGNET\" convert trajectory.bin -q");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(answer.out.find("\n10 0.30000000000000004 None\n") != std::string::npos);
  std::istringstream values(testing::read_text(folder.path() / "values"));
  const testing::Csv csv = testing::read_csv(folder.path() / "trajectory.csv");
  REQUIRE(csv.rows.size() == 20);
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    for (std::size_t column = 2; column < 8; ++column) {
      std::string cell;
      std::getline(values, cell, column < 7 ? ',' : '\n');
      CHECK(std::stod(cell) == csv.number(row, column));
    }
  }
}
