#include "examples.hpp"

#include <algorithm>
#include <fstream>
#include <optional>

#define BOOST_DLL_USE_STD_FS
#include <fmt/format.h>
#include <boost/dll/runtime_symbol_info.hpp>

#include <springnet/error.hpp>

namespace springnet::tool {

namespace {

// Relative to the program, because an installed tree may be moved.
std::filesystem::path examples_folder() {
  const std::filesystem::path program = std::filesystem::weakly_canonical(boost::dll::program_location());
  return (program.parent_path() / ".." / SPRINGNET_DATA_FOLDER / "springnet" / "examples").lexically_normal();
}

// The text between `start`, at the beginning of a line, and `end`; of the first such line.
std::optional<std::string> first_line(const std::filesystem::path& file, const std::string& start, char end) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(start)) return line.substr(start.size(), line.find(end, start.size()) - start.size());
  }
  return std::nullopt;
}

Example example_in(const std::filesystem::path& folder) {
  Example example{folder.filename().string(), "", {}, {}};
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file()) example.files.push_back(entry.path());
  }
  std::sort(example.files.begin(), example.files.end());
  for (const std::filesystem::path& file : example.files) {
    if (file.extension() == ".toml") example.scene = file;
  }
  const auto title = example.scene.empty() ? first_line(folder / "README.md", "# ", '\n')
                                           : first_line(example.scene, "title = \"", '"');
  example.summary = title.value_or("");
  return example;
}

}  // namespace

std::vector<Example> installed_examples() {
  const std::filesystem::path folder = examples_folder();
  std::error_code problem;
  if (!std::filesystem::is_directory(folder, problem)) {
    throw Error(ErrorKind::input,
                fmt::format("there are no examples in {}: install springnet with its examples, or use "
                            "those in its sources",
                            folder.string()));
  }
  std::vector<Example> examples;
  try {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.is_directory()) examples.push_back(example_in(entry.path()));
    }
  } catch (const std::filesystem::filesystem_error& error) {
    throw Error(ErrorKind::input, fmt::format("the examples cannot be read: {}", error.what()));
  }
  std::sort(examples.begin(), examples.end(), [](const Example& a, const Example& b) { return a.name < b.name; });
  return examples;
}

}  // namespace springnet::tool
