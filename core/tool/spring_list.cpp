#include "spring_list.hpp"

#include <iterator>
#include <string>

#include <fmt/format.h>
#include <springnet/output_folder.hpp>

namespace springnet::tool {

void write_springs(const std::filesystem::path& file, const Network& network) {
  std::string text = "spring,first,second,x,y,z,rest_length\n";
  for (SpringIndex k = 0; k < network.springs().size(); ++k) {
    const Spring& spring = network.springs()[k];
    const Vector3 middle = 0.5 * (network.nodes()[spring.first].position + network.nodes()[spring.second].position);
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{}\n", k, spring.first, spring.second, middle.x(),
                   middle.y(), middle.z(), spring.rest_length);
  }
  write_whole(OutputFile(OutputFolder::containing(file), file.filename().string()), text);
}

}  // namespace springnet::tool
