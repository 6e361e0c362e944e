#include <springnet/scene.hpp>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "scene/component.hpp"
#include "scene/document.hpp"
#include "scene/parts.hpp"
#include "scene/reader.hpp"

namespace springnet {
namespace scene {
namespace {

void read_simulation(const Table& root, const PluginHost& plugins, Scene& result) {
  const Table table = root.need("simulation").table("simulation");
  SimulationOptions& options = result.options;
  result.duration = table.need("duration").number_from_0("s");
  options.time_step = table.need("time_step").number_above_0("s");
  if (const auto integrator = table.find("integrator")) {
    options.integrator = integrator->is_text() ? read_component_name(*integrator, ComponentKind::integrator, plugins)
                                               : read_component(integrator->open_table("simulation.integrator"), "name",
                                                                ComponentKind::integrator, plugins);
  }
  constexpr std::int64_t most_threads = 1024;  // more than any machine this runs on: a slip of the keyboard
  if (const auto threads = table.find("threads")) {
    options.threads = static_cast<unsigned>(threads->integer(0, most_threads));
  }
  if (const auto set = table.find("instruction_set")) {
    options.instruction_set = static_cast<InstructionSet>(set->choice({"best", "generic", "avx2", "avx512"}));
  }
  if (const auto renumber = table.find("renumber")) options.renumber = renumber->boolean();
}

}  // namespace
}  // namespace scene

Scene parse_scene(std::string_view text, std::string_view name, const PluginHost& plugins,
                  const std::vector<SceneOverride>& overrides, const std::filesystem::path& folder) {
  const std::string document(name.empty() ? "scene" : name);
  const toml::table content = scene::parse_document(text, document, overrides);
  const scene::Table root = scene::Value(content, "", document).table("");

  Scene result;
  if (const auto title = root.find("title")) result.title = title->text();
  scene::read_simulation(root, plugins, result);
  if (const auto gravity = root.find("gravity")) {
    result.network.set_gravity(gravity->table("gravity").need("acceleration").vector());
  }
  const std::vector<scene::Shape> shapes = scene::read_bodies(root, plugins, folder, result);
  scene::read_connections(root, plugins, result.network);
  scene::read_elements(root, plugins, shapes, result);
  scene::read_changes(root, plugins, result.network);
  scene::read_surroundings(root, result.network);
  scene::read_starts(root, folder, result.network);
  scene::read_output(root, result);
  return result;
}

Scene load_scene(const std::filesystem::path& file, const PluginHost& plugins,
                 const std::vector<SceneOverride>& overrides) {
  const auto fail = [&](const std::string& reason) {
    throw Error(ErrorKind::input,
                fmt::format("{}: cannot be read ({}); check its name and its permissions", file.string(), reason));
  };
  std::error_code unknown;
  if (std::filesystem::is_directory(file, unknown)) fail("it is a folder");
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) fail(std::generic_category().message(errno));
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.bad()) fail(std::generic_category().message(errno));
  const std::filesystem::path folder = file.parent_path();
  return parse_scene(text, file.string(), plugins, overrides, folder.empty() ? "." : folder);
}

}  // namespace springnet
