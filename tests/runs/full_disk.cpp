// Files that cannot grow any more end with a complete record. A limit of the process stands in for a full disk.
#include <sys/resource.h>

#include <cmath>
#include <csignal>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/output.hpp>
#include <springnet/records.hpp>

#include "csv.hpp"
#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

// While this exists, no file grows beyond this many bytes.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_;
};

Scene chain_scene() {
  Scene scene;
  scene.network = testing::chain(4, {0, 0, 0}, {1, 0, 0}, testing::damped(40.0, 0.5));
  scene.network.fix(0);
  scene.network.set_gravity({0, 0, -10});
  scene.duration = 50.0;
  scene.options.time_step = 0.05;
  scene.options.threads = 1;
  scene.output.view = false;
  scene.output.springs = {0, 1, 2};
  return scene;
}

RunSummary run(const Scene& scene, const TemporaryFolder& folder, rlim_t bytes) {
  const FileLimit limit(bytes);
  return run_scene(scene, plugins(), {folder.path(), "chain", {}});
}

double until(const RunSummary& summary, const std::string& file) {
  for (const CutShort& each : summary.cut_short)
    if (each.file == file) return each.until;
  return -1.0;
}

}  // namespace

TEST_CASE("a text table on a full disk ends with its last complete record, whose time is reported") {
  for (const rlim_t bytes : {5000u, 5001u, 5050u, 5100u, 5200u, 100u}) {
    CAPTURE(bytes);
    const TemporaryFolder folder;
    const RunSummary summary = run(chain_scene(), folder, bytes);
    CHECK(summary.failure == ErrorKind::simulation);
    CHECK(summary.error.find("trajectory.csv: cannot be written: File too large") != std::string::npos);
    const std::string text = testing::read_text(folder.path() / "trajectory.csv");
    CHECK(text.size() <= bytes);
    CHECK(text.ends_with('\n'));
    const testing::Csv csv = testing::read_csv(folder.path() / "trajectory.csv");
    CHECK(csv.rows.size() % 4 == 0);
    const double last = until(summary, "trajectory.csv");
    if (csv.rows.empty()) {
      CHECK(std::isnan(last));
      CHECK(summary.error.find("none of its records was written") != std::string::npos);
    } else {
      CHECK(csv.number(csv.rows.size() - 1, 0) == last);
      CHECK(summary.error.find(fmt::format("its records up to {:g} s are kept", last)) != std::string::npos);
    }
    // Such a low limit leaves no room for the summary either.
    CHECK(fs::exists(folder.path() / "summary.json") == (bytes > 2000));
    CHECK_FALSE(fs::exists(folder.path() / "summary.json.part"));
  }
}

TEST_CASE("binary tables end with their own last complete record") {
  Scene scene = chain_scene();
  scene.output.format = OutputOptions::Format::binary;
  const TemporaryFolder folder;
  const RunSummary summary = run(scene, folder, 5000);
  CHECK(summary.failure == ErrorKind::simulation);
  for (const char* name : {"trajectory", "springs"}) {
    const fs::path file = folder.path() / (std::string(name) + ".bin");
    RecordReader reader(file);
    REQUIRE(reader.records() > 1);
    std::vector<double> values;
    const double last = reader.read(reader.records() - 1, values);
    const double cut = until(summary, std::string(name) + ".bin");
    // The springs' records are half as large: they all go on until the first table fails, and end there.
    CHECK(last == (cut < 0.0 ? summary.simulated : cut));
    CAPTURE(name);
    const auto record = 8 + reader.rows().size() * reader.columns().size() * 8;
    const std::string text = testing::read_text(file);
    const auto start = static_cast<std::size_t>(std::stoul(text.substr(20, 8)));
    CHECK(fs::file_size(file) == start + reader.records() * record);
  }
  CHECK(until(summary, "trajectory.bin") < summary.simulated);
}

TEST_CASE("pictures end with the last complete one, and the index lists no other") {
  Scene scene = chain_scene();
  scene.output.trajectory = false;
  scene.output.springs.clear();
  scene.output.vtk = true;
  for (const rlim_t bytes : {4000u, 4050u, 4130u}) {
    const TemporaryFolder folder;
    const RunSummary summary = run(scene, folder, bytes);
    CHECK(summary.failure == ErrorKind::simulation);
    const std::string index = testing::read_text(folder.path() / "vtk/run.pvd");
    CHECK(index.ends_with("  </Collection>\n</VTKFile>\n"));
    std::size_t listed = 0, files = 0;
    for (std::size_t at = index.find("file=\"net_"); at != std::string::npos; at = index.find("file=\"net_", at + 1)) {
      ++listed;
      CHECK(fs::exists(folder.path() / "vtk" / index.substr(at + 6, 14)));
    }
    for (const auto& file : fs::directory_iterator(folder.path() / "vtk")) {
      files += file.path().extension() == ".vtu" ? 1 : 0;
    }
    CHECK(listed > 2);
    CHECK(files == listed);
    CHECK(until(summary, "vtk/run.pvd") == doctest::Approx(0.05 * static_cast<double>(listed - 1)));
  }
}

TEST_CASE("a page that cannot be written does not exist, but the tables do") {
  Scene scene = chain_scene();
  scene.duration = 1.0;
  scene.output.view = true;
  const TemporaryFolder folder;
  const RunSummary summary = run(scene, folder, 100000);
  CHECK(summary.error.find("view.html: cannot be written") != std::string::npos);
  CHECK_FALSE(fs::exists(folder.path() / "view.html"));
  CHECK_FALSE(fs::exists(folder.path() / "view.html.part"));
  CHECK(summary.files == std::vector<std::string>{"events.csv", "trajectory.csv", "springs.csv", "summary.json"});
  CHECK(summary.cut_short.empty());
  const auto json = nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"));
  CHECK(json["cut_short"].empty());
}

TEST_CASE("a converted table ends with a complete record, too") {
  Scene scene = chain_scene();
  scene.output.format = OutputOptions::Format::binary;
  scene.duration = 5.0;
  const TemporaryFolder folder;
  run_scene(scene, plugins(), {folder.path(), "chain", {}});
  RecordReader reader(folder.path() / "trajectory.bin");
  {
    const FileLimit limit(5000);
    CHECK_THROWS_AS(write_csv(reader, folder.path() / "text.csv"), Error);
  }
  const testing::Csv csv = testing::read_csv(folder.path() / "text.csv");
  CHECK(csv.rows.size() > 0);
  CHECK(csv.rows.size() % 4 == 0);
}
