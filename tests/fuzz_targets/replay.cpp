// Reads files, and those of folders, as libFuzzer would: "PROGRAM FILE_OR_FOLDER …". A folder that is not there has
// none.
#include <algorithm>
#include <vector>

#include "target.hpp"

int main(int argc, char** argv) {
  std::vector<std::filesystem::path> files;
  for (int k = 1; k < argc; ++k) {
    if (std::filesystem::is_regular_file(argv[k])) files.emplace_back(argv[k]);
    if (!std::filesystem::is_directory(argv[k])) continue;
    for (const auto& entry : std::filesystem::directory_iterator(argv[k])) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const std::filesystem::path& file : files) {
    std::printf("%s\n", file.c_str());
    std::fflush(stdout);  // the last line is the file that ends the program
    const std::string bytes = springnet::testing::read_text(file);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  std::printf("%zu files read\n", files.size());
  return files.empty() ? 1 : 0;
}
