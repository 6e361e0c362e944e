#include <algorithm>
#include <cstdlib>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/host_laws.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/plugin_search.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "plugin_host/check_plugin.hpp"
#include "plugin_host/host_plugin.hpp"
#include "plugin_host/library.hpp"

namespace springnet {

namespace fs = std::filesystem;

// Characters of a file name in messages; systems do not allow longer ones.
constexpr std::size_t max_path_length = 4096;

std::string_view name_of(ComponentKind kind) noexcept {
  switch (kind) {
    case ComponentKind::spring_function:
      return "spring function";
    case ComponentKind::viscosity_function:
      return "viscosity function";
    case ComponentKind::neuron:
      return "neuron";
    case ComponentKind::integrator:
      return "integrator";
  }
  return "component";
}

namespace {

// Entries of SPRINGNET_PLUGIN_PATH.
std::vector<fs::path> listed_folders() {
  std::vector<fs::path> folders;
  const char* listed = std::getenv("SPRINGNET_PLUGIN_PATH");
  std::string_view rest = listed == nullptr ? "" : listed;
  while (!rest.empty()) {
    const std::string_view entry = rest.substr(0, rest.find(':'));
    rest.remove_prefix(std::min(rest.size(), entry.size() + 1));
    if (!entry.empty()) folders.emplace_back(entry);
  }
  return folders;
}

// In the order of their names.
std::vector<fs::path> plugins_in(const fs::path& folder, std::error_code& failed) {
  std::vector<fs::path> files;
  const std::string ending = ".springnet" + library_suffix();
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
    if (entry->path().filename().string().ends_with(ending)) files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

struct PluginHost::Impl {
  std::vector<std::shared_ptr<const Component>> components;
  std::vector<Refusal> refusals;
  std::set<fs::path> seen;  // canonical names of the files examined
  struct Searched {
    fs::path folder;
    std::size_t files;  // with the ending of plugins
  };
  std::vector<Searched> searched;  // folders, in their order, each once

  // `id` may say whose: "linear@org.example".
  [[nodiscard]] std::vector<std::shared_ptr<const Component>> all(ComponentKind kind, std::string_view id) const {
    const std::size_t at = id.find('@');
    const std::string_view name = id.substr(0, at);
    std::vector<std::shared_ptr<const Component>> found;
    for (const auto& component : components)
      if (component->kind() == kind && component->id() == name &&
          (at == std::string_view::npos || component->plugin->id == id.substr(at + 1)))
        found.push_back(component);
    return found;
  }

  bool refuse(const fs::path& file, const std::string& reason) {
    refusals.push_back({file, printable_message(reason)});
    return false;
  }

  // A folder, or an entry of a list of folders, that was not searched.
  void ignore_folder(const fs::path& folder, const std::string& reason) {
    const auto is_it = [&](const Refusal& each) { return each.file == folder; };
    if (std::none_of(refusals.begin(), refusals.end(), is_it)) refuse(folder, reason);
  }

  // origin: who names the folder, for messages; empty: the program.
  void search(const fs::path& folder, std::string_view origin);
  bool load(const fs::path& file);
  [[nodiscard]] std::string where_it_searched() const;
  [[nodiscard]] std::string refused_files(std::string_view id) const;

  // Takes all components of the plugin or none: half a plugin would hide that something is wrong. Those that need a
  // newer host are named as refused.
  bool take(const springnet_plugin& plugin, const fs::path& file, const std::shared_ptr<const void>& owner = nullptr) {
    const PluginCheck check = check_plugin(plugin);
    if (!check.wrong.empty()) return refuse(file, check.wrong);
    std::vector<std::shared_ptr<const Component>> taken;
    for (std::uint32_t i = 0; i < plugin.component_count; ++i) {
      if (!check.not_usable[i].empty()) continue;
      taken.push_back(std::make_shared<const Component>(Component{plugin.components[i], &plugin, file, owner}));
      for (const auto& other : all(taken.back()->kind(), taken.back()->id())) {
        if (other->plugin == &plugin) return true;  // the same plugin again
        if (std::string_view(other->plugin->id) != plugin.id) continue;
        return refuse(file,
                      fmt::format("{} '{}' is already provided by a plugin of the same id, {}: remove one of the two",
                                  name_of(other->kind()), other->id(), owner_of(*other)));
      }
    }
    for (const std::string& reason : check.not_usable)
      if (!reason.empty()) refuse(file, reason);
    components.insert(components.end(), taken.begin(), taken.end());
    return !taken.empty();
  }

  static std::string owner_of(const Component& component) {
    const std::string version = printable(component.plugin->version);
    const std::string owner = printable(component.plugin->id) + (version.empty() ? "" : " ") + version;
    return component.file.empty() ? owner
                                  : fmt::format("{} ({})", owner, printable(component.file.string(), max_path_length));
  }
};

PluginHost::PluginHost() : impl_(std::make_unique<Impl>()) {}
PluginHost::~PluginHost() = default;
PluginHost::PluginHost(PluginHost&&) noexcept = default;
PluginHost& PluginHost::operator=(PluginHost&&) noexcept = default;

PluginHost PluginHost::with_default_search(const std::vector<fs::path>& folders) {
  PluginHost host;
  for (const fs::path& folder : folders) host.search(folder);

  for (const fs::path& entry : listed_folders()) {
    if (entry.is_relative()) {
      host.impl_->ignore_folder(entry,
                                "SPRINGNET_PLUGIN_PATH names a relative folder, which depends on the working "
                                "directory, so it was not searched: give an absolute path");
      continue;
    }
    host.impl_->search(entry, "SPRINGNET_PLUGIN_PATH");
  }

  const std::vector<fs::path> own = own_plugin_folders();
  std::error_code failed;
  bool found = false;
  for (const fs::path& folder : own) {
    if (!fs::is_directory(folder, failed)) continue;
    host.search(folder);
    found = true;
  }
  if (!found && !own.empty()) host.search(own.front());  // records that it is missing
  return host;
}

std::vector<fs::path> plugin_files(const std::vector<fs::path>& folders) {
  std::vector<fs::path> searched = folders, files;
  for (const fs::path& folder : listed_folders())
    if (folder.is_absolute()) searched.push_back(folder);
  for (const fs::path& folder : own_plugin_folders()) searched.push_back(folder);
  std::set<fs::path> seen;
  for (const fs::path& folder : searched) {
    std::error_code failed, unknown;
    for (const fs::path& file : plugins_in(folder, failed)) {
      const fs::path real = fs::weakly_canonical(file, unknown);
      if (seen.insert(unknown ? file : real).second) files.push_back(file);
    }
  }
  return files;
}

void PluginHost::search(const fs::path& folder) { impl_->search(folder, {}); }

void PluginHost::Impl::search(const fs::path& folder, std::string_view origin) {
  std::error_code failed, unknown;
  const std::vector<fs::path> files = plugins_in(folder, failed);
  if (failed) {
    const std::string named = origin.empty() ? "" : fmt::format(", which {} names,", origin);
    if (fs::is_regular_file(folder, unknown))
      return ignore_folder(folder, fmt::format("the folder{} cannot be read (it is a file): name the folder that the "
                                               "file is in",
                                               named));
    return ignore_folder(folder, fmt::format("the folder{} cannot be read ({}): check its name and its permissions",
                                             named, failed.message()));
  }
  const auto is_it = [&](const Searched& each) { return fs::equivalent(each.folder, folder, unknown); };
  if (std::none_of(searched.begin(), searched.end(), is_it)) searched.push_back({folder, files.size()});
  for (const fs::path& file : files) {
    const fs::path real = fs::weakly_canonical(file, failed);
    if (seen.count(failed ? file : real) == 0) load(file);
  }
}

bool PluginHost::load(const fs::path& file) { return impl_->load(file); }

bool PluginHost::Impl::load(const fs::path& file) {
  std::error_code failed;
  const fs::path real = fs::canonical(file, failed);
  if (failed) {
    return refuse(file, fmt::format("cannot be opened ({}): check its name and its permissions", failed.message()));
  }
  seen.insert(real);
  OpenedLibrary opened = open_library(file);
  if (opened.entry == nullptr) return refuse(file, opened.reason);
  return take(*opened.entry, file);
}

bool PluginHost::add(const springnet_plugin& plugin) { return impl_->take(plugin, {}); }

std::shared_ptr<const Component> PluginHost::add(const HostComponent& component, std::string_view plugin,
                                                 std::string_view version) {
  const auto made = std::make_shared<const HostPlugin>(component, plugin, version);
  if (!impl_->take(made->plugin, {}, made)) {
    const std::string reason = std::move(impl_->refusals.back().reason);
    impl_->refusals.pop_back();  // the caller learns of it now
    throw Error(ErrorKind::plugin, reason);
  }
  return impl_->components.back();
}

const std::vector<std::shared_ptr<const Component>>& PluginHost::components() const noexcept {
  return impl_->components;
}

const std::vector<Refusal>& PluginHost::refusals() const noexcept { return impl_->refusals; }

std::shared_ptr<const Component> PluginHost::find(ComponentKind kind, std::string_view id) const {
  const auto found = impl_->all(kind, id);
  if (found.size() < 2) return found.empty() ? nullptr : found.front();
  std::string message =
      fmt::format("{} plugins have a {} '{}': say which,", found.size(), name_of(kind), printable(id));
  for (std::size_t i = 0; i < found.size(); ++i)
    message += fmt::format("{} '{}@{}'", i == 0 ? "" : " or", found[i]->id(), printable(found[i]->plugin->id));
  throw Error(ErrorKind::plugin, message);
}

// "\nSearched: /a (2 plugin files), /b (no plugin file)".
std::string PluginHost::Impl::where_it_searched() const {
  std::string text;
  for (const Searched& each : searched) {
    const std::string files = each.files == 0 ? "no" : fmt::format("{}", each.files);
    text += fmt::format("{}{} ({} plugin file{})", text.empty() ? "\nSearched: " : ", ",
                        printable(each.folder.string(), max_path_length), files, each.files > 1 ? "s" : "");
  }
  return text;
}

// A line for each refusal; first of files whose name has the id that is missing.
std::string PluginHost::Impl::refused_files(std::string_view id) const {
  const std::string_view name = id.substr(0, id.find('@'));
  std::string text;
  for (const bool likely : {true, false}) {
    for (const Refusal& refusal : refusals) {
      if ((refusal.file.filename().string().find(name) != std::string::npos) != likely) continue;
      text += fmt::format(
          "\n  {}: {}",
          refusal.file.empty() ? "(registered in the program)" : printable(refusal.file.string(), max_path_length),
          refusal.reason);
    }
  }
  return text.empty() ? text : "\nRefused plugins:" + text;
}

std::shared_ptr<const Component> PluginHost::require(ComponentKind kind, std::string_view id) const {
  if (auto found = find(kind, id)) return found;
  const std::string_view name = id.substr(0, id.find('@'));
  std::vector<std::string> known;
  std::string elsewhere, of_others;
  for (const auto& component : impl_->components) {
    if (component->kind() == kind) {
      known.emplace_back(component->id());
      if (name != id && component->id() == name)
        of_others += fmt::format("{} '{}@{}'", of_others.empty() ? "" : " or", name, printable(component->plugin->id));
    } else if (component->id() == name) {
      elsewhere = fmt::format(" ('{}' is a {})", printable(name), name_of(component->kind()));
    }
  }
  std::string message = fmt::format("there is no {} '{}'{}", name_of(kind), printable(id), elsewhere);
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  if (!of_others.empty())
    message += fmt::format("; did you mean{}?", of_others);
  else if (const std::string nearest = suggestion(name, known); !nearest.empty())
    message += "; " + nearest;
  if (known.empty()) {
    message +=
        fmt::format("; no plugin offers any {}: set SPRINGNET_PLUGIN_PATH to the folder of the plugins", name_of(kind));
  } else {
    message += message.ends_with('?') ? " known: " : "; known: ";
    for (std::size_t i = 0; i < known.size(); ++i) message += (i == 0 ? "" : ", ") + known[i];
  }
  throw Error(ErrorKind::plugin, message + impl_->where_it_searched() + impl_->refused_files(id));
}

}  // namespace springnet
