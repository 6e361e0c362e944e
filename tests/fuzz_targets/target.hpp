// What all targets share: the bytes as a file, and what is no answer to a wrong one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>

#include <springnet/error.hpp>

#include "temporary_folder.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace springnet::testing {

// Ends the program where `holds` is false: what the fuzzer takes for a finding.
inline void require(bool holds, const char* what, const char* detail = "") {
  if (holds) return;
  std::fprintf(stderr, "not so: %s %s\n", what, detail);
  std::abort();
}

// Writes the bytes to a file of this name, always the same one.
inline const std::filesystem::path& file_of(const std::uint8_t* data, std::size_t size, const char* name) {
  static const TemporaryFolder folder;
  static const std::filesystem::path file = folder.path() / name;
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return file;
}

// Calls a reader: it may refuse the file, with a message that begins with its name.
template <class Read>
void read_or_refuse(std::string_view name, Read read) {
  try {
    read();
  } catch (const Error& error) {
    require(error.kind() == ErrorKind::input, "an error of input:", error.what());
    require(std::string_view(error.what()).starts_with(name), "the message names the file:", error.what());
  }
}

}  // namespace springnet::testing
