#include "scene/file_text.hpp"

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "files/input_file.hpp"

namespace springnet::scene {

std::string read_scene_text(const std::filesystem::path& file) {
  InputFile in(file);
  std::string text;
  in.read(text, largest_scene + 1);
  if (text.empty() && in.is_pipe())
    throw Error(ErrorKind::input, fmt::format("{}: cannot be read (it is a pipe that nothing writes to); check its "
                                              "name and its permissions",
                                              file.string()));
  return text;
}

}  // namespace springnet::scene
