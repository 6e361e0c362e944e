// The examples that come with the program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace springnet::tool {

struct Example {
  std::string name;
  std::string summary;                       // the title of its scene, or of its page
  std::vector<std::filesystem::path> files;  // of its folder, by name
  std::filesystem::path scene;               // one of them; empty: it has none
};

// By name, from share/springnet/examples beside the program's folder. Throws Error(input) where that is not there.
[[nodiscard]] std::vector<Example> installed_examples();

}  // namespace springnet::tool
