// Files that `springnet new` and `springnet plugin new` write: all or none, never in place of others.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace springnet::tool {

// A file to write: a text, or a copy of another file.
struct Planned {
  std::filesystem::path file;
  std::filesystem::path source;  // empty: the text
  std::string text;
};

// Writes files of a folder, which is created, and prints their names. Throws Error(input) if one of them exists, and
// Error(simulation) if one cannot be written; nothing is left behind then.
void write_all(const std::filesystem::path& folder, const std::vector<Planned>& files);

}  // namespace springnet::tool
