#include "common.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include <fmt/format.h>
#include <springnet/mesh.hpp>
#include <springnet/printable.hpp>

#include "simulation/max_threads.hpp"

namespace springnet::tool {

namespace {

bool sets_integrator(const SceneOverride& change) {
  constexpr std::string_view key = "simulation.integrator";
  return change.key == key || change.key.starts_with(std::string(key) + ".");
}

bool is_same(const springnet_plugin& a, const springnet_plugin& b) {
  return std::string_view(a.id) == b.id && std::string_view(a.version) == b.version;
}

// Whether the scene uses the component.
bool uses(const Scene& scene, const Component& component) {
  const auto is_it = [&](const std::optional<LawUse>& use) { return use && use->id == component.id(); };
  const std::vector<Material>& materials = scene.network.materials();
  const std::vector<LawUse>& neurons = scene.network.neurons();
  switch (component.kind()) {
    case ComponentKind::spring_function:
      return std::any_of(materials.begin(), materials.end(), [&](const Material& m) { return is_it(m.spring); });
    case ComponentKind::viscosity_function:
      return std::any_of(materials.begin(), materials.end(), [&](const Material& m) { return is_it(m.viscosity); });
    case ComponentKind::neuron:
      return std::any_of(neurons.begin(), neurons.end(), is_it);
    case ComponentKind::integrator:
      return is_it(scene.options.integrator);
  }
  return false;
}

}  // namespace

ExitStatus status_of(ErrorKind kind) noexcept {
  switch (kind) {
    case ErrorKind::simulation:
      return failed;
    case ErrorKind::input:
      return wrong_usage;
    case ErrorKind::plugin:
      return plugin_trouble;
  }
  return failed;
}

CLI::Validator number_between(double smallest, double largest) {
  const auto check = [=](const std::string& text) {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && value >= smallest && value <= largest) return std::string();
    if (smallest == above_zero && largest == finite) return fmt::format("must be a number above 0, but is {}", text);
    return fmt::format("must be a number from {:g} to {:g}, but is {}", smallest, largest, text);
  };
  return CLI::Validator(check, "");
}

// Not fmt::print, which throws on a full disk, for instance; the exit status still reports the error.
void print_error(std::string_view message) {
  std::fputs(fmt::format("springnet: error: {}\n", printable_message(message)).c_str(), stderr);
}

void print_report(std::string_view report) {
  const std::string text = printable_message(report);
  const bool printed = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (printed || errno != EPIPE) return;
  // The reader has gone: drops what is still buffered, and what is printed from now on.
  if (std::freopen("/dev/null", "w", stdout) != nullptr) std::clearerr(stdout);
}

std::string describe(const EventCounts& events) {
  std::string text;
  const auto add = [&](std::size_t count, const char* what, const char* happened) {
    if (count == 0) return;
    text += fmt::format("{}{} {}{} {}", text.empty() ? "" : ", ", count, what, count == 1 ? "" : "s", happened);
  };
  add(events.cut, "spring", "cut");
  add(events.ruptured, "spring", "ruptured");
  add(events.elements_removed, "element", "removed");
  add(events.touched, "node", "touched a surface");
  add(events.released, "node", "released");
  add(events.slipped, "node", "slipped");
  add(events.stuck, "node", "stuck again");
  add(events.jammed, "node", "jammed");
  const auto add_pairs = [&](std::size_t count, const char* happened) {
    if (count > 0)
      text +=
          fmt::format("{}{} contact{} of bodies {}", text.empty() ? "" : ", ", count, count == 1 ? "" : "s", happened);
  };
  add_pairs(events.met, "made");
  add_pairs(events.parted, "ended");
  return text.empty() ? "none" : text;
}

void PluginArguments::add_to(CLI::App& command) {
  command
      .add_option("--plugins", folders,
                  "Folder to search for plugins, before those of SPRINGNET_PLUGIN_PATH and the installed ones. May be "
                  "repeated")
      ->type_name("DIR")
      ->expected(1)
      ->allow_extra_args(false)  // else the scene after the folder counts as another folder
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

std::shared_ptr<const PluginHost> PluginArguments::load() const {
  return std::make_shared<const PluginHost>(PluginHost::with_default_search(folders));
}

std::vector<std::string> PluginArguments::empty_folders() const {
  std::vector<std::string> notes;
  for (const std::filesystem::path& folder : folders) {
    std::error_code unreadable;  // which the host has already reported
    bool found = false;
    for (std::filesystem::directory_iterator entry(folder, unreadable), end; !unreadable && entry != end;
         entry.increment(unreadable)) {
      found = found || entry->path().stem().extension() == ".springnet";
    }
    if (!found && !unreadable) {
      notes.push_back(fmt::format("There is no plugin (*.springnet.so) in {}, given by --plugins.",
                                  printable_message(folder.string())));
    }
  }
  return notes;
}

bool PluginArguments::is_named(const std::filesystem::path& folder) const {
  return std::any_of(folders.begin(), folders.end(),
                     [&](const auto& each) { return each == folder || each == folder / ""; });
}

bool PluginArguments::would_matter(const Refusal& refusal, const PluginHost& host, const Scene& scene,
                                   std::string_view integrator) {
  // The file may be valid by itself, and refused because other plugins already provide its components.
  PluginHost alone;
  if (!alone.load(refusal.file)) return false;
  const auto& components = alone.components();
  return std::any_of(components.begin(), components.end(), [&](const auto& own) {
    const auto other = host.find(own->kind(), own->id());
    if (!other || is_same(*own->plugin, *other->plugin)) return false;
    return uses(scene, *own) || (own->kind() == ComponentKind::integrator && own->id() == integrator);
  });
}

std::vector<std::string> PluginArguments::notes(const PluginHost& host, const Scene& scene,
                                                std::string_view integrator) const {
  constexpr std::size_t max_listed = 3, max_named = 3;
  std::vector<std::string> notes = empty_folders();
  std::vector<const Refusal*> others;
  std::size_t listed = 0;
  for (const Refusal& refusal : host.refusals()) {
    const std::string file = printable_message(refusal.file.string());
    // A folder that was not searched is no file of a plugin.
    if (refusal.file.stem().extension() != ".springnet" || is_named(refusal.file)) {
      notes.push_back(fmt::format("Folder of plugins not searched: {}: {}.", file, refusal.reason));
    } else if (listed < max_listed && would_matter(refusal, host, scene, integrator)) {
      ++listed;
      notes.push_back(fmt::format("Plugin refused: {}: {}.", file, refusal.reason));
    } else {
      others.push_back(&refusal);
    }
  }
  if (others.empty()) return notes;
  const Refusal& first = *others.front();
  if (others.size() == 1 && is_named(first.file.parent_path()) && !PluginHost().load(first.file)) {
    notes.push_back(fmt::format("Plugin refused: {}: {}.", printable_message(first.file.string()), first.reason));
    return notes;
  }
  std::string names;
  for (std::size_t k = 0; k < std::min(others.size(), max_named); ++k)
    names += fmt::format("{}{}", k == 0 ? "" : ", ", printable_message(others[k]->file.filename().string()));
  if (others.size() > max_named) names += ", …";
  notes.push_back(
      fmt::format("{} refused ({}); 'springnet plugin list'{} lists the reasons.",
                  others.size() == 1 ? "1 plugin file was" : fmt::format("{} plugin files were", others.size()), names,
                  folders.empty() ? "" : " with the same --plugins"));
  return notes;
}

void SceneArguments::add_to(CLI::App& command, bool simulation) {
  command.add_option("SCENE", file, "Scene file (TOML)")->type_name("")->required();
  if (simulation) {
    command
        .add_option("--integrator", integrator, "Use this integrator instead of the scene's, with its default options")
        ->type_name("NAME");
    command.add_option("--time-step", time_step, "Time step in seconds (the paper's time constant)")
        ->type_name("S")
        ->check(number_between(above_zero, finite));
    command.add_option("--duration", duration, "Seconds to simulate")
        ->type_name("S")
        ->check(number_between(above_zero, finite));
    command.add_option("--threads", threads, "Threads; 0: as many as are useful")
        ->type_name("N")
        ->check(number_between(0, max_threads));
  }
  command.add_option("--set", sets, "Replace or add a key of the scene; the value is TOML. May be repeated")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->allow_extra_args(false)  // else the scene after it counts as another change
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_flag("--allow-outside", allow_outside,
                   "Allow the scene to name files outside its folder, directly or through links");
  plugins.add_to(command);
}

Scene SceneArguments::load(const PluginHost& host, const LoadingCallback& loading) const {
  const OutsideFiles outside = allow_outside ? OutsideFiles::allowed : OutsideFiles::refused;
  std::vector<SceneOverride> changes;
  if (std::error_code ignored; has_mesh_ending(file) && std::filesystem::is_regular_file(file, ignored)) {
    throw Error(
        ErrorKind::input,
        fmt::format("{0}: is a mesh, not a scene; 'springnet new {0}' writes a scene for it, 'springnet inspect {0}' "
                    "describes it",
                    printable_message(file.string())));
  }
  if (time_step) changes.push_back({"simulation.time_step", fmt::format("{}", *time_step)});
  if (duration) changes.push_back({"simulation.duration", fmt::format("{}", *duration)});
  std::vector<SceneOverride> others = changes;  // without those of the integrator
  for (const std::string& text : sets) {
    changes.push_back(parse_override(text));
    if (!sets_integrator(changes.back())) others.push_back(changes.back());
  }

  if (integrator) {
    // The options are dropped only if the name changes: those of one integrator mean nothing to another.
    bool same = false;
    try {
      same = load_scene(file, host, others, outside, loading).options.integrator.id == *integrator;
    } catch (const Error&) {
      // Loading it below reports the error, if it remains.
    }
    if (!same) {
      static_cast<void>(host.require(ComponentKind::integrator, *integrator));
      changes.insert(changes.begin(), {"simulation.integrator", fmt::format("{{ name = \"{}\" }}", *integrator)});
    }
  }
  Scene scene = load_scene(file, host, changes, outside, loading);
  if (threads) scene.options.threads = *threads;
  return scene;
}

void OutputArguments::add_to(CLI::App& command) {
  command.add_option("-o,--output", folder, "Folder for the files, created if necessary [results/<name of the scene>]")
      ->type_name("DIR");
  command.add_flag("--json", json, "Print the summary as JSON and nothing else");
  command.add_flag("-q,--quiet", quiet, "Print only errors");
}

std::filesystem::path OutputArguments::folder_for(const std::filesystem::path& scene) const {
  return folder.empty() ? std::filesystem::path("results") / scene.stem() : folder;
}

OutputFolder::Pointer OutputArguments::open_for(const std::filesystem::path& scene,
                                                const std::vector<std::string>& files) const {
  OutputFolder::Pointer result = OutputFolder::make(folder_for(scene));
  result->lock();
  for (const std::string& name : files) {
    result->require_no_folder(name);
    result->require_no_folder(part_name(name));
  }
  return result;
}

}  // namespace springnet::tool
