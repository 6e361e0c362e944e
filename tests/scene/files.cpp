// Files that a scene names, and texts that it should not have.
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using springnet::testing::has_facts;
namespace fs = std::filesystem;

namespace {

const std::string keys =
    "neuron = { type = \"point_mass\", mass = 1.0 }\nspring = { type = \"linear\", stiffness = 1.0 }\n";

std::string with_mesh(const std::string& table) {
  return simulation + "[[body]]\nname = \"b\"\nmesh = " + table + "\n" + keys;
}

// A scene's folder with a mesh, and another one beside it with the same mesh.
struct Place {
  testing::TemporaryFolder root;
  fs::path scene = root.path() / "scene", other = root.path() / "scene_other";

  Place() {
    for (const fs::path& folder : {scene, other}) {
      fs::create_directories(folder / "deep");
      fs::copy_file(fs::path(SCENE_FOLDER) / "bar.msh", folder / "bar.msh");
    }
    fs::copy_file(fs::path(SCENE_FOLDER) / "bar.msh", scene / "deep" / "bar.msh");
    fs::create_symlink(other / "bar.msh", scene / "link.msh");
    fs::create_symlink("bar.msh", scene / "inner_link.msh");
    fs::create_directory_symlink(other, scene / "link");
    fs::create_directory_symlink(scene, root.path() / "scene_link");
  }

  [[nodiscard]] std::string refusal(const std::string& file, OutsideFiles outside = OutsideFiles::refused) const {
    return refusal_of(with_mesh("{ file = \"" + file + "\" }"), scene, outside);
  }
  [[nodiscard]] static std::string refusal_of(const std::string& text, const fs::path& folder, OutsideFiles outside) {
    try {
      static_cast<void>(parse_scene(text, "s.toml", plugins(), {}, folder, outside));
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
};

}  // namespace

TEST_CASE("files of a scene lie in its folder or below, after following links") {
  const Place place;
  for (const std::string& inside :
       {std::string("bar.msh"), std::string("deep/bar.msh"), std::string("deep/../bar.msh"), std::string("./bar.msh"),
        std::string("inner_link.msh"), (place.scene / "bar.msh").string()}) {
    CAPTURE(inside);
    CHECK(place.refusal(inside) == "");
  }
  for (const std::string& outside :
       {std::string("../scene_other/bar.msh"), std::string("link.msh"), std::string("link/bar.msh"),
        (place.other / "bar.msh").string(), std::string("deep/../../scene_other/bar.msh")}) {
    CAPTURE(outside);
    const std::string message = place.refusal(outside);
    CHECK(has_facts(message, "s.toml:6:17: body.0.mesh.file: | outside"));
    CHECK(has_facts(message, "--allow-outside"));
    CHECK(place.refusal(outside, OutsideFiles::allowed) == "");
  }
  CHECK(has_facts(place.refusal("../none.msh"),
                  "body.0.mesh.file: | outside"));  // whether it is there is nobody's business
  CHECK(has_facts(place.refusal("none.msh"), "none.msh"));
}

TEST_CASE("a mesh to start from has the same rule, and a folder that is a link is the folder") {
  const Place place;
  const auto text = [](const std::string& start) {
    return with_mesh("{ file = \"bar.msh\", start = \"" + start + "\" }");
  };
  const fs::path linked = place.root.path() / "scene_link";
  CHECK(Place::refusal_of(text("deep/bar.msh"), linked, OutsideFiles::refused) == "");
  CHECK(has_facts(Place::refusal_of(text("link.msh"), linked, OutsideFiles::refused), "body.0.mesh.start: | outside"));
  CHECK(Place::refusal_of(text("link.msh"), linked, OutsideFiles::allowed) == "");
  place.root.write("scene/s.toml", with_mesh("{ file = \"link.msh\" }"));
  CHECK_THROWS_AS(static_cast<void>(load_scene(place.scene / "s.toml", plugins())), Error);
  CHECK_NOTHROW(static_cast<void>(load_scene(place.scene / "s.toml", plugins(), {}, OutsideFiles::allowed)));
}

TEST_CASE("a scene from text may name files only if its folder is given") {
  const Place place;
  const std::string absolute = with_mesh("{ file = \"" + (place.scene / "bar.msh").string() + "\" }");
  CHECK(has_facts(Place::refusal_of(absolute, "", OutsideFiles::refused), "body.0.mesh.file: | folder | parse_scene"));
  CHECK(Place::refusal_of(absolute, "", OutsideFiles::allowed) == "");
  const std::string relative = with_mesh("{ file = \"bar.msh\" }");
  CHECK(has_facts(Place::refusal_of(relative, "", OutsideFiles::allowed), "body.0.mesh.file: | folder | parse_scene"));
}

TEST_CASE("control characters are in no text of a scene, and in no message") {
  const std::string name = refusal(simulation + "[[body]]\nname = \"a\\u001b[2Jb\"\n");
  CHECK(has_facts(name, "test.toml:5:8: body.0.name: | 'a\\u001b[2Jb'"));
  CHECK(has_facts(refusal(with_mesh("{ file = \"secret.txt\\u0000.msh\" }")), "is 'secret.txt\\u0000.msh'"));
  CHECK(has_facts(refusal("title = \"\\u009b2J\"\n" + small), "title: | control characters"));
  CHECK(has_facts(refusal("title = \"\\u007f\"\n" + small), "title: | control characters"));
  CHECK(has_facts(refusal(small + "[[plane]]\nname = \"two\\nlines\"\npoint=[0,0,0]\nnormal=[0,0,1]\n"), "one line"));
  CHECK(refusal("title = \"\"\"Größe\ntwo lines\t膀胱\"\"\"\n" + small) == "");
  CHECK(has_facts(refusal("\"\\u001b[31m\" = 1\n" + small), "no key '\\u001b[31m'"));
  CHECK(has_facts(refusal(small, {{"title", "\"\x1b[31m"}}), "--set title=\"\\u001b[31m: "));
}
