#include "plugin_host/library.hpp"

#include <exception>
#include <map>
#include <mutex>
#include <utility>

#define BOOST_DLL_USE_STD_FS
#include <fmt/format.h>
#include <boost/dll/runtime_symbol_info.hpp>
#include <boost/dll/shared_library.hpp>

#include "plugin_host/elf_file.hpp"

namespace springnet {
namespace {

// Components point into the libraries, and threads may outlive every PluginHost, so nothing is ever unloaded; the
// registry itself is never destroyed either.
std::map<std::filesystem::path, boost::dll::shared_library>& registry() {
  static auto& libraries = *new std::map<std::filesystem::path, boost::dll::shared_library>;
  return libraries;
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  std::error_code failed;
  const std::filesystem::path real = std::filesystem::weakly_canonical(file, failed);
  return (failed ? file : real).parent_path();
}

// The message of the system's loader, extracted from Boost's: "… (dlerror system message: F: why): code".
std::string loader_message(const std::exception& error, const std::filesystem::path& file) {
  std::string text = error.what();
  const std::string before = "dlerror system message: ";
  const std::size_t begin = text.find(before), end = text.rfind("): ");
  if (begin == std::string::npos || end == std::string::npos || end < begin) return text;
  text = text.substr(begin + before.size(), end - begin - before.size());
  const std::string name = file.string() + ": ";
  return text.starts_with(name) ? text.substr(name.size()) : text;
}

std::string unloadable(const std::string& why) {
  return fmt::format(
      "cannot be loaded as a library ({}): check that it is a complete library for this machine and is linked with "
      "everything that it calls",
      why);
}

// Opening anything but a regular file may block (a pipe) or have side effects (a device). Empty: a regular file.
std::string check_kind(const std::filesystem::path& file) {
  const auto kind = std::filesystem::status(file).type();
  if (kind == std::filesystem::file_type::regular) return {};
  const char* const what = kind == std::filesystem::file_type::directory   ? "a folder"
                           : kind == std::filesystem::file_type::fifo      ? "a named pipe"
                           : kind == std::filesystem::file_type::socket    ? "a socket"
                           : kind == std::filesystem::file_type::character ? "a device"
                           : kind == std::filesystem::file_type::block     ? "a device"
                                                                           : "not a regular file";
  return fmt::format("cannot be loaded as a library (it is {}): remove it, or name a plugin's file", what);
}

}  // namespace

OpenedLibrary open_library(const std::filesystem::path& file) {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  std::filesystem::path real = file;
  try {
    real = std::filesystem::canonical(file);
    if (std::string wrong = check_kind(real); !wrong.empty()) return {nullptr, std::move(wrong)};
    auto found = registry().find(real);
    if (found == registry().end()) {
      if (const ElfCheck check = check_elf(real); !check.damage.empty())
        return {nullptr, unloadable(check.damage)};
      else if (!check.version.empty())
        return {nullptr, check.version};
      using boost::dll::load_mode::rtld_local;
      using boost::dll::load_mode::rtld_now;
      boost::dll::shared_library library(real, rtld_now | rtld_local);
      found = registry().emplace(real, std::move(library)).first;
    }
    if (!found->second.has(SPRINGNET_ENTRY_SYMBOL)) {
      return {nullptr, fmt::format("it has no symbol {}, so it is not a springnet plugin: declare one with the SDK, "
                                   "and export it",
                                   SPRINGNET_ENTRY_SYMBOL)};
    }
    return {&found->second.get<const springnet_plugin>(SPRINGNET_ENTRY_SYMBOL), {}};
  } catch (const std::exception& error) {
    return {nullptr, unloadable(loader_message(error, real))};
  }
}

std::string library_suffix() { return boost::dll::shared_library::suffix().string(); }

std::vector<std::filesystem::path> own_plugin_folders() {
  const std::filesystem::path plugins = std::filesystem::path("springnet") / "plugins";
  std::vector<std::filesystem::path> folders;
  try {
    folders.push_back(folder_of(boost::dll::this_line_location()) / plugins);
    // If linked statically, the library is at the program's location.
    const std::filesystem::path program = folder_of(boost::dll::program_location());
    if (program / plugins == folders.front()) {
      folders.push_back((program / ".." / "lib" / plugins).lexically_normal());
      folders.push_back((program / ".." / SPRINGNET_LIBRARY_FOLDER / plugins).lexically_normal());
    }
  } catch (const std::exception&) {
    // The system does not report where the code is: no own folder.
  }
  return folders;
}

}  // namespace springnet
