// Binary tables: bit for bit the engine's numbers, and readable however a run ended.
#include <springnet/records.hpp>

#include <sys/stat.h>

#include <bit>
#include <cstring>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/output.hpp>

#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

// A chain that swings: all numbers have all their digits.
Scene swinging() {
  Scene scene;
  scene.network = testing::chain(5, {0.1, 0.2, 0.3}, {0.3, 0.1, 0.0}, testing::damped(50.0, 0.3), 0.7);
  scene.network.fix(0);
  scene.network.set_gravity({0.1, -0.2, -9.81});
  scene.duration = 0.5;
  scene.options.time_step = 0.01;
  scene.options.threads = 1;
  scene.output.interval = 0.05;
  scene.output.format = OutputOptions::Format::binary;
  return scene;
}

RunSummary run_swinging(const Scene& scene, const std::filesystem::path& folder) {
  const RunSummary summary = run_scene(scene, plugins(), {folder, "swinging", {}});
  CHECK_MESSAGE(!summary.failure, summary.error);
  return summary;
}

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

// A little-endian number as the page about the format describes it, read without the library.
double number_at(const std::string& bytes, std::size_t place) {
  std::uint64_t bits = 0;
  for (std::size_t k = 8; k-- > 0;) bits = bits << 8 | static_cast<unsigned char>(bytes.at(place + k));
  return std::bit_cast<double>(bits);
}

std::string refusal(const std::filesystem::path& file) {
  try {
    RecordReader reader(file);
  } catch (const Error& error) {
    return error.kind() == ErrorKind::input ? error.what() : "";
  }
  return "";
}

}  // namespace

TEST_CASE("a binary trajectory has the states of a simulation stepped by hand, bit for bit") {
  const TemporaryFolder folder;
  Scene scene = swinging();
  scene.output.force = true;
  run_swinging(scene, folder.path());
  CHECK_FALSE(std::filesystem::exists(folder.path() / "trajectory.csv"));
  RecordReader reader(folder.path() / "trajectory.bin");
  CHECK(reader.row_name() == "node");
  CHECK(reader.rows() == std::vector<std::uint32_t>{0, 1, 2, 3, 4});
  CHECK(reader.columns() == std::vector<std::string>{"x", "y", "z", "vx", "vy", "vz", "fx", "fy", "fz"});
  CHECK(reader.units() == std::vector<std::string>{"m", "m", "m", "m/s", "m/s", "m/s", "N", "N", "N"});
  CHECK_FALSE(reader.single_precision());
  REQUIRE(reader.records() == 11);

  Simulation simulation(scene.network, plugins(), scene.options);
  std::vector<double> values;
  for (std::size_t record = 0; record < 10; ++record) {  // the last one ends at the duration, a rounding beside a step
    const double time = reader.read(record, values);
    CHECK(same_bits(time, simulation.time()));
    REQUIRE(values.size() == 45);
    for (NodeIndex node = 0; node < 5; ++node) {
      for (int axis = 0; axis < 3; ++axis) {
        const double* const row = &values[9 * std::size_t{node} + static_cast<std::size_t>(axis)];
        CHECK(same_bits(row[0], simulation.position(node)[axis]));
        CHECK(same_bits(row[3], simulation.velocity(node)[axis]));
        CHECK(same_bits(row[6], simulation.force(node)[axis]));
      }
    }
    for (int step = 0; step < 5; ++step) simulation.step();
  }
}

TEST_CASE("the layout is as documented") {
  const TemporaryFolder folder;
  Scene scene = swinging();
  scene.output.nodes = {2, 4};
  scene.output.velocity = false;
  run_swinging(scene, folder.path());
  const std::string bytes = testing::read_text(folder.path() / "trajectory.bin");
  CHECK(bytes.starts_with("springnet records 1 "));
  const std::size_t start = std::stoul(bytes.substr(20, 8));
  CHECK(start % 64 == 0);
  CHECK(bytes[28] == '\n');
  CHECK(bytes[start - 1] == '\n');
  const auto table = nlohmann::json::parse(bytes.substr(29, start - 29));
  CHECK(table["row"] == "node");
  CHECK(table["rows"] == 2);
  CHECK(table["numbers"] == nlohmann::json{2, 4});
  CHECK(table["columns"] == nlohmann::json{"x", "y", "z"});
  CHECK(table["units"] == nlohmann::json{"m", "m", "m"});
  CHECK(table["type"] == "<f8");
  const std::size_t record = table["record_bytes"];
  CHECK(record == 8 + 2 * 3 * 8);
  CHECK(bytes.size() == start + 11 * record);
  // Node 4 at the start, after time and the row of node 2.
  CHECK(number_at(bytes, start) == 0.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    CHECK(number_at(bytes, start + 32 + 8 * axis) == scene.network.nodes()[4].position[static_cast<int>(axis)]);
  }
}

TEST_CASE("converted binary tables are the text tables of the same run") {
  const TemporaryFolder folder;
  Scene scene = swinging();
  scene.output.springs = {1, 3};
  run_swinging(scene, folder.path() / "binary");
  scene.output.format = OutputOptions::Format::csv;
  run_swinging(scene, folder.path() / "text");
  for (const char* name : {"trajectory", "springs"}) {
    CAPTURE(name);
    RecordReader reader(folder.path() / "binary" / (std::string(name) + ".bin"));
    const std::filesystem::path text = folder.path() / (std::string(name) + ".csv");
    write_csv(reader, text);
    CHECK(testing::read_text(text) == testing::read_text(folder.path() / "text" / text.filename()));
  }
}

TEST_CASE("single precision rounds to the nearest number, and times keep all digits") {
  const TemporaryFolder folder;
  Scene scene = swinging();
  run_swinging(scene, folder.path() / "double");
  scene.output.precision = OutputOptions::Precision::float32;
  run_swinging(scene, folder.path() / "single");
  RecordReader exact(folder.path() / "double/trajectory.bin"), rounded(folder.path() / "single/trajectory.bin");
  CHECK(rounded.single_precision());
  REQUIRE(rounded.records() == exact.records());
  std::vector<double> expected, values;
  for (std::size_t record = 0; record < exact.records(); ++record) {
    CHECK(same_bits(rounded.read(record, values), exact.read(record, expected)));
    REQUIRE(values.size() == expected.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      CHECK(values[k] == static_cast<double>(static_cast<float>(expected[k])));
    }
  }
  write_csv(rounded, folder.path() / "single.csv");
  // 0.2 m, not 0.20000000298023224 m.
  CHECK(testing::read_text(folder.path() / "single.csv").find("\n0,0,0.1,0.2,0.3,0,0,0\n") != std::string::npos);
}

TEST_CASE("a truncated file is read up to its last complete record") {
  const TemporaryFolder folder;
  run_swinging(swinging(), folder.path());
  const std::filesystem::path file = folder.path() / "trajectory.bin";
  std::vector<double> last;
  const double time = RecordReader(file).read(9, last);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
  RecordReader cut(file);
  CHECK(cut.records() == 10);
  std::vector<double> values;
  CHECK(cut.read(9, values) == time);
  CHECK(values == last);
  CHECK_THROWS_AS(cut.read(10, values), Error);
}

TEST_CASE("a file can be read during the run") {
  const TemporaryFolder folder;
  const Scene scene = swinging();
  RunOptions options{folder.path(), "swinging", {}};
  options.progress = [&](const RunProgress& now) {
    if (now.steps == 27) CHECK(RecordReader(folder.path() / "trajectory.bin").records() == 6);  // 0, 0.05, … 0.25 s
    return true;
  };
  CHECK(run_scene(scene, plugins(), options).steps == 50);
}

TEST_CASE("other files are refused with the reason") {
  const TemporaryFolder folder;
  CHECK(refusal(folder.path() / "nowhere.bin").find("nowhere.bin: cannot be read") != std::string::npos);
  folder.write("text.csv", "time,node,x,y,z\n0,0,1,2,3\n");
  CHECK(refusal(folder.path() / "text.csv").find("not a binary table") != std::string::npos);
  folder.write("empty.bin", "");
  CHECK(refusal(folder.path() / "empty.bin").find("not a binary table") != std::string::npos);
  folder.write("later.bin", "springnet records 2 00000064\n{}\n");
  CHECK(refusal(folder.path() / "later.bin").find("another version") != std::string::npos);

  run_swinging(swinging(), folder.path());
  const std::string bytes = testing::read_text(folder.path() / "trajectory.bin");
  folder.write("short.bin", bytes.substr(0, 100));
  CHECK(refusal(folder.path() / "short.bin").find("ends within its header") != std::string::npos);
  const auto damaged = [&](const std::string& what, const std::string& with) {
    std::string text = bytes;
    const std::size_t place = text.find(what);
    REQUIRE(place != std::string::npos);
    text.replace(place, what.size(), with);
    folder.write("damaged.bin", text);
    return refusal(folder.path() / "damaged.bin");
  };
  CHECK(damaged("\"rows\":5", "\"rows\":6").find("damaged header") != std::string::npos);
  CHECK(damaged("\"rows\":5", "\"rows\":-").find("damaged header") != std::string::npos);
  CHECK(damaged("<f8", "<f2").find("unknown type") != std::string::npos);
  CHECK(damaged("\"columns\"", "\"columnz\"").find("damaged header") != std::string::npos);
  CHECK(damaged("1 000", "1 x00").find("damaged header") != std::string::npos);
  CHECK(damaged("<f8", "Xyz").find("Xyz") == std::string::npos);
  const std::string rows = "\"rows\":5";
  for (const char* number : {"-5", "5.0", "1e300", "4294967296", "18446744073709551616", "\"5\"", "null", "[5]"}) {
    CAPTURE(number);
    CHECK(damaged(rows, "\"rows\":" + std::string(number)).find("damaged header") != std::string::npos);
  }
  for (const char* numbers : {"[0,1,2,3,-1]", "[0,1,2,3,1e300]", "[0,1,2,3,4294967296]", "[0,1,2,3,4.5]", "[0,1,2,3]",
                              "[0,1,2,3,[]]", "{}", "5", "[[[[[[0]]]]]]"}) {
    CAPTURE(numbers);
    CHECK(damaged("null", numbers).find("damaged header") != std::string::npos);
  }
}

TEST_CASE("memory follows the size of a file, not the promises of its header") {
  const TemporaryFolder folder;
  const auto table = [&](const std::string& description, std::size_t bytes) {
    std::string header = fmt::format("springnet records 1 {:08}\n{}", 29 + description.size() + 1, description) + '\n';
    folder.write("promise.bin", header + std::string(bytes, '\0'));
    return refusal(folder.path() / "promise.bin");
  };
  const auto rows = [](std::uint64_t count, std::uint64_t record_bytes) {
    return fmt::format(
        R"({{"row":"node","rows":{},"columns":["x"],"units":["m"],"type":"<f4","record_bytes":{},"numbers":null}})",
        count, record_bytes);
  };
  CHECK(table(rows(2, 16), 16).empty());
  CHECK(table(rows(0, 8), 8).empty());
  // A list of these numbers would take 4 GB.
  CHECK(table(rows(1'000'000'000, 4'000'000'008), 1000).find("no complete record") != std::string::npos);
  CHECK(table(rows(2, 16), 15).find("no complete record") != std::string::npos);
  CHECK(table(rows(1, 0), 16).find("damaged header") != std::string::npos);
  CHECK(table(rows(4'294'967'295, 4), 16).find("damaged header") != std::string::npos);
  // 2^64 bytes and some: the product would be small.
  CHECK(table(rows(4'611'686'018'427'387'904, 8), 16).find("damaged header") != std::string::npos);
  CHECK(table(std::string(1'000'000, '['), 16).find("damaged header") != std::string::npos);
}

TEST_CASE("a pipe is refused without waiting for it") {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder.path() / "pipe.bin";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(refusal(pipe).find("not a regular file") != std::string::npos);
  CHECK(refusal(folder.path()).find("not a regular file") != std::string::npos);
}
