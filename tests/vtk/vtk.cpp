// Files for ParaView, read back by the rules of VTK's XML formats, without the library that writes them.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Geometry>
#include <springnet/output.hpp>

#include "csv.hpp"
#include "nets.hpp"
#include "temporary_folder.hpp"
#include "vtk/surface_shapes.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

std::string attribute(const std::string& tag, const std::string& name) {
  const std::size_t place = tag.find(" " + name + "=\"");
  if (place == std::string::npos) return "";
  const std::size_t begin = place + name.size() + 3;
  return tag.substr(begin, tag.find('"', begin) - begin);
}

struct Array {
  std::string section, type;
  std::size_t components = 1;
  std::vector<double> values;  // every number in the file is one
};

struct Grid {
  std::string text;
  std::size_t points = 0, cells = 0;
  std::map<std::string, Array> arrays;
};

double decode(const std::string& type, const char* bytes) {
  const auto as = [&](auto value) {
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
  };
  if (type == "Float64") return as(double{});
  if (type == "Float32") return as(float{});
  if (type == "Int64") return as(std::int64_t{});
  return as(std::uint8_t{});
}

Grid read(const std::filesystem::path& file) {
  Grid grid;
  grid.text = testing::read_text(file);
  const std::string& text = grid.text;
  REQUIRE(text.find("byte_order=\"LittleEndian\" header_type=\"UInt64\"") != std::string::npos);
  const std::size_t data = text.find('_', text.find("<AppendedData encoding=\"raw\">")) + 1;
  REQUIRE(data != 0);
  REQUIRE(text.ends_with("\n  </AppendedData>\n</VTKFile>\n"));
  const std::map<std::string, std::size_t> sizes{{"Float64", 8}, {"Float32", 4}, {"Int64", 8}, {"UInt8", 1}};
  std::string section;
  std::size_t end = data;
  for (std::size_t open = text.find('<'); open < data; open = text.find('<', open + 1)) {
    const std::string tag = text.substr(open, text.find('>', open) - open);
    if (tag.starts_with("<Piece")) {
      grid.points = std::stoul(attribute(tag, "NumberOfPoints"));
      const std::string polygons = attribute(tag, "NumberOfPolys");
      grid.cells = std::stoul(polygons.empty() ? attribute(tag, "NumberOfCells") : polygons);
    }
    if (!tag.starts_with("<DataArray")) {
      if (!tag.starts_with("</")) section = tag.substr(1);
      continue;
    }
    Array array{section, attribute(tag, "type"), 1, {}};
    const std::string components = attribute(tag, "NumberOfComponents");
    if (!components.empty()) array.components = std::stoul(components);
    const std::size_t offset = data + std::stoul(attribute(tag, "offset"));
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, text.data() + offset, 8);
    const std::size_t size = sizes.at(array.type);
    for (std::size_t k = 0; k < bytes / size; ++k) {
      array.values.push_back(decode(array.type, text.data() + offset + 8 + k * size));
    }
    end = std::max(end, offset + 8 + static_cast<std::size_t>(bytes));
    grid.arrays[attribute(tag, "Name")] = array;
  }
  // Nothing follows the last array.
  CHECK(text.size() == end + std::strlen("\n  </AppendedData>\n</VTKFile>\n"));
  return grid;
}

struct Entry {
  double time;
  std::string part, file;
};

std::vector<Entry> read_index(const std::filesystem::path& file) {
  const std::string text = testing::read_text(file);
  CHECK(text.starts_with("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\""));
  CHECK(text.ends_with("  </Collection>\n</VTKFile>\n"));
  std::vector<Entry> entries;
  for (std::size_t open = text.find("<DataSet"); open != std::string::npos; open = text.find("<DataSet", open + 1)) {
    const std::string tag = text.substr(open, text.find('>', open) - open);
    entries.push_back({std::stod(attribute(tag, "timestep")), attribute(tag, "part"), attribute(tag, "file")});
  }
  return entries;
}

// Two tetrahedra of springs with a face, a rigid connection, a cut, a floor and a ball that moves.
Scene scene_of_everything() {
  Scene scene;
  Network& net = scene.network;
  const MaterialIndex material = net.add_material(testing::damped(60.0, 1.0));
  const MaterialIndex damper = net.add_material({std::nullopt, LawUse{"linear", {{"damping", 0.5}}}});
  for (const Vector3& place : {Vector3(0, 0, 0.01), Vector3(1, 0, 0.01), Vector3(0, 1, 0.2), Vector3(0, 0, 1.3),
                               Vector3(3, 0, 5), Vector3(4, 0, 5)}) {
    net.add_node(testing::point(place));
  }
  net.begin_body("more");
  for (const auto& [a, b] : {std::pair{0U, 1U}, {0U, 2U}, {1U, 2U}, {0U, 3U}, {1U, 3U}}) net.add_spring(a, b, material);
  net.add_spring(2, 3, damper);
  const MaterialIndex soft = net.add_material(testing::damped(1.0, 0.0));
  net.add_spring(3, 4, soft, 0.0);  // no rest length: no strain
  net.add_face({0, 1, 3});
  net.end_body();
  net.add_rigid(4, 5);
  net.fix(4);
  net.set_gravity({0, 0, -10});
  net.add_cut({0.12, {2}, {}});
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ(), {}, std::nullopt});
  Motion motion;
  motion.interpolation = Motion::Interpolation::linear;
  motion.times = {0.0, 1.0};
  motion.displacements = {Vector3::Zero(), Vector3(0, 2, 0)};
  net.add_instrument({"ball", Vector3(9, 9, 9), Vector3(9, 9, 9), 0.5, {}, motion});
  scene.duration = 0.3;
  scene.options.time_step = 0.01;
  scene.options.threads = 1;
  scene.output.interval = 0.1;
  scene.output.vtk = true;
  return scene;
}

RunSummary run(const Scene& scene, const TemporaryFolder& folder) {
  const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "vtk", {}});
  CHECK_MESSAGE(!summary.failure, summary.error);
  return summary;
}

Vector3 vector(const Grid& grid, const std::string& name, std::size_t index) {
  const std::vector<double>& values = grid.arrays.at(name).values;
  return {values.at(3 * index), values.at(3 * index + 1), values.at(3 * index + 2)};
}

}  // namespace

TEST_CASE("a record for ParaView has positions, springs and all data of the state, bit for bit") {
  const TemporaryFolder folder;
  const Scene scene = scene_of_everything();
  const RunSummary summary = run(scene, folder);
  CHECK(std::count(summary.files.begin(), summary.files.end(), "vtk/run.pvd") == 1);
  const std::vector<Entry> index = read_index(folder.path() / "vtk/run.pvd");
  REQUIRE(index.size() == 8);  // net and surfaces at 0, 0.1, 0.2, 0.3 s

  Simulation simulation(scene.network, plugins(), scene.options);
  bool touched = false;
  for (std::size_t record = 0; record < 3; ++record) {  // the last one ends at the duration, a rounding beside a step
    if (record > 0) {
      for (int step = 0; step < 10; ++step) simulation.step();
    }
    CAPTURE(record);
    CHECK(index[2 * record].time == simulation.time());
    CHECK(index[2 * record].part == "0");
    const Grid grid = read(folder.path() / "vtk" / index[2 * record].file);
    CHECK(grid.points == 6);
    REQUIRE(grid.cells == 9);  // seven springs, a rigid connection, a face
    CHECK(grid.arrays.at("TimeValue").values == std::vector<double>{simulation.time()});
    CHECK(grid.arrays.at("types").values == std::vector<double>{3, 3, 3, 3, 3, 3, 3, 3, 5});
    CHECK(grid.arrays.at("offsets").values == std::vector<double>{2, 4, 6, 8, 10, 12, 14, 16, 19});
    CHECK(grid.arrays.at("connectivity").values ==
          std::vector<double>{0, 1, 0, 2, 1, 2, 0, 3, 1, 3, 2, 3, 3, 4, 4, 5, 0, 1, 3});
    CHECK(grid.arrays.at("kind").values == std::vector<double>{0, 0, 0, 0, 0, 0, 0, 2, 1});
    CHECK(grid.arrays.at("number").values == std::vector<double>{0, 1, 2, 3, 4, 5, 6, 0, 0});
    CHECK(grid.arrays.at("node").values == std::vector<double>{0, 1, 2, 3, 4, 5});
    CHECK(grid.arrays.at("fixed").values == std::vector<double>{0, 0, 0, 0, 1, 0});
    for (const char* name : {"velocity", "force", "contact", "node", "fixed"}) {
      CHECK(grid.arrays.at(name).section == "PointData");
    }
    for (const char* name : {"tension", "energy", "strain", "broken", "kind", "number"}) {
      CHECK(grid.arrays.at(name).section == "CellData");
    }
    std::vector<double> tensions, energies;
    simulation.tensions(tensions);
    simulation.spring_energies(energies);
    for (NodeIndex node = 0; node < 6; ++node) {
      CHECK(vector(grid, "Points", node) == simulation.position(node));
      CHECK(vector(grid, "velocity", node) == simulation.velocity(node));
      CHECK(vector(grid, "force", node) == simulation.force(node));
      const double contact = grid.arrays.at("contact").values.at(node);
      CHECK(contact == (simulation.held(node) ? 2.0 : simulation.touching(node) ? 1.0 : 0.0));
      touched = touched || contact > 0.0;
    }
    for (SpringIndex spring = 0; spring < 7; ++spring) {
      CAPTURE(spring);
      CHECK(grid.arrays.at("tension").values.at(spring) == tensions[spring]);
      const double energy = grid.arrays.at("energy").values.at(spring);
      CHECK((energy == energies[spring] || (std::isnan(energy) && std::isnan(energies[spring]))));
      CHECK(grid.arrays.at("broken").values.at(spring) == (simulation.alive(spring) ? 0.0 : 1.0));
      const Spring& ends = scene.network.springs()[spring];
      const double length = (simulation.position(ends.second) - simulation.position(ends.first)).norm();
      const double strain = grid.arrays.at("strain").values.at(spring);
      if (spring == 6) {
        CHECK(std::isnan(strain));
      } else {
        CHECK(strain == doctest::Approx(length / ends.rest_length - 1.0).epsilon(1e-12));
      }
    }
    CHECK(grid.arrays.at("broken").values.at(2) == (record == 2 ? 1.0 : 0.0));
    CHECK(grid.arrays.at("tension").values.at(7) == simulation.rigid_force(0));
    for (const char* name : {"tension", "energy", "strain"}) CHECK(std::isnan(grid.arrays.at(name).values.at(8)));
  }
  CHECK(touched);
}

TEST_CASE("internal states of springs are data of their cells, if the scene records states") {
  const TemporaryFolder folder;
  Scene scene = scene_of_everything();
  Network& net = scene.network;
  const LawUse plastic{"plastic", {{"stiffness", 40.0}, {"yield_tension", 0.1}, {"relaxation_time", 0.02}}};
  const SpringIndex spring = net.add_spring(0, 4, net.add_material({plastic, std::nullopt}));
  run(scene, folder);
  CHECK(read(folder.path() / "vtk" / "net_000003.vtu").arrays.count("plastic flow") == 0);
  scene.output.states = true;
  scene.output.law_states = find_law_states(net, *plugins());
  run(scene, folder);
  Simulation simulation(net, plugins(), scene.options);
  const Grid grid = read(folder.path() / "vtk" / "net_000003.vtu");
  simulation.advance_to(grid.arrays.at("TimeValue").values.at(0));
  const auto& flow = grid.arrays.at("plastic flow");
  CHECK(flow.section == "CellData");
  REQUIRE(flow.values.size() == grid.cells);
  CHECK(simulation.internal_states(spring)[0] != 0.0);
  for (std::size_t cell = 0; cell < grid.cells; ++cell) {
    CAPTURE(cell);
    if (cell == spring) CHECK(flow.values[cell] == simulation.internal_states(spring)[0]);
    if (cell != spring) CHECK(std::isnan(flow.values[cell]));
  }
}

TEST_CASE("a triangle is broken once a spring along any of its edges is") {
  const TemporaryFolder folder;
  Scene scene = scene_of_everything();  // cuts spring 2, between nodes 1 and 2, at 0.12 s
  Network& net = scene.network;
  net.add_face({2, 0, 1});
  net.add_face({3, 2, 0});
  const SpringIndex parallel = net.add_spring(3, 2, 0);  // beside spring 5, which stays
  net.add_cut({0.22, {parallel}, {}});
  run(scene, folder);
  // Springs, the rigid connection, then faces 0 1 3, 2 0 1 and 3 2 0.
  const std::vector<std::vector<double>> expected{{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 1, 1}};
  for (std::size_t record = 0; record < 4; ++record) {
    CAPTURE(record);
    const Grid grid = read(folder.path() / "vtk" / ("net_00000" + std::to_string(record) + ".vtu"));
    const std::vector<double>& broken = grid.arrays.at("broken").values;
    REQUIRE(broken.size() == 12);
    CHECK(std::vector<double>(broken.end() - 3, broken.end()) == expected[record]);
    CHECK(broken[8] == 0.0);
  }
}

TEST_CASE("a turning box has its orientation, and nodes have the number of the surface that they touch") {
  const TemporaryFolder folder;
  Scene scene;
  Network& net = scene.network;
  net.add_node(testing::point({0, 0, 0}));
  net.add_node(testing::point({0, 0, 1}));
  net.add_node(testing::point({3, 0, 0.3}));
  net.set_gravity({0, 0, -10});
  net.add_plane({"wall", {9, 0, 0}, -Vector3::UnitX()});
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  Instrument slab;
  slab.first = {3, 0, 0.1};
  slab.box.emplace();
  slab.box->size = {1.0, 2.0, 0.4};
  slab.turn.emplace();
  slab.turn->axis = Vector3(0.6, 0.0, 0.8);
  slab.turn->through = Vector3(7, 1, -1);
  slab.turn->rate = 0.3;
  net.add_instrument(slab);
  scene.duration = 0.1;
  scene.options.time_step = 0.01;
  scene.output.interval = 0.1;
  scene.output.vtk = true;
  run(scene, folder);
  const Grid grid = read(folder.path() / "vtk/net_000001.vtu");
  CHECK(grid.arrays.at("surface").section == "PointData");
  CHECK(grid.arrays.at("surface").values == std::vector<double>{1, -1, 2});
  const Grid surfaces = read(folder.path() / "vtk/surfaces_000001.vtp");
  const SurfaceShapes shapes = shapes_of(net);
  REQUIRE(shapes.points.size() == 16);  // two squares and a box
  const Eigen::AngleAxisd turned(0.3 * 0.1, slab.turn->axis);
  for (std::size_t k = 0; k < 16; ++k) {
    const Vector3 through = *slab.turn->through;
    const Vector3 place = k < 8 ? shapes.points[k] : Vector3(through + turned * (shapes.points[k] - through));
    CHECK((vector(surfaces, "Points", k) - place).norm() <= 1e-14);  // rounding
  }
}

TEST_CASE("surfaces have a file of their own and move as in the simulation") {
  const TemporaryFolder folder;
  const Scene scene = scene_of_everything();
  run(scene, folder);
  const std::vector<Entry> index = read_index(folder.path() / "vtk/run.pvd");
  REQUIRE(index.size() == 8);
  CHECK(index[3].part == "1");
  CHECK(index[3].time == index[2].time);
  const Grid grid = read(folder.path() / "vtk" / index[3].file);
  CHECK(grid.text.find("<VTKFile type=\"PolyData\"") != std::string::npos);
  Simulation simulation(scene.network, plugins(), scene.options);
  for (int step = 0; step < 10; ++step) simulation.step();
  const Array& corners = grid.arrays.at("connectivity");
  REQUIRE(corners.values.size() == 3 * grid.cells);
  CHECK(corners.section == "Polys");
  for (std::size_t cell = 0; cell < grid.cells; ++cell) {
    const auto surface = static_cast<std::size_t>(grid.arrays.at("surface").values.at(cell));
    CHECK(surface == (cell < 2 ? 0 : 1));
    CHECK(grid.arrays.at("offsets").values.at(cell) == static_cast<double>(3 * cell + 3));
    CHECK(vector(grid, "force", cell) == simulation.surface_force(surface));
    CHECK(grid.arrays.at("nodes").values.at(cell) == static_cast<double>(simulation.nodes_touching(surface)));
    for (std::size_t k = 3 * cell; k < 3 * cell + 3; ++k) {
      const Vector3 place = vector(grid, "Points", static_cast<std::size_t>(corners.values[k]));
      if (surface == 0) {
        CHECK(place.z() == 0.0);
      } else {  // 9 + 2 m/s 0.1 s in y
        CHECK((place - Vector3(9, 9.2, 9)).norm() == doctest::Approx(0.5).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("the index is complete after each record, also if a run fails") {
  const TemporaryFolder folder;
  Scene scene = scene_of_everything();
  RunOptions options{folder.path(), "vtk", {}};
  options.progress = [&](const RunProgress& now) {
    if (now.steps != 15) return true;
    const std::vector<Entry> index = read_index(folder.path() / "vtk/run.pvd");
    CHECK(index.size() == 4);
    for (const Entry& entry : index) CHECK(std::filesystem::exists(folder.path() / "vtk" / entry.file));
    return true;
  };
  run_scene(scene, plugins(), options);

  // Fails after the second record, when lengths become nan. Its last state is a record of its own.
  Load load;
  load.nodes = {3};
  load.force = Vector3(1e308, 0, 0);
  load.from = 0.15;
  scene.network.add_load(load);
  const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "vtk", {}});
  REQUIRE(summary.failure);
  CHECK(summary.records == 3);
  CHECK(read_index(folder.path() / "vtk/run.pvd").size() == 6);
  // Nor are there pictures of the earlier run.
  CHECK(std::filesystem::exists(folder.path() / "vtk/net_000002.vtu"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "vtk/net_000003.vtu"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "vtk/surfaces_000003.vtp"));
}

TEST_CASE("pictures may be rarer than records, but include the end") {
  const TemporaryFolder folder;
  Scene scene = scene_of_everything();
  scene.output.interval = 0.02;
  scene.output.vtk_interval = 0.13;
  CHECK(run(scene, folder).records == 16);
  const std::vector<Entry> index = read_index(folder.path() / "vtk/run.pvd");
  REQUIRE(index.size() == 8);
  // Records are at multiples of 0.02 s: the first at or after 0.13 and 0.26 s.
  const double expected[] = {0.0, 0.14, 0.26, 0.3};
  for (std::size_t k = 0; k < 4; ++k) CHECK(index[2 * k].time == doctest::Approx(expected[k]).epsilon(1e-12));
}

TEST_CASE("a run stopped between two pictures has one of its end") {
  const TemporaryFolder folder;
  Scene scene = scene_of_everything();
  scene.output.interval = 0.01;  // records at every step, pictures at few of them
  scene.output.vtk_interval = 0.1;
  RunOptions options{folder.path(), "vtk", {}};
  options.progress = [](const RunProgress& now) { return now.steps < 14; };
  const RunSummary summary = run_scene(scene, plugins(), options);
  CHECK(summary.outcome == "stopped");
  CHECK(summary.records == 15);
  const std::vector<Entry> index = read_index(folder.path() / "vtk/run.pvd");
  REQUIRE(index.size() == 6);
  CHECK(index[2].time == doctest::Approx(0.1));
  CHECK(index[4].time == summary.simulated);
}

TEST_CASE("single precision halves the numbers and rounds them to the nearest") {
  const TemporaryFolder folder;
  Scene scene = scene_of_everything();
  run(scene, folder);
  const Grid exact = read(folder.path() / "vtk/net_000002.vtu");
  scene.output.precision = OutputOptions::Precision::float32;
  run(scene, folder);
  const Grid rounded = read(folder.path() / "vtk/net_000002.vtu");
  for (const char* name : {"Points", "velocity", "force", "tension"}) {
    CAPTURE(name);
    CHECK(exact.arrays.at(name).type == "Float64");
    CHECK(rounded.arrays.at(name).type == "Float32");
    const auto &a = exact.arrays.at(name).values, &b = rounded.arrays.at(name).values;
    REQUIRE(a.size() == b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (!std::isnan(a[k])) CHECK(b[k] == static_cast<double>(static_cast<float>(a[k])));
    }
  }
  CHECK(rounded.arrays.at("TimeValue").values == exact.arrays.at("TimeValue").values);
}

TEST_CASE("the next run removes old pictures, but no other files in their folder") {
  const TemporaryFolder folder;
  Scene scene = scene_of_everything();
  run(scene, folder);
  folder.write("vtk/my view.pvsm", "mine");
  folder.write("vtk/net_best.vtu", "mine");
  scene.output.vtk = false;
  run(scene, folder);
  CHECK(std::filesystem::exists(folder.path() / "vtk/my view.pvsm"));
  CHECK(std::filesystem::exists(folder.path() / "vtk/net_best.vtu"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "vtk/run.pvd"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "vtk/net_000000.vtu"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "vtk/surfaces_000000.vtp"));
}

TEST_CASE("a folder of pictures that cannot be created is an input error") {
  const TemporaryFolder folder;
  folder.write("vtk", "a file");
  CHECK_THROWS_AS(run_scene(scene_of_everything(), plugins(), {folder.path(), "vtk", {}}), Error);
}
