#include <springnet/scene.hpp>

#include <system_error>

#include <fmt/format.h>

#include <springnet/version.hpp>

#include "scene/component.hpp"
#include "scene/document.hpp"
#include "scene/file_text.hpp"
#include "scene/files.hpp"
#include "scene/parts.hpp"
#include "scene/reader.hpp"
#include "simulation/max_threads.hpp"

namespace springnet {
namespace scene {
namespace {

// The version that this library reads. It increases when a valid scene would be refused or change its meaning.
constexpr std::int64_t scene_version = 1;

void check_version(const Table& root) {
  const auto version = root.find("version");
  if (!version) return;
  const std::int64_t given = version->integer(1);
  if (given == scene_version) return;
  version->fail(fmt::format(
      "this scene has version {}, but springnet {} reads version {}; use a newer springnet, or rewrite the scene "
      "as scene.md of this version describes, with version = {}",
      given, springnet::version(), scene_version, scene_version));
}

void read_simulation(const Table& root, const PluginHost& plugins, const Files& files, Scene& result) {
  const Table table = root.need("simulation").table("simulation");
  SimulationOptions& options = result.options;
  result.duration = table.need("duration").number_from_0("s");
  options.time_step = table.need("time_step").number_above_0("s");
  if (const auto integrator = table.find("integrator")) {
    options.integrator = integrator->is_text() ? read_component_name(*integrator, ComponentKind::integrator, plugins)
                                               : read_component(integrator->open_table("simulation.integrator"), "name",
                                                                ComponentKind::integrator, plugins, files);
  }
  if (const auto threads = table.find("threads")) {
    options.threads = static_cast<unsigned>(threads->integer(0, std::int64_t{max_threads}));
  }
  if (const auto set = table.find("instruction_set")) {
    options.instruction_set = static_cast<InstructionSet>(set->choice({"best", "generic", "avx2", "avx512"}));
  }
  if (const auto renumber = table.find("renumber")) options.renumber = renumber->boolean();
}

}  // namespace
}  // namespace scene

Scene parse_scene(std::string_view text, std::string_view name, const PluginHost& plugins,
                  const std::vector<SceneOverride>& overrides, const std::filesystem::path& folder,
                  OutsideFiles outside, const LoadingCallback& loading) {
  const std::string document(name.empty() ? "scene" : name);
  const toml::table content = scene::parse_document(text, document, overrides);
  const scene::Table root = scene::Value(content, "", document).open_table("");
  scene::check_version(root);  // before keys: a newer version may have more of them
  root.check_keys();

  const scene::Files files{folder, outside, loading};
  Scene result;
  if (const auto title = root.find("title")) result.title = title->prose();
  scene::read_simulation(root, plugins, files, result);
  if (const auto gravity = root.find("gravity")) {
    result.network.set_gravity(gravity->table("gravity").need("acceleration").vector());
  }
  const std::vector<scene::Shape> shapes = scene::read_bodies(root, plugins, files, result);
  scene::read_connections(root, plugins, files, result);
  scene::read_elements(root, plugins, files, shapes, result);
  scene::read_changes(root, plugins, files, shapes, result);
  scene::read_surroundings(root, result);
  scene::read_inputs(root, plugins, files, result);
  scene::read_starts(root, files, result.network);
  scene::read_output(root, plugins, result);
  return result;
}

Scene load_scene(const std::filesystem::path& file, const PluginHost& plugins,
                 const std::vector<SceneOverride>& overrides, OutsideFiles outside, const LoadingCallback& loading) {
  const std::string text = scene::read_scene_text(file);
  // Something other than a file, as a pipe, has no folder with meshes.
  std::error_code unknown;
  std::filesystem::path folder;
  if (std::filesystem::is_regular_file(file, unknown)) folder = file.has_parent_path() ? file.parent_path() : ".";
  return parse_scene(text, file.string(), plugins, overrides, folder, outside, loading);
}

}  // namespace springnet
