// Foreign entries in the folder of a run: links, pipes, folders, another run.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <doctest/doctest.h>
#include <springnet/output.hpp>
#include <springnet/records.hpp>

#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::plugins;
using testing::read_text;
using testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

const char* const names[] = {"events.csv",   "trajectory.csv", "reactions.csv",    "surfaces.csv", "rigid.csv",
                             "springs.csv",  "elements.csv",   "view.html",        "states.csv",   "energies.csv",
                             "summary.json", "view.html.part", "summary.json.part"};

// A scene that writes every kind of file.
Scene scene_with_everything() {
  Scene scene;
  scene.network = testing::chain(4, {0, 0, 0}, {1, 0, 0}, testing::damped(40.0, 0.5));
  Network& net = scene.network;
  net.fix(0);
  const MaterialIndex bending = net.add_material({LawUse{"linear", {{"stiffness", 2.0}}}, std::nullopt});
  net.add_element(Invariant::angle, {0, 1, 2}, bending);
  net.add_rigid(2, 3);
  net.add_plane({"ground", Vector3(0, 0, -5), Vector3::UnitZ()});
  scene.duration = 0.3;
  scene.options.time_step = 0.1;
  scene.options.threads = 1;
  scene.output.reactions = scene.output.vtk = scene.output.energies = scene.output.states = true;
  scene.output.springs = {0, 1};
  return scene;
}

RunSummary run(const fs::path& folder, const std::function<bool(const RunProgress&)>& progress = {}) {
  return run_scene(scene_with_everything(), plugins(), {folder, "all", progress});
}

void check_files(const RunSummary& summary, const fs::path& folder) {
  CHECK_MESSAGE(!summary.failure, summary.error);
  CHECK(summary.files.size() == 12);
  for (const std::string& name : summary.files) {
    CAPTURE(name);
    CHECK(fs::symlink_status(folder / name).type() == fs::file_type::regular);
    CHECK(fs::file_size(folder / name) > 0);
  }
}

std::string refusal(const fs::path& folder) {
  try {
    run(folder);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("links in the folder of a run are replaced, and their targets stay as they are") {
  const TemporaryFolder folder;
  folder.write("victim", "mine");
  const fs::path out = folder.path() / "out";
  fs::create_directory(out);
  for (const char* name : names) fs::create_symlink(folder.path() / "victim", out / name);
  const fs::path pictures = folder.path() / "pictures";
  fs::create_directory(pictures);
  std::ofstream(pictures / "net_000000.vtu") << "mine";
  std::ofstream(pictures / "run.pvd") << "mine";
  fs::create_directory_symlink(pictures, out / "vtk");
  check_files(run(out), out);
  CHECK(read_text(folder.path() / "victim") == "mine");
  CHECK(read_text(pictures / "net_000000.vtu") == "mine");
  CHECK(read_text(pictures / "run.pvd") == "mine");
  CHECK(fs::symlink_status(out / "vtk").type() == fs::file_type::directory);
}

TEST_CASE("links in the folder of pictures are replaced, and other files there stay") {
  const TemporaryFolder folder;
  folder.write("victim", "mine");
  const fs::path pictures = folder.path() / "vtk";
  fs::create_directory(pictures);
  for (const char* name : {"run.pvd", "net_000000.vtu", "net_000001.vtu", "surfaces_000002.vtp"}) {
    fs::create_symlink(folder.path() / "victim", pictures / name);
  }
  std::ofstream(pictures / "notes.txt") << "mine";
  check_files(run(folder.path()), folder.path());
  CHECK(read_text(folder.path() / "victim") == "mine");
  CHECK(read_text(pictures / "notes.txt") == "mine");
  CHECK(fs::symlink_status(pictures / "net_000001.vtu").type() == fs::file_type::regular);
}

TEST_CASE("links that appear during a run are replaced, too") {
  const TemporaryFolder folder;
  folder.write("victim", "mine");
  const RunSummary summary = run(folder.path(), [&](const RunProgress& now) {
    if (now.steps != 2) return true;
    for (const char* name : {"view.html.part", "summary.json", "summary.json.part", "vtk/net_000003.vtu"}) {
      fs::create_symlink(folder.path() / "victim", folder.path() / name);
    }
    return true;
  });
  check_files(summary, folder.path());
  CHECK(read_text(folder.path() / "victim") == "mine");
}

TEST_CASE("the folder that the user names may be a link") {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "disk");
  fs::create_directory_symlink("disk", folder.path() / "out");
  check_files(run(folder.path() / "out"), folder.path() / "disk");
  CHECK(fs::is_symlink(folder.path() / "out"));
}

TEST_CASE("named pipes in the folder do not block a run") {
  const TemporaryFolder folder;
  for (const char* name : names) REQUIRE(mkfifo((folder.path() / name).c_str(), 0600) == 0);
  check_files(run(folder.path()), folder.path());
}

TEST_CASE("a folder in the place of a file is an error before anything is removed") {
  for (const char* name : names) {
    const TemporaryFolder folder;
    CAPTURE(name);
    const bool first = std::string(name) == "events.csv";
    folder.write(first ? "trajectory.csv" : "events.csv", "of an earlier run");
    fs::create_directory(folder.path() / name);
    CHECK(refusal(folder.path()).find(std::string(name) + ": a folder has the name of this file") != std::string::npos);
    CHECK(fs::exists(folder.path() / (first ? "trajectory.csv" : "events.csv")));
  }
}

TEST_CASE("a file in the place of the folder of pictures is an error") {
  const TemporaryFolder folder;
  folder.write("vtk", "mine");
  const std::string reason = refusal(folder.path());
  CHECK(reason.find("vtk") != std::string::npos);
  CHECK(reason.find("cannot be created") != std::string::npos);
  CHECK(read_text(folder.path() / "vtk") == "mine");
}

TEST_CASE("two runs cannot write to one folder at the same time") {
  const TemporaryFolder folder;
  std::string second;
  const RunSummary summary = run(folder.path(), [&](const RunProgress&) {
    if (second.empty()) second = refusal(folder.path());
    return true;
  });
  check_files(summary, folder.path());
  CHECK(second.find("another run is writing to this folder") != std::string::npos);
  check_files(run(folder.path()), folder.path());
}

TEST_CASE("a file that is removed or replaced during the run is reported, and not listed") {
  for (const char* name : {"trajectory.csv", "springs.csv", "vtk/run.pvd"}) {
    for (const bool replaced : {false, true}) {
      CAPTURE(name);
      const TemporaryFolder folder;
      const RunSummary summary = run(folder.path(), [&](const RunProgress& now) {
        if (now.steps != 2) return true;
        fs::remove(folder.path() / name);
        if (replaced) folder.write(name, "of somebody else");
        return true;
      });
      CHECK(summary.failure == ErrorKind::simulation);
      CHECK(summary.error.find(std::string(name) + ": was removed or replaced") != std::string::npos);
      CHECK(std::count(summary.files.begin(), summary.files.end(), name) == 0);
      CHECK(summary.files.size() == 11);
      CHECK(summary.cut_short.empty());
    }
  }
}

TEST_CASE("a folder of pictures that is moved away during the run is reported, and not listed") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const RunSummary summary = run(out, [&](const RunProgress& now) {
    if (now.steps == 2) fs::rename(out / "vtk", folder.path() / "moved");
    return true;
  });
  CAPTURE(summary.error);
  CHECK(summary.error.find("vtk/net_000003.vtu: was removed") != std::string::npos);
  CHECK(std::count(summary.files.begin(), summary.files.end(), "vtk/run.pvd") == 0);
  CHECK(fs::exists(folder.path() / "moved/net_000002.vtu"));
}

TEST_CASE("a table never takes the place of a standard stream") {
  const TemporaryFolder folder;
  const int kept = dup(STDIN_FILENO);
  close(STDIN_FILENO);
  {
    TableWriter events("events", folder.path() / "events.csv", Network{});
    CHECK(fcntl(STDIN_FILENO, F_GETFD) == -1);
  }
  dup2(kept, STDIN_FILENO);
  close(kept);
}

TEST_CASE("a table with a path follows a link") {
  const TemporaryFolder folder;
  folder.write("table.csv", "old");
  fs::create_symlink("table.csv", folder.path() / "link.csv");
  { TableWriter events("events", folder.path() / "link.csv", Network{}); }
  CHECK(fs::is_symlink(folder.path() / "link.csv"));
  CHECK(read_text(folder.path() / "table.csv") ==
        "time,event,element,index,surface,jx,jy,jz,x,y,z,vx,vy,vz,nx,ny,nz,value,force,pair\n");
}
