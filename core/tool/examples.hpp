// The examples that come with the program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace springnet::tool {

struct Example {
  std::string name;
  std::string summary;                       // title of its scene, or of its page
  std::vector<std::filesystem::path> files;  // of its folder, by name
  std::filesystem::path scene;               // one of them; empty if there is none
};

// By name, from share/springnet/examples beside the program's folder. Throws Error(input) if that folder is missing.
[[nodiscard]] std::vector<Example> installed_examples();

}  // namespace springnet::tool
