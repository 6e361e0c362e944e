#include <doctest/doctest.h>
#include <springnet/output.hpp>

#include "nets.hpp"
#include "run/outputs.hpp"
#include "run/space.hpp"
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
  // Numbers without an exponent are four to six characters shorter than the longest, times many more.
  CHECK(bytes <= estimate.bytes);
  CHECK(bytes >= 0.65 * estimate.bytes);
  CHECK(static_cast<double>(summary.records) == estimate.records);
}

TEST_CASE("tables of a body of micrometres are no larger than estimated") {
  const TemporaryFolder folder;
  Scene scene;
  const MaterialIndex material = scene.network.add_material({LawUse{"linear", {{"stiffness", 0.3}}}, std::nullopt});
  Node prototype;
  prototype.velocity = Vector3(-0.1234567, -1.0, -0.778) / 3e5;
  // Negative coordinates of all digits with an exponent: "-5.952536478795847e-05".
  scene.network.add_lattice("box", {{3, 3, 3}, Vector3(3.1, 3.7, 2.9) * 1e-6, Vector3(-71, -67, -59) * (1e-6 / 0.97)},
                            prototype, material);
  for (SpringIndex spring = 0; spring < scene.network.springs().size(); ++spring) {
    scene.output.springs.push_back(spring);
  }
  scene.options.time_step = 1e-5 / 3.0;  // times of all digits as well
  scene.duration = 30.0 * scene.options.time_step;
  scene.output.view = false;
  const OutputEstimate estimate = estimate_output(scene);
  const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "small", {}});
  CHECK_MESSAGE(!summary.failure, summary.error);
  REQUIRE(estimate.files.size() == 2);
  for (const FileEstimate& file : estimate.files) {
    CAPTURE(file.file);
    CHECK(static_cast<double>(std::filesystem::file_size(folder.path() / file.file)) <= file.bytes);
  }
  const double bytes = static_cast<double>(std::filesystem::file_size(folder.path() / "trajectory.csv"));
  CHECK(bytes >= 0.9 * estimate.files[0].bytes);  // the numbers are long ones
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

TEST_CASE("the estimate counts what the scene requests") {
  Scene scene = flying(2);
  const double all = estimate_output(scene).bytes;
  scene.output.interval = 0.1;
  // 11 records instead of 101.
  CHECK(estimate_output(scene).bytes == doctest::Approx(all * 11.0 / 101.0));
  scene.output.trajectory = false;
  CHECK(estimate_output(scene).bytes == 0.0);
  scene.output.reactions = true;
  CHECK(estimate_output(scene).bytes == 0.0);  // nothing is written
  scene.network.fix(3);
  const double one_fixed = estimate_output(scene).bytes;
  CHECK(one_fixed > 0.0);
  scene.network.add_plane({});
  scene.network.add_instrument({"a", Vector3(9, 9, 9), Vector3(9, 9, 9), 1.0, {}, std::nullopt});
  scene.output.surfaces = false;
  // Any of the eight nodes may be in contact now, in 11 records, by the plane "0," and by "a,".
  CHECK(estimate_output(scene).bytes == doctest::Approx(8.0 * (one_fixed + 11.0 * 4.0)));
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

TEST_CASE("the estimate of forces is on the safe side, too") {
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
  // Most nodes never touch, so the estimate need not be near.
  CHECK(summary.bytes > 0);
}

TEST_CASE("binary tables have exactly the estimated size, pictures all but their index") {
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
  CHECK(bytes >= 0.6 * estimate.bytes);
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
    CHECK(message.find("most of it in trajectory.csv") != std::string::npos);
  }
  CHECK_FALSE(std::filesystem::exists(folder.path() / "new"));

  scene.output.vtk = true;
  try {
    run_scene(scene, plugins(), {folder.path() / "new", "flying", {}});
    FAIL("it ran");
  } catch (const Error& error) {
    CHECK(std::string(error.what()).find("most of it in vtk/") != std::string::npos);
    CHECK(std::string(error.what()).find("output.interval = ") != std::string::npos);
    // The tables alone do not fit: fewer pictures would not help.
    CHECK(std::string(error.what()).find("output.vtk_interval") == std::string::npos);
  }
}

TEST_CASE("the proposed interval is the smallest of two digits with which the output fits") {
  Scene scene = flying(5);
  scene.duration = 10.0;
  scene.options.time_step = 1e-3;
  scene.output.view = true;  // its size does not shrink like that of the tables
  scene.output.vtk = true;
  for (const double bytes : {2e6, 3e6, 7e6, 4e7}) {
    CAPTURE(bytes);
    REQUIRE(estimate_output(scene).bytes > bytes);
    const std::optional<double> interval = interval_for(scene, bytes);
    REQUIRE(interval);
    CAPTURE(*interval);
    Scene followed = scene;
    followed.output.interval = *interval;
    CHECK(estimate_output(followed).bytes <= bytes);
    // A tenth is the widest gap between numbers of two digits.
    followed.output.interval = *interval / 1.11;
    CHECK(estimate_output(followed).bytes > bytes);
  }
  // The page alone has more.
  CHECK_FALSE(interval_for(scene, 1000.0));
}

TEST_CASE("the size of elements.csv is that of the elements chosen") {
  Scene scene = flying(2);
  scene.output.trajectory = false;
  const MaterialIndex bending = scene.network.add_material({LawUse{"linear", {{"stiffness", 2.0}}}, std::nullopt});
  for (int k = 0; k < 8; ++k) scene.network.add_element(Invariant::angle, {0, 1, 7}, bending);
  const double all = estimate_output(scene).bytes;
  scene.output.element_numbers = {3, 5};
  CHECK(estimate_output(scene).bytes == doctest::Approx(all / 4.0));
}

TEST_CASE("a refusal for lack of space names remedies") {
  Scene scene = flying(5);
  scene.duration = 10.0;
  const auto refusal = [&](double free, double earlier = 0.0) {
    return space_refusal(scene, {free, earlier}, "there").value_or("");
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  const double bytes = estimate_output(scene).bytes;
  CHECK(refusal(1.1 * bytes).empty());
  // A share of the free space is left to others.
  CHECK_FALSE(refusal(1.01 * bytes).empty());
  const std::string half = refusal(0.5 * bytes);
  CAPTURE(half);
  CHECK(has(half, "most of it in trajectory.csv"));
  CHECK(has(half, "leave out trajectory.csv (output.trajectory = false)"));
  CHECK(has(half, "output.interval = 0.021)"));
  CHECK(has(half, "free in there;"));
  // What an earlier run left there is removed first.
  CHECK(refusal(0.5 * bytes, 0.6 * bytes).empty());
  CHECK(has(refusal(0.5 * bytes, 0.3 * bytes), "in files of an earlier run"));

  // Elements may have more than the trajectory.
  const MaterialIndex bending = scene.network.add_material({LawUse{"linear", {{"stiffness", 2.0}}}, std::nullopt});
  for (int k = 0; k < 1000; ++k) scene.network.add_element(Invariant::angle, {0, 1, 7}, bending);
  const std::string elements = refusal(1.1 * bytes);
  CAPTURE(elements);
  CHECK(has(elements, "most of it in elements.csv"));
  CHECK(has(elements, "leave out elements.csv (output.elements = false, or a list of names"));
  scene.output.elements = false;

  // The page has the same size whatever the interval, so that it is no remedy.
  scene.output.trajectory = false;
  scene.output.view = true;
  const std::string page = refusal(1000.0);
  CAPTURE(page);
  CHECK(has(page, "most of it in view.html"));
  CHECK(has(page, "output.view = false"));
  CHECK(has(page, "output.view_size"));
  CHECK_FALSE(has(page, "output.interval"));

  scene.output.vtk = true;
  CHECK(has(refusal(1e5), "several of these together: leave out vtk/ (output.vtk = false)"));
  CHECK(has(refusal(1e5), "output.vtk_interval"));
}

TEST_CASE("files of an earlier run are those that the next one removes") {
  const TemporaryFolder folder;
  CHECK(earlier_bytes(folder.path() / "nowhere") == 0);
  Scene scene = flying(2);
  scene.duration = 0.05;
  scene.output.view = true;
  scene.output.vtk = true;
  run_scene(scene, plugins(), {folder.path(), "flying", {}});
  const std::uintmax_t bytes = earlier_bytes(folder.path());
  std::uintmax_t all = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
    if (entry.is_regular_file()) all += entry.file_size();
  }
  CHECK(bytes == all);
  folder.write("mine.csv", "mine");
  folder.write("vtk/mine.vtu", "mine");
  CHECK(earlier_bytes(folder.path()) == bytes);
}

TEST_CASE("sizes are readable") {
  CHECK(readable_bytes(0.0) == "0 bytes");
  CHECK(readable_bytes(999.0) == "999 bytes");
  CHECK(readable_bytes(1000.0) == "1 kB");
  CHECK(readable_bytes(4.452e6) == "4.45 MB");
  CHECK(readable_bytes(2.0e20) == "2e+05 PB");
}
