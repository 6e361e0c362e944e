// Each table is described once: its file, its help and core/docs/output.md say the same.
#include <algorithm>
#include <set>
#include <sstream>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/error.hpp>
#include <springnet/run.hpp>
#include <springnet/tables.hpp>

#include "csv.hpp"
#include "facts.hpp"
#include "nets.hpp"
#include "tables/table.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::TemporaryFolder;

namespace {

// Rows of the tables of the section, as "| a | b |", in order, without the heads.
std::vector<std::string> rows_in(const std::string& page, const std::string& section) {
  std::istringstream lines(page.substr(page.find(section)));
  std::vector<std::string> rows;
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line) && !line.starts_with("## ")) {
    if (line.starts_with("| `")) rows.push_back(line);
  }
  return rows;
}

}  // namespace

TEST_CASE("the page about output lists exactly these tables with these columns") {
  const std::string page = testing::read_text(SPRINGNET_OUTPUT_PAGE);
  std::vector<std::string> files, columns;
  for (const std::string& row : rows_in(page, "## Tables of a run")) {
    // Of two kinds: "| file | header | rows |" and "| file | columns | unit | meaning |".
    (std::count(row.begin(), row.end(), '|') == 4 ? files : columns).push_back(row);
  }
  std::vector<std::string> expected;
  for (const tables::Table& table : tables::all()) {
    for (const tables::Columns& group : table.columns) {
      expected.push_back(fmt::format("| `{}.csv` | `{}` | {} | {} |", table.name, fmt::join(group.names, ","),
                                     group.unit, group.meaning));
    }
  }
  CHECK(columns == expected);
  REQUIRE(files.size() == tables::all().size());
  for (std::size_t k = 0; k < files.size(); ++k) {
    const tables::Table& table = tables::all()[k];
    CAPTURE(files[k]);
    CHECK(files[k].starts_with(
        fmt::format("| `{}.csv` | `{}` | ", table.name, csv_header(tables::form_of(table, {}, {})))));
    if (table.numbers != nullptr) CHECK(page.find(fmt::format("`{}.bin`", table.name)) != std::string::npos);
  }
}

TEST_CASE("the public summaries have all tables in the order of their names") {
  const std::vector<TableSummary> summaries = table_summaries();
  const std::vector<std::string> names = table_names();
  REQUIRE(summaries.size() == names.size());
  for (std::size_t k = 0; k < names.size(); ++k) {
    CAPTURE(names[k]);
    CHECK(summaries[k].name == names[k]);
    CHECK(summaries[k].file == names[k] + ".csv");
    CHECK(summaries[k].header.starts_with("time,"));
    CHECK(!summaries[k].content.empty());
    CHECK(summaries[k].has_binary_form == (tables::all()[k].numbers != nullptr));
  }
}

TEST_CASE("names of tables and of the columns of each differ") {
  const std::vector<std::string> names = table_names();
  CHECK(std::set<std::string>(names.begin(), names.end()).size() == names.size());
  for (const tables::Table& table : tables::all()) {
    CAPTURE(table.name);
    std::set<std::string_view> columns{"time"};
    std::size_t count = 1;
    for (const tables::Columns& group : table.columns) {
      columns.insert(group.names.begin(), group.names.end());
      count += group.names.size();
    }
    CHECK(columns.size() == count);
  }
}

TEST_CASE("remedies for lack of space name keys of a scene") {
  const std::vector<std::string>& keys = scene_keys();
  for (const tables::Table& table : tables::all()) {
    for (const std::string_view remedy : {table.leave_out_hint, table.shrink_hint}) {
      if (remedy.empty()) continue;
      CAPTURE(remedy);
      const std::size_t begin = remedy.find("output.");
      REQUIRE(begin != std::string_view::npos);
      const std::string key(remedy.substr(begin, remedy.find_first_of(" )", begin) - begin));
      CHECK(std::count(keys.begin(), keys.end(), key) == 1);
    }
  }
}

TEST_CASE("a writer of each table makes the file that a run makes") {
  Network net = testing::chain(4, {0, 0, 0}, {1, 0, 0}, testing::damped(40.0, 0.5));
  net.fix(0);
  net.set_gravity({0, 0, -10});
  net.add_element(Invariant::angle, {0, 1, 2},
                  net.add_material({LawUse{"linear", {{"stiffness", 2.0}}}, std::nullopt}));
  net.add_spring(0, 2,
                 net.add_material({LawUse{"maxwell", {{"stiffness", 9.0}, {"relaxation_time", 0.2}}}, std::nullopt}));
  net.add_rigid(2, 3);
  net.add_plane({"floor, wet", Vector3(0, 0, -0.3), Vector3::UnitZ()});
  Scene scene;
  scene.network = net;
  scene.duration = 0.5;
  scene.options.time_step = 0.0625;  // times are sums of powers of two, not rounded
  scene.options.threads = 1;
  scene.output.reactions = scene.output.force = true;
  scene.output.springs = {0, 3};
  scene.output.states = scene.output.energies = scene.options.dissipated_energy = true;
  scene.output.view = false;
  const TemporaryFolder folder;
  for (const auto format : {OutputOptions::Format::csv, OutputOptions::Format::binary}) {
    scene.output.format = format;
    CHECK_FALSE(run_scene(scene, testing::plugins(), {folder.path() / "run", "chain", {}}).failure);
    std::vector<TableWriter> writers;
    for (const tables::Table& table : tables::all()) {
      if (table.wanted(net, scene.output))
        writers.emplace_back(table.name, folder.path() / tables::file_name(table, scene.output), net, scene.output);
    }
    Simulation simulation(net, testing::plugins(), scene.options);
    for (int record = 0; record <= 8; ++record) {
      if (record > 0) simulation.step();
      for (TableWriter& writer : writers) writer.record(simulation);
    }
    for (TableWriter& writer : writers) writer.close();
    for (const tables::Table& table : tables::all()) {
      if (table.name == "contacts") continue;  // test_bodies has it: this integrator keeps no bodies apart
      const std::string name = tables::file_name(table, scene.output);
      CAPTURE(name);
      REQUIRE(table.wanted(net, scene.output));
      const std::string text = testing::read_text(folder.path() / name);
      CHECK(text == testing::read_text(folder.path() / "run" / name));
      CHECK(text.size() > csv_header(tables::form_of(table, net, scene.output)).size() + 1);
    }
  }
}

TEST_CASE("an estimate has room for the longest numbers") {
  Network net;
  for (int k = 0; k < 12; ++k) net.add_node({});
  net.add_plane({"", Vector3::Zero(), Vector3::UnitZ()});
  net.add_plane({"a,b", Vector3::Zero(), Vector3::UnitZ()});
  OutputOptions options;
  const auto bytes = [&](const std::string& name) {
    for (const tables::Table& table : tables::all()) {
      if (table.name == name) return tables::estimate(table, net, options, 2.0).value().bytes;
    }
    return 0.0;
  };
  const std::string number = ",-2.2250738585072014e-308", time = "2.2250738585072014e-308";
  const auto size = [](const std::string& text) { return static_cast<double>(text.size()); };
  // Rows as long as they may become: two records of 12 nodes, of two surfaces.
  CHECK(bytes("trajectory") == 2 * 12 * (size(time + ",11\n") + 6 * size(number)));
  CHECK(bytes("surfaces") == 2 * (2 * (size(time + ",11\n") + 12 * size(number)) + size(",0") + size(",\"a,b\"")));
  CHECK(bytes("reactions") == 2 * 12 * (size(time + ",11,\n") + 9 * size(number) + size("0;") + size("\"a,b\";")));
  for (const tables::Table& table : tables::all()) {
    if (table.name == "events" || table.name == "states") CHECK_FALSE(tables::estimate(table, net, options, 2.0));
  }
}

TEST_CASE("a record that an exception ends leaves no trace") {
  const TemporaryFolder folder;
  const TableForm form{"node", {3, 5}, {"x"}, {"m"}};
  for (const auto binary :
       {std::optional<OutputOptions::Precision>{}, std::optional(OutputOptions::Precision::float64)}) {
    const std::filesystem::path path = folder.path() / (binary ? "table.bin" : "table.csv");
    const auto write = [&](bool interrupted) {
      TableFile file(path, form, binary);
      for (const double time : {0.25, 0.5}) {
        if (interrupted) {
          file.begin_record(7.0);
          file.row(7.0);
          file << std::uint32_t{3} << 7.0;
        }
        file.begin_record(time);
        for (const std::uint32_t node : form.numbers) {
          file.row(time);
          file << node << time * node;
        }
        file.end_record();
      }
      file.close();
      return testing::read_text(path);
    };
    const std::string whole = write(false);
    CHECK(write(true) == whole);
    if (!binary) CHECK(whole == "time,node,x\n0.25,3,0.75\n0.25,5,1.25\n0.5,3,1.5\n0.5,5,2.5\n");
  }
}

TEST_CASE("a table that does not exist is refused") {
  const TemporaryFolder folder;
  try {
    TableWriter("trajectories", folder.path() / "a.csv", Network{});
    FAIL_CHECK("it was not refused");
  } catch (const Error& error) {
    CAPTURE(error.what());
    CHECK(testing::has_facts(error.what(),
                             "'trajectories' | events, trajectory, reactions, surfaces, contacts, rigid, springs, "
                             "elements, states, energies"));
  }
  CHECK_FALSE(std::filesystem::exists(folder.path() / "a.csv"));
}
