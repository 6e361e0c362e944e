// Tables of observations: what is read, and what is refused.
#include <springnet/observations.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <unistd.h>

#include <springnet/error.hpp>
#include <springnet/output.hpp>

#include "facts.hpp"
#include "nets.hpp"
#include "observation_tables.hpp"
#include "repetitions.hpp"
#include "temporary_folder.hpp"

namespace springnet::testing {
namespace {

using Place = Observations::Place;

bool same(const std::vector<Observations::VectorRow>& a, const std::vector<Observations::VectorRow>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& p, const auto& q) {
    return p.time == q.time && p.node == q.node && p.value == q.value && p.weight == q.weight;
  });
}

// A chain that swings from a held node, and falls on a plane whose name needs quotation marks in a table.
Scene swinging() {
  Scene scene;
  scene.network = chain(4, {0.1, 0.2, 0.3}, {0.3, 0.1, 0.0}, damped(50.0, 0.3), 0.7);
  scene.network.fix(0);
  scene.network.set_gravity({0.1, -0.2, -9.81});
  Plane floor;
  floor.name = "floor, \"wet\"";
  floor.point = {0.0, 0.0, 0.1};
  scene.network.add_plane(floor);
  scene.duration = 0.5;
  scene.options.time_step = 0.01;
  scene.options.threads = 1;
  scene.output.interval = 0.05;
  scene.output.reactions = true;
  scene.output.force = true;
  return scene;
}

void run(const Scene& scene, const std::filesystem::path& folder) {
  const RunSummary summary = run_scene(scene, plugins(), {folder, "swinging", {}});
  REQUIRE_MESSAGE(!summary.failure, summary.error);
}

TEST_CASE("tables of a run are read to the last bit; its net forces are not observed, its reactions are") {
  const TemporaryFolder folder;
  Scene scene = swinging();
  run(scene, folder.path());
  const Observations trajectory = read_observations(folder.path() / "trajectory.csv");
  REQUIRE(trajectory.positions.size() == 44);
  REQUIRE(trajectory.velocities.size() == 44);
  CHECK(trajectory.reactions.empty());
  CHECK(trajectory.value_count() == 2 * 3 * 44);

  const Observations reactions = read_observations(folder.path() / "reactions.csv");
  CHECK(reactions.positions.empty());
  CHECK(reactions.velocities.empty());

  Simulation simulation(scene.network, plugins(), scene.options);
  std::size_t reaction = 0, of_floor = 0;
  for (std::size_t record = 0; record < 10; ++record) {  // the last one ends at the duration, a rounding beside a step
    for (NodeIndex node = 0; node < 4; ++node) {
      const auto& position = trajectory.positions[4 * record + node];
      const auto& velocity = trajectory.velocities[4 * record + node];
      CHECK(position.time == simulation.time());
      CHECK(position.node == node);
      CHECK(position.place.line == 2 + 4 * record + node);
      CHECK(position.value == simulation.position(node));
      CHECK(velocity.value == simulation.velocity(node));
      CHECK(position.weight == Vector3::Ones());
      while (reaction < reactions.reactions.size() && reactions.reactions[reaction].time == simulation.time() &&
             reactions.reactions[reaction].node == node) {
        CHECK(reactions.reactions[reaction].value == simulation.reaction(node));
        if (node > 0) ++of_floor;
        ++reaction;
      }
    }
    for (int step = 0; step < 5; ++step) simulation.step();
  }
  CHECK(of_floor > 0);  // rows with a name in quotation marks
  const double last = reactions.reactions.back().time;
  CHECK(reaction == static_cast<std::size_t>(std::count_if(reactions.reactions.begin(), reactions.reactions.end(),
                                                           [&](const auto& row) { return row.time < last; })));
  CHECK(objection(trajectory).empty());
  Observations both = trajectory;
  both.append(reactions);
  CHECK(objection(both).empty());
  CHECK(has_facts(refusal_of_file(folder.path() / "surfaces.csv"), "surfaces.csv:1: | surfaces"));
  CHECK(has_facts(refusal_of_file(folder.path() / "events.csv"), "events.csv:1: | no"));

  scene.output.format = OutputOptions::Format::binary;
  run(scene, folder.path());
  const Observations binary = read_observations(folder.path() / "trajectory.bin");
  CHECK(same(binary.positions, trajectory.positions));
  CHECK(same(binary.velocities, trajectory.velocities));
  CHECK(binary.reactions.empty());
  CHECK(binary.text_of(binary.positions[9].place) == (folder.path() / "trajectory.bin").string() + ": record 2");
}

TEST_CASE("binary tables of anything but nodes, with infinite numbers or cut off are refused") {
  const TemporaryFolder folder;
  Scene scene = swinging();
  scene.output.format = OutputOptions::Format::binary;
  scene.output.springs = {0, 1};
  run(scene, folder.path());
  CHECK(has_facts(refusal_of_file(folder.path() / "springs.bin"), "springs.bin: | 'spring'"));
  std::string bytes = read_text(folder.path() / "trajectory.bin");
  const std::size_t start = std::stoul(bytes.substr(20, 8)), record = 8 + 4 * 9 * 8;
  const auto with = [&](std::size_t place, double value) {
    std::string changed = bytes;
    std::memcpy(changed.data() + place, &value, sizeof value);
    folder.write("changed.bin", changed);
    return folder.path() / "changed.bin";
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  CHECK(has_facts(refusal_of_file(with(start + 2 * record + 8 + 9 * 8 + 8, infinity)),
                  "changed.bin: record 2, node 1: | 'y' | infinite"));
  CHECK(has_facts(refusal_of_file(with(start + record, nan)), "changed.bin: record 1: | 'time'"));
  const Observations missing = read_observations(with(start + 8, nan));
  CHECK(missing.positions[0].weight == Vector3(0, 1, 1));
  CHECK(missing.positions[0].value[0] == 0.0);
  folder.write("changed.bin", bytes.substr(0, start + record + 5));
  CHECK(read_observations(folder.path() / "changed.bin").positions.size() == 4);
  folder.write("changed.bin", bytes.substr(0, start - 5));
  CHECK(has_facts(refusal_of_file(folder.path() / "changed.bin"), "changed.bin: | header"));
}

TEST_CASE(
    "spreadsheets: byte order mark, CR LF, comments, blank lines, quotation marks, spaces, order of the columns") {
  const Observations read_back = read(
      "\xEF\xBB\xBF# measured on Monday, \"by hand\"\r\n\r\n \"y\", node ,time,x,\"z\" \r\n"
      " 1.5 ,3,\t0,\"+2\",-2e-3\r\n  # a break\n\n-1e-320,\"4.0\" , .5 ,1e1,\" 7 \"\n1,1e1,0.50,2,3");
  REQUIRE(read_back.positions.size() == 3);
  const auto& rows = read_back.positions;
  CHECK(rows[0].time == 0.0);
  CHECK(rows[0].node == 3);
  CHECK(rows[0].value == Vector3(2.0, 1.5, -2e-3));
  CHECK(rows[0].place.line == 4);
  CHECK(rows[1].time == 0.5);
  CHECK(rows[1].node == 4);
  CHECK(rows[1].value == Vector3(10.0, -1e-320, 7.0));
  CHECK(rows[1].place.line == 7);
  CHECK(rows[2].node == 10);
  CHECK(rows[2].place.line == 8);
}

TEST_CASE("absent columns and missing values are 0 with weight 0") {
  const Observations read_back = read("time,node,x,z,vy\n0,1,0.5,,3\n1,1,nan,2,NaN\n2,1,-nan,,\n2,2,\"\", \t,nan\n");
  const auto& positions = read_back.positions;
  const auto& velocities = read_back.velocities;
  REQUIRE(positions.size() == 4);
  REQUIRE(velocities.size() == 4);
  CHECK(positions[0].value == Vector3(0.5, 0, 0));
  CHECK(positions[0].weight == Vector3(1, 0, 0));
  CHECK(positions[1].value == Vector3(0, 0, 2));
  CHECK(positions[1].weight == Vector3(0, 0, 1));
  CHECK(velocities[0].value == Vector3(0, 3, 0));
  CHECK(velocities[0].weight == Vector3(0, 1, 0));
  CHECK(velocities[1].weight == Vector3::Zero());
  for (std::size_t row : {2u, 3u}) {
    CHECK(positions[row].value == Vector3::Zero());
    CHECK(positions[row].weight == Vector3::Zero());
  }
  CHECK(read_back.value_count() == 3);
  CHECK(read_back.times() == std::vector<double>{0, 1});
}

TEST_CASE("weights are factors, standard deviations give 1/s^2, both their product") {
  const auto first_weight = [](const std::string& text) { return read(text).positions.at(0).weight; };
  CHECK(first_weight("time,node,x,y,z\n0,1,1,1,1\n") == Vector3::Ones());
  CHECK(first_weight("time,node,x,y,z,weight\n0,1,1,1,1,2.5\n") == Vector3::Constant(2.5));
  CHECK(first_weight("time,node,x,y,z,s\n0,1,1,1,1,0.5\n") == Vector3::Constant(4.0));
  CHECK(first_weight("time,node,x,y,z,s,weight\n0,1,1,,1,0.5,3\n") == Vector3(12, 0, 12));
  CHECK(first_weight("time,node,x,y,z,sz,sx,sy\n0,1,1,1,1,1,0.25,0.5\n") == Vector3(16, 4, 1));
  CHECK(first_weight("time,node,x,y,sx,sy\n0,1,1,1,0.25,0.5\n") == Vector3(16, 4, 0));
  CHECK(first_weight("time,node,x,y,z,weight\n0,1,1,1,1,0\n") == Vector3::Zero());
  // Without a value there is nothing to weigh.
  CHECK(first_weight("time,node,x,y,z,s,weight\n0,1,,,,,\n") == Vector3::Zero());
  CHECK(first_weight("time,node,x,y,sx,sy\n0,1,2,,0.5,\n") == Vector3(4, 0, 0));

  const Observations all = read("time,node,x,sx,vx,vy,sv,rz,sr\n0,1,1,0.5,2,3,0.25,4,2\n");
  CHECK(all.positions.at(0).weight == Vector3(4, 0, 0));
  CHECK(all.velocities.at(0).weight == Vector3(16, 16, 0));
  CHECK(all.reactions.at(0).value == Vector3(0, 0, 4));
  CHECK(all.reactions.at(0).weight == Vector3(0, 0, 0.25));
  CHECK(read("time,node,vx,s\n0,1,1,0.5\n").velocities.at(0).weight == Vector3(4, 0, 0));
  CHECK(read("time,node,fx,fy,fz,tx,s\n0,1,1,2,3,9,0.5\n").reactions.at(0).weight == Vector3(4, 4, 4));
  CHECK(read("time,x,y,z,s,weight\n0,1,2,3,0.5,2\n").surface_points.at(0).weight == 8.0);
  CHECK(read("time,node,other,distance,s\n0,1,2,3,0.5\n").distances.at(0).weight == 4.0);
}

TEST_CASE("reactions are rx,ry,rz, or fx,fy,fz beside columns of reactions.csv") {
  for (const char* beside : {"tx", "ty", "tz", "jx", "jy", "jz", "surface"}) {
    CAPTURE(beside);
    const Observations reactions = read(std::string("time,node,fx,fy,fz,") + beside + "\n0,3,1,2,3,not read\n");
    REQUIRE(reactions.reactions.size() == 1);
    CHECK(reactions.reactions[0].value == Vector3(1, 2, 3));
    CHECK(reactions.reactions[0].node == 3);
    CHECK(reactions.positions.empty());
    CHECK(has_facts(refusal(std::string("time,node,x,y,z,") + beside + "\n"),
                    "a.csv:1: | '" + std::string(beside) + "'"));
    CHECK(has_facts(refusal(std::string("time,node,x,fx,") + beside + "\n"), "a.csv:1: | rx,ry,rz"));
  }
  const Observations named = read("time,node,x,y,z,fx,fy,fz,rx,ry,rz\n0,3,1,2,3,net,net,net,7,8,9\n");
  REQUIRE(named.reactions.size() == 1);
  CHECK(named.reactions[0].value == Vector3(7, 8, 9));
  CHECK(named.positions.at(0).value == Vector3(1, 2, 3));
  CHECK(read("time,node,rx,ry,rz,surface\n0,3,7,8,9,floor\n").reactions.at(0).value == Vector3(7, 8, 9));
  CHECK(has_facts(refusal("time,node,fx,fy,fz\n0,3,1,2,3\n"), "a.csv:1: | rx,ry,rz"));
  CHECK(has_facts(refusal("time,node,rx,fx,tx\n0,3,1,2,3\n"), "a.csv:1: | rx,ry,rz"));
}

TEST_CASE("points of a surface and distances") {
  const Observations points = read("time,x,y,z\n0,1,2,3\n0,4,5,6\n1,7,,9\n");
  REQUIRE(points.surface_points.size() == 3);
  CHECK(points.surface_points[1].time == 0.0);
  CHECK(points.surface_points[1].point == Vector3(4, 5, 6));
  CHECK(points.surface_points[1].weight == 1.0);
  CHECK(points.surface_points[1].place.line == 3);
  CHECK(points.surface_points[2].point == Vector3::Zero());
  CHECK(points.surface_points[2].weight == 0.0);
  CHECK(points.value_count() == 2);
  CHECK(points.times() == std::vector<double>{0});

  const Observations distances = read("distance,time,node,other\n0.25,1,2,3\nnan,1,3,4\n0,2,2,3\n");
  REQUIRE(distances.distances.size() == 3);
  CHECK(distances.distances[0].distance == 0.25);
  CHECK(distances.distances[0].time == 1.0);
  CHECK(distances.distances[0].node == 2);
  CHECK(distances.distances[0].other == 3);
  CHECK(distances.distances[0].weight == 1.0);
  CHECK(distances.distances[1].weight == 0.0);
  CHECK(distances.value_count() == 2);
  CHECK(distances.times() == std::vector<double>{1, 2});
}

TEST_CASE("columns that do not say clearly what is observed are refused at the header line") {
  const std::pair<const char*, const char*> headers[] = {
      {"time,node,x,y,zz", "'zz' | no column | remove"},
      {"time,nodes,x", "'nodes' | 'node'"},
      {"Time,node,x", "'Time' | 'time'"},
      {"time,node,X", "'X' | 'x'"},
      {"time,node,x,sigma", "'sigma' | time,node"},
      {"time,node,x,y,z,", "column 6 has no name"},
      {"time,node,x,x", "two columns | 'x'"},
      {"node,x,y,z", "'time'"},
      {"time", "no column says"},
      {"time,node", "no column says"},
      {"time,node,weight", "no column says"},
      {"time,spring,length,tension", "'spring'"},
      {"time;node;x", "commas"},
      {"time\tnode\tx", "commas"},
      {"time node x", "commas"},
      {"time,x,y", "x,y,z | 'node'"},
      {"time,vx,vy,vz", "'node'"},
      {"time,x,y,z,vx", "'node'"},
      {"time,rx", "'node'"},
      {"time,node,distance", "time,node,other,distance"},
      {"time,node,other", "time,node,other,distance"},
      {"time,other,distance", "time,node,other,distance"},
      {"time,node,other,distance,x", "a file of their own"},
      {"time,node,other,distance,vx", "a file of their own"},
      {"time,node,other,distance,sx", "'sx' | 's'"},
      {"time,x,y,z,sx", "'sx' | 's'"},
      {"time,node,x,vx,s", "'s' | sx,sy,sz | sv | sr"},
      {"time,node,x,s,sx", "'s' | 'sx'"},
      {"time,node,x,sx,sy", "'sy' | 'y'"},
      {"time,node,x,sx,sv", "'sv' | velocities"},
      {"time,node,x,sx,sr", "'sr' | reactions"},
      {"time,node,x,y,sx", "positions | sx,sy,sz"},
      {"time,node,x,vx,sx", "velocities | sv"},
      {"time,node,x,vx,sv", "positions | sx,sy,sz"},
      {"time,node,vx,rx,sv", "reactions | sr"},
  };
  for (const auto& [header, facts] : headers) {
    CAPTURE(header);
    CHECK(has_facts(refusal("# note\n" + std::string(header) + "\n"), std::string("a.csv:2: | ") + facts));
  }
}

TEST_CASE("cells that are wrong are refused with line and column") {
  const std::pair<const char*, const char*> tables[] = {
      {"time,node,x\n0,1,2\n\n0,2\n", "a.csv:4: | 2 cells | 3"},
      {"time,node,x\n0,1,2\n0,2,3,4\n", "a.csv:3: | 4 cells | 3"},
      {"time,node,x\n0,1,2,\n", "a.csv:2: | 4 cells | 3"},
      {"time,node,x\n0,1,two\n", "a.csv:2: | 'x' | 'two' | empty"},
      {"time,node,x\n0,1,2 3\n", "a.csv:2: | 'x' | '2 3'"},
      {"time,node,x\n0,1,\"1,5\"\n", "a.csv:2: | 'x' | '1,5' | point"},
      {"time,node,x\n0,1,0x10\n", "a.csv:2: | 'x' | '0x10'"},
      {"time,node,x\n0,1,inf\n", "a.csv:2: | 'x' | infinite"},
      {"time,node,x\n0,1,-Infinity\n", "a.csv:2: | 'x' | infinite"},
      {"time,node,x\n0,1,1e999\n", "a.csv:2: | 'x' | infinite"},
      {"time,node,x\ninf,1,1\n", "a.csv:2: | 'time' | infinite"},
      {"time,node,x\n,1,1\n", "a.csv:2: | 'time' | no value"},
      {"time,node,x\nnan,1,1\n", "a.csv:2: | 'time' | no value"},
      {"time,node,x\n0,,1\n", "a.csv:2: | 'node' | no value"},
      {"time,node,x\n0,-1,1\n", "a.csv:2: | 'node' | -1"},
      {"time,node,x\n0,1.5,1\n", "a.csv:2: | 'node' | 1.5 | whole"},
      {"time,node,x\n0,4294967296,1\n", "a.csv:2: | 'node' | 4294967296"},
      {"time,node,other,distance\n0,1,-2,1\n", "a.csv:2: | 'other' | -2"},
      {"time,node,other,distance\n0,1,2,-0.5\n", "a.csv:2: | 'distance' | -0.5"},
      {"time,node,x,weight\n0,1,1,-2\n", "a.csv:2: | 'weight' | -2"},
      {"time,node,x,weight\n0,1,1,\n", "a.csv:2: | 'weight' | no value"},
      {"time,node,x,weight\n0,1,1,inf\n", "a.csv:2: | 'weight' | infinite"},
      {"time,node,x,s\n0,1,1,0\n", "a.csv:2: | 's' | 0"},
      {"time,node,x,s\n0,1,1,-0.5\n", "a.csv:2: | 's' | -0.5"},
      {"time,node,x,s\n0,1,1,nan\n", "a.csv:2: | 's' | no value"},
      {"time,node,x,s\n0,1,1,1e-200\n", "a.csv:2: | 's' | 1e-200 | inf"},
      {"time,node,x,s\n0,1,1,1e200\n", "a.csv:2: | 's' | 1e+200 | weight 0"},
      {"time,x,y,z,weight\n0,1,1,1,-1\n", "a.csv:2: | 'weight' | -1"},
      {"time,node,x\n0,1,\"2\n0,2,3\n", "a.csv:2: | quotation mark | cell 3"},
      {"time,node,x\n0,\"1\"2,3\n", "a.csv:2: | quotation mark | cell 2"},
      {"time,\"node\"\"\n0,1\n", "a.csv:1: | quotation mark | cell 2"},
  };
  for (const auto& [text, facts] : tables) {
    CAPTURE(text);
    CHECK(has_facts(refusal(text), facts));
  }
  CHECK(has_facts(refusal(std::string("time,node,x\n0,1,2\0\n", 19)), "a.csv:2: | 'x' | \\u0000"));
  CHECK(has_facts(refusal("time,node,x\n0,1," + std::string(500, '7') + "a\n"), "a.csv:2: | 'x' | 501 characters"));
}

TEST_CASE("the largest and smallest numbers are kept") {
  const Observations read_back = read(
      "time,node,x,y,z\n1.7976931348623157e308,4294967295,-1.7976931348623157e308,4.9406564584124654e-324,1e-999\n");
  const auto& row = read_back.positions.at(0);
  CHECK(row.time == std::numeric_limits<double>::max());
  CHECK(row.node == 4294967295u);
  CHECK(row.value == Vector3(std::numeric_limits<double>::lowest(), std::numeric_limits<double>::denorm_min(), 0.0));
  CHECK(row.weight == Vector3::Ones());
}

TEST_CASE("files that are empty, cut off, folders, devices or no tables") {
  const Tables tables;
  CHECK(has_facts(refusal(""), "a.csv:1: | header line"));
  CHECK(has_facts(refusal("\xEF\xBB\xBF"), "a.csv:1: | header line"));
  CHECK(has_facts(refusal("# nothing\n\n"), "a.csv:2: | header line"));
  const Observations header_alone = tables.read("time,node,x");
  CHECK(header_alone.positions.empty());
  CHECK(header_alone.value_count() == 0);
  CHECK(has_facts(objection(header_alone), "a.csv: nothing is observed"));

  CHECK(has_facts(refusal("time,node,x,y\n0,1,2,3\n0,2,3"), "a.csv:3: | ends within this row | 3 of 4"));
  CHECK(has_facts(refusal("time,node,x,y\n0,1,2,3\n0"), "a.csv:3: | ends within this row | 1 of 4"));
  CHECK(read("time,node,x,y\n0,1,2,3\n0,2,3,4").positions.size() == 2);

  CHECK(has_facts(refusal_of_file(tables.path() / "none.csv"), "none.csv: | cannot be read"));
  CHECK(has_facts(refusal_of_file(tables.path()), "it is a folder"));
  CHECK(has_facts(refusal_of_file("/dev/null"), "/dev/null:1: | header line"));
  CHECK(has_facts(refusal_of_file("/dev/zero"), "/dev/zero:1: | more than 1,000,000 bytes"));
  CHECK(has_facts(refusal(std::string("\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'shape': (3, 4)}\n", 42)),
                  "a.csv:1: | not text | CSV"));
  CHECK(has_facts(refusal(std::string("\xFF\xFEt\0i\0m\0e\0,\0x\0\n\0", 16)), "a.csv:1: | not text | UTF-8"));
  CHECK(has_facts(refusal("time,node,x\r0,1,2\r"), "a.csv:1: | LF"));
  CHECK(has_facts(refusal("time,node,x\n" + std::string(1'100'000, '0') + ",1,2\n"), "a.csv:2: | 1,000,000 bytes"));
  CHECK(read("time,node,x\n" + std::string(900'000, '0') + ",1,2\n").positions.at(0).value[0] == 2.0);
}

TEST_CASE("a pipe is read to its end, as that of a program which unpacks a table") {
  const std::string text = "time,node,x\n0,1,2\n0,2,3\n";
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  REQUIRE(write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  close(ends[1]);
  const Observations read_back = read_observations("/dev/fd/" + std::to_string(ends[0]));
  close(ends[0]);
  REQUIRE(read_back.positions.size() == 2);
  CHECK(read_back.positions[1].value[0] == 3.0);
}

TEST_CASE("a table of 300,000 rows takes a moment") {
  const TemporaryFolder folder;
  constexpr std::size_t rows = 300'000, nodes = 1000;
  std::string text = "time,node,x,y,z,vx,vy,vz\n";
  for (std::size_t k = 0; k < rows; ++k)
    text += std::to_string(k / nodes) + "," + std::to_string(k % nodes) + "," + std::to_string(k) +
            ".123456789012,-0.5,1e-3,,2,3\n";
  folder.write("large.csv", text);
  const std::clock_t begin = std::clock();
  const Observations read_back = read_observations(folder.path() / "large.csv");
  check_observations(read_back, nodes, 0.0, 300.0);
  CHECK((std::clock() - begin) / CLOCKS_PER_SEC < 10);
  REQUIRE(read_back.positions.size() == rows);
  CHECK(read_back.value_count() == 5 * rows);
  CHECK(read_back.times().size() == rows / nodes);
  double greatest_error = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    const auto& row = read_back.positions[k];
    greatest_error = std::max(greatest_error, std::abs(row.value[0] - static_cast<double>(k) - 0.123456789012));
    if (row.node != k % nodes || row.place.line != k + 2) greatest_error = 1.0;
  }
  CHECK(greatest_error < 1e-9);
}

bool is_finite(const Observations& observations) {
  bool finite = true;
  const auto look_at = [&](double value, double weight) {
    finite = finite && std::isfinite(value) && std::isfinite(weight) && weight >= 0.0;
  };
  for (const auto* rows : {&observations.positions, &observations.velocities, &observations.reactions}) {
    for (const auto& row : *rows) {
      look_at(row.time, 0.0);
      for (int c = 0; c < 3; ++c) look_at(row.value[c], row.weight[c]);
    }
  }
  for (const auto& row : observations.distances) look_at(row.distance + row.time, row.weight);
  for (const auto& row : observations.surface_points) look_at(row.point.sum(), row.weight);
  return finite;
}

std::string damaged(std::string text, std::mt19937& random) {
  static const std::vector<std::string> pieces{"nan", "inf",          "1e999",  "-",    "\"", "\n", "\r", "#",
                                               ",",   ",,",           "e",      "0",    "9",  ".",  "\t", "x",
                                               "s",   "\xEF\xBB\xBF", "weight", "\n\n", " "};
  for (auto changes = 1 + random() % 3; changes > 0; --changes) {
    const std::size_t at = random() % text.size();
    switch (random() % 9) {
      case 0:
        text[at] = static_cast<char>(text[at] ^ static_cast<char>(1U << random() % 8));
        break;
      case 1:
        text[at] = static_cast<char>(random() % 256);
        break;
      case 2:
        text.insert(at, pieces[random() % pieces.size()]);
        break;
      case 3:
        text.erase(at, 1 + random() % 8);
        break;
      case 4:
        text.insert(random() % text.size(), text.substr(at, 1 + random() % 30));
        break;
      case 5:
        if (random() % 4 == 0) text.resize(at);
        break;
      default:
        if (text[at] >= '0' && text[at] <= '9') text[at] = static_cast<char>('0' + random() % 10);
    }
    if (text.empty()) text = ",";
  }
  return text;
}

TEST_CASE("damaged tables give an error of input or finite observations") {
  const std::vector<std::string> good{
      "time,node,x,y,z,vx,vy,vz\n0,0,0.1,0.2,0.3,0,0,0\n0,1,0.4,,0.3,0,nan,-1e-3\n0.5,0,0.1,0.2,0.3,0,0,0\n",
      "# a\ntime,node,x,y,z,sx,sy,sz,weight\r\n0,0,0.1,0.2,0.3,0.01,0.02,0.01,1\r\n1,\"1\",0.4,0.2,,1e-3,2,,0.5\r\n",
      "time,node,fx,fy,fz,tx,ty,tz,jx,jy,jz,surface\n0,0,1,2,3,4,5,6,0,0,0,\"a, \"\"b\"\"\"\n",
      "time,x,y,z,s\n0,1,2,3,0.1\n0,4,5,6,0.1\n2,7,8,9,0.2", "time,node,other,distance\n0,1,2,0.5\n1,2,3,0.25\n"};
  const Tables tables;
  std::mt19937 random(1);  // gives the same numbers everywhere
  const std::uint64_t tries = repetitions("SPRINGNET_OBSERVATION_MUTATIONS", 100'000);
  const std::string beginning = (tables.path() / "a.csv").string() + ":";
  std::uint64_t refused = 0, refused_by_check = 0;
  for (std::uint64_t k = 0; k < tries; ++k) {
    const std::string text = damaged(good[k % good.size()], random);
    std::string message;
    try {
      const Observations read_back = tables.read(text);
      if (!is_finite(read_back)) FAIL("not finite: " << text);
      try {
        check_observations(read_back, 4, 0.0, 2.0);
      } catch (const Error& error) {
        ++refused_by_check;
        message = error.what();
      }
    } catch (const Error& error) {
      ++refused;
      if (error.kind() != ErrorKind::input) FAIL("another kind of error: " << text);
      message = error.what();
    }
    if (!message.empty() && !message.starts_with(beginning)) FAIL(message << " does not name the file: " << text);
  }
  CHECK(refused > tries / 4);
  CHECK(refused_by_check > tries / 100);
  CHECK(refused + refused_by_check < tries * 9 / 10);
  MESSAGE(tries << " damaged tables: " << refused << " refused as they are read, " << refused_by_check << " later");
}

}  // namespace
}  // namespace springnet::testing
