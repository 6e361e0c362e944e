#include <doctest/doctest.h>
#include <springnet/output.hpp>

#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

// Nodes that fly on their own: every number has all its digits.
Scene flying(std::uint32_t side) {
  Scene scene;
  const MaterialIndex material = scene.network.add_material({LawUse{"linear", {{"stiffness", 0.3}}}, std::nullopt});
  Node prototype;
  prototype.velocity = Vector3(0.1234567, -1.0, 0.777) / 3.0;
  scene.network.add_lattice("box", {{side, side, side}, Vector3(0.31, 0.37, 0.29), Vector3(-0.11, 0.17, 0.13)},
                            prototype, material);
  scene.network.set_gravity(Vector3(0.1, 0.2, -9.81) / 1.3);
  scene.duration = 1.0;
  scene.options.time_step = 0.01;
  scene.output.view = false;  // tests of tables
  return scene;
}

}  // namespace

TEST_CASE("the estimate of the output is near the size of the files, on the safe side") {
  const TemporaryFolder folder;
  const Scene scene = flying(5);
  const OutputEstimate estimate = estimate_output(scene);
  const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "flying", {}});
  CHECK(summary.outcome == "settled");
  const auto bytes = static_cast<double>(std::filesystem::file_size(folder.path() / "trajectory.csv"));
  // Numbers have one or two digits less than the longest, times many less: a fifth of the estimate.
  CHECK(bytes <= estimate.bytes);
  CHECK(bytes >= 0.8 * estimate.bytes);
  CHECK(static_cast<double>(summary.records) == estimate.records);
}

TEST_CASE("the estimate of the page is on the safe side") {
  const TemporaryFolder folder;
  Scene scene = flying(5);
  scene.output.trajectory = false;
  scene.output.view = true;
  const OutputEstimate estimate = estimate_output(scene);
  run_scene(scene, plugins(), {folder.path(), "flying", {}});
  CHECK(static_cast<double>(std::filesystem::file_size(folder.path() / "view.html")) <= estimate.bytes);
}

TEST_CASE("the estimate counts what the scene asks for") {
  Scene scene = flying(2);
  const double all = estimate_output(scene).bytes;
  scene.output.interval = 0.1;
  // 11 records instead of 101.
  CHECK(estimate_output(scene).bytes == doctest::Approx(all * 11.0 / 101.0));
  scene.output.trajectory = false;
  CHECK(estimate_output(scene).bytes == 0.0);
  scene.output.reactions = true;
  CHECK(estimate_output(scene).bytes == 0.0);  // nothing is held
  scene.network.fix(3);
  const double one_fixed = estimate_output(scene).bytes;
  CHECK(one_fixed > 0.0);
  scene.network.add_plane({});
  scene.network.add_instrument({"a", Vector3(9, 9, 9), Vector3(9, 9, 9), 1.0, {}, std::nullopt});
  scene.output.surfaces = false;
  // Any of the eight nodes may be held now.
  CHECK(estimate_output(scene).bytes == doctest::Approx(8.0 * one_fixed));
  scene.output.reactions = false;
  scene.output.surfaces = true;
  const double surfaces = estimate_output(scene).bytes;
  CHECK(surfaces > 0.0);
  scene.network.add_instrument({"abc", Vector3(9, 9, 9), Vector3(9, 9, 9), 1.0, {}, std::nullopt});
  // One more of three rows, with two more letters in its name, in each of 11 records.
  CHECK(estimate_output(scene).bytes == doctest::Approx(1.5 * surfaces + 11.0 * 2.0));
  scene.output.surfaces = false;
  CHECK(estimate_output(scene).bytes == 0.0);
  scene.network.add_rigid(0, 1);
  CHECK(estimate_output(scene).bytes > 0.0);
  scene.output.rigid = false;
  CHECK(estimate_output(scene).bytes == 0.0);
}

TEST_CASE("the estimate of forces is on the safe side as well") {
  const TemporaryFolder folder;
  Scene scene = flying(3);
  scene.output.trajectory = false;
  scene.output.reactions = true;
  scene.network.add_rigid(0, 1);
  scene.network.add_rigid(5, 6);
  scene.network.add_plane(
      {"floor", Vector3(0.1, 0.2, -0.3), Vector3(0.01, 0.02, 1.0), {Friction::Kind::none, 0.0}, std::nullopt});
  scene.network.add_instrument({"", Vector3(0.3, 0.3, 1.3), Vector3(0.3, 0.3, 1.7), 0.1, {}, std::nullopt});
  scene.output.view = false;
  const OutputEstimate estimate = estimate_output(scene);
  const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "flying", {}});
  CAPTURE(summary.error);
  CHECK_FALSE(summary.failure);
  CHECK(static_cast<double>(summary.bytes) <= estimate.bytes);
  // Most nodes never touch, so nothing is asserted of how near it is.
  CHECK(summary.bytes > 0);
}

TEST_CASE("binary tables and their headers have the size that was told, to the byte; pictures all but their index") {
  const TemporaryFolder folder;
  Scene scene = flying(4);
  scene.duration = 0.055;
  scene.network.add_face({0, 1, 5});
  scene.network.add_plane({"floor", Vector3(0, 0, -9), Vector3::UnitZ(), {}, std::nullopt});
  scene.output.format = OutputOptions::Format::binary;
  scene.output.nodes = {1, 5, 17};
  scene.output.springs = {0, 1, 2, 100};
  scene.output.vtk = true;
  scene.output.vtk_interval = 0.02;
  for (const auto precision : {OutputOptions::Precision::float64, OutputOptions::Precision::float32}) {
    scene.output.precision = precision;
    const OutputEstimate estimate = estimate_output(scene);
    const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "flying", {}});
    CHECK(summary.records == 7);
    CHECK(static_cast<double>(summary.records) == estimate.records);
    double sum = 0.0;
    std::size_t exact = 0;
    for (const FileEstimate& file : estimate.files) {
      CAPTURE(file.file);
      sum += file.bytes;
      double bytes = 0.0;
      if (file.file == "vtk/") {
        std::size_t pictures = 0;
        for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "vtk")) {
          bytes += static_cast<double>(entry.file_size());
          if (entry.path().extension() == ".vtu") ++pictures;
        }
        CHECK(pictures == 4);
        // 0, 0.02, 0.04 and 0.055 s; a time takes 24 characters at most, two entries a picture, two digits more in
        // names.
        CHECK(bytes > file.bytes - 4 * 2 * 26);
      } else {
        bytes = static_cast<double>(std::filesystem::file_size(folder.path() / file.file));
      }
      CHECK(bytes <= file.bytes);
      if (file.exact) CHECK(bytes == file.bytes);
      exact += file.exact ? 1 : 0;
    }
    CHECK(exact == 2);
    CHECK(sum == estimate.bytes);
  }
}

TEST_CASE("the estimate of springs as text is near the size of the file, on the safe side") {
  const TemporaryFolder folder;
  Scene scene = flying(4);
  scene.output.trajectory = false;
  for (SpringIndex spring = 0; spring < scene.network.springs().size(); ++spring) {
    scene.output.springs.push_back(spring);
  }
  const OutputEstimate estimate = estimate_output(scene);
  run_scene(scene, plugins(), {folder.path(), "flying", {}});
  const auto bytes = static_cast<double>(std::filesystem::file_size(folder.path() / "springs.csv"));
  CHECK(bytes <= estimate.bytes);
  // The net flies without load: lengths are short, tensions nearly zero with long exponents.
  CHECK(bytes >= 0.7 * estimate.bytes);
}

TEST_CASE("output that does not fit the disk is refused before anything is written") {
  const TemporaryFolder folder;
  Scene scene = flying(3);
  scene.duration = 1e9;
  scene.options.time_step = 1e-6;
  try {
    run_scene(scene, plugins(), {folder.path() / "new", "flying", {}});
    FAIL("it ran");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    const std::string message = error.what();
    CHECK(message.find("free") != std::string::npos);
    CHECK(message.find("output.interval") != std::string::npos);
    CHECK(message.find("output.trajectory") != std::string::npos);
    CHECK(message.find("most of it trajectory.csv") != std::string::npos);
  }
  CHECK_FALSE(std::filesystem::exists(folder.path() / "new"));

  scene.output.vtk = true;
  try {
    run_scene(scene, plugins(), {folder.path() / "new", "flying", {}});
    FAIL("it ran");
  } catch (const Error& error) {
    CHECK(std::string(error.what()).find("most of it vtk/") != std::string::npos);
    CHECK(std::string(error.what()).find("output.vtk_interval") != std::string::npos);
  }
}

TEST_CASE("sizes are readable") {
  CHECK(readable_bytes(0.0) == "0 bytes");
  CHECK(readable_bytes(999.0) == "999 bytes");
  CHECK(readable_bytes(1000.0) == "1 kB");
  CHECK(readable_bytes(4.452e6) == "4.45 MB");
  CHECK(readable_bytes(2.0e20) == "2e+05 PB");
}
