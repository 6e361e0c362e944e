// Writes files of all kinds that springnet reads: "PROGRAM FOLDER" makes FOLDER/KIND/NAME, where KIND is the ending of
// the target that reads it.
#include <cstdio>

#include <fmt/format.h>

#include "mesh/samples.hpp"
#include "scene/everything.hpp"

using namespace springnet::testing;

namespace {

std::filesystem::path root;

void write(const std::string& kind, const std::string& name, const std::string& bytes) {
  std::filesystem::create_directories(root / kind);
  std::ofstream(root / kind / name, std::ios::binary) << bytes;
}

// As a run writes it, with numbers of 8 or of 4 bytes.
std::string table(const std::string& numbers, std::size_t rows, bool single, std::size_t records) {
  const std::size_t record_bytes = 8 + rows * 2 * (single ? 4 : 8);
  const std::string description = fmt::format(
      R"({{"row":"node","rows":{},"columns":["x","y"],"units":["m","m"],"type":"{}","record_bytes":{},"numbers":{}}})",
      rows, single ? "<f4" : "<f8", record_bytes, numbers);
  std::string bytes = fmt::format("springnet records 1 {:08}\n{}\n", 30 + description.size(), description);
  for (std::size_t k = 0; k < records * record_bytes; ++k) bytes += static_cast<char>(k * 37);
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  root = argv[1];
  std::filesystem::remove_all(root);
  for (const Sample& sample : all_samples()) {
    std::string kind = std::filesystem::path(sample.name).extension().string().substr(1);
    write(kind == "vtp" ? "vtu" : kind, sample.name, sample.bytes);
  }
  write("bin", "all", table("null", 3, false, 2));
  write("bin", "some", table("[1,5]", 2, true, 3));
  write("bin", "cut", table("null", 2, true, 2).substr(0, 200));
  write("toml", "everything", everything);
  write("toml", "everything_of_meshes", everything_of_meshes);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(EXAMPLES)) {
    if (entry.path().extension() == ".toml") write("toml", entry.path().stem().string(), read_text(entry.path()));
  }
  return 0;
}
