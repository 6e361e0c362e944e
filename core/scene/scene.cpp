#include <springnet/scene.hpp>

#include <algorithm>
#include <optional>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include <springnet/scene_formulas.hpp>
#include <springnet/scene_guesses.hpp>
#include <springnet/version.hpp>

#include "scene/component.hpp"
#include "scene/document.hpp"
#include "scene/file_text.hpp"
#include "scene/files.hpp"
#include "scene/parts.hpp"
#include "scene/reader.hpp"
#include "scene/words.hpp"
#include "simulation/max_threads.hpp"

namespace springnet {
namespace scene {
namespace {

// The version that this library reads. It increases when a valid scene would be refused or change its meaning.
constexpr std::int64_t scene_version = 1;

// Where a scene's files are. Something other than a file, as a pipe, has no folder with meshes.
std::filesystem::path folder_of(const std::filesystem::path& file) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(file, unknown)) return {};
  return file.has_parent_path() ? file.parent_path() : ".";
}

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

// One note for the same words, however often they are there.
void note_guesses(const std::vector<SceneGuess>& guesses, std::vector<std::string>& notes) {
  for (const SceneGuess& guess : guesses) {
    std::string note = note_of(guess);
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(std::move(note));
  }
}

Scene read_scene(std::string_view text, std::string_view name, const PluginHost& plugins,
                 const std::vector<SceneOverride>& overrides, const Files& files) {
  const std::string document(name.empty() ? "scene" : name);
  toml::table content = parse_document(text, document, overrides);
  const Table root = Value(content, "", document).open_table("");
  check_version(root);  // before keys: a newer version may have more of them
  root.check_keys();
  const std::vector<SceneGuess> guesses = replace_words(content, document, files, &plugins);

  Scene result;
  note_guesses(guesses, result.notes);
  if (const auto title = root.find("title")) result.title = title->prose();
  read_simulation(root, plugins, files, result);
  if (const auto gravity = root.find("gravity")) {
    result.network.set_gravity(gravity->table("gravity").need("acceleration").vector());
  }
  const std::vector<Shape> shapes = read_bodies(root, plugins, files, result);
  read_connections(root, plugins, files, result);
  read_elements(root, plugins, files, shapes, result);
  read_changes(root, plugins, files, shapes, result);
  read_surroundings(root, result);
  read_inputs(root, plugins, files, result);
  read_timed_changes(root, plugins, files, result);
  read_starts(root, files, result.network);
  read_tracks(root, files, result.network);
  read_output(root, plugins, result);
  return result;
}

}  // namespace
}  // namespace scene

Scene parse_scene(std::string_view text, std::string_view name, const PluginHost& plugins,
                  const std::vector<SceneOverride>& overrides, const std::filesystem::path& folder,
                  OutsideFiles outside, const LoadingCallback& loading) {
  return scene::read_scene(text, name, plugins, overrides, {folder, outside, loading});
}

Scene load_scene(const std::filesystem::path& file, const PluginHost& plugins,
                 const std::vector<SceneOverride>& overrides, OutsideFiles outside, const LoadingCallback& loading) {
  return scene::read_scene(scene::read_scene_text(file), file.string(), plugins, overrides,
                           {scene::folder_of(file), outside, loading});
}

std::vector<SceneGuess> find_guesses(const std::filesystem::path& file, const std::vector<SceneOverride>& overrides,
                                     OutsideFiles outside, const PluginHost* plugins) {
  const std::string name = file.string();
  toml::table content = scene::parse_document(scene::read_scene_text(file), name, overrides);
  return scene::replace_words(content, name, {scene::folder_of(file), outside}, plugins);
}

std::vector<SceneFormula> find_formulas(const std::filesystem::path& file, const PluginHost& plugins,
                                        const std::vector<SceneOverride>& overrides) {
  std::vector<SceneFormula> formulas;
  scene::Files files{scene::folder_of(file)};
  files.formulas = &formulas;
  const Scene whole = scene::read_scene(scene::read_scene_text(file), file.string(), plugins, overrides, files);
  const Network& network = whole.network;
  // What the material gives differs between springs: that of the first counts.
  std::vector<bool> is_seen(network.materials().size(), false), is_found(formulas.size(), false);
  const auto find_in = [&](const auto& users, const auto& reference) {
    for (const auto& user : users) {
      if (is_seen[user.material]) continue;
      is_seen[user.material] = true;
      const Material& material = network.materials()[user.material];
      for (const std::optional<LawUse>* law : {&material.spring, &material.viscosity})
        for (std::size_t k = 0; *law && k < formulas.size(); ++k) {
          if (is_found[k] || (*law)->component != formulas[k].law.component) continue;
          is_found[k] = true;
          formulas[k].law.parameters = (*law)->parameters;
          formulas[k].reference = reference(user);
        }
    }
  };
  find_in(network.springs(), [](const Spring& spring) { return spring.rest_length; });
  find_in(network.elements(), [](const Element& element) { return element.reference; });
  return formulas;
}

}  // namespace springnet
