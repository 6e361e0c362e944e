#include "scene/files.hpp"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include <springnet/printable.hpp>

#include "scene/file_text.hpp"

namespace springnet::scene {
namespace {

std::filesystem::path follow_links(const std::filesystem::path& path, const Value& name) {
  std::error_code failed;
  std::filesystem::path result = std::filesystem::weakly_canonical(path, failed);
  if (failed) {
    name.fail(fmt::format("its path cannot be followed ({}); check the path and its permissions", failed.message()));
  }
  return result;
}

bool is_within(const std::filesystem::path& folder, const std::filesystem::path& path) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

}  // namespace

std::filesystem::path Files::resolve(const Value& name) const {
  const std::filesystem::path given = name.text();
  const bool allowed = outside == OutsideFiles::allowed;
  if (folder.empty() && !(allowed && given.is_absolute())) {
    name.fail(
        "names a file, but this scene is in no folder: it was read from text or from a pipe; read it from a file, or "
        "pass the folder to parse_scene");
  }
  const std::filesystem::path path = given.is_absolute() ? given : folder / given;
  if (allowed) return path;
  const std::filesystem::path target = follow_links(path, name);
  if (!is_within(follow_links(folder, name), target)) {
    name.fail(
        fmt::format("lies outside of the scene's folder, at {}; copy the file into the folder of the scene, or allow "
                    "this with --allow-outside (OutsideFiles::allowed in a program)",
                    printable(target.string(), max_path_length)));
  }
  return path;
}

const CsvTable& Files::csv_table(const Value& name) const {
  const std::filesystem::path path = resolve(name);
  return *name.at_this_place([&] { return &csv->read(path); });
}

CsvColumns Files::csv_columns(const Value& name, const std::vector<std::string>& columns) const {
  const CsvTable& table = csv_table(name);
  return name.at_this_place([&] { return table.columns(columns); });
}

}  // namespace springnet::scene
