#include "plugin_host/elf_file.hpp"

#if defined(__linux__)

#include <elf.h>
#include <link.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <system_error>

namespace springnet {
namespace {

constexpr const char* truncated = "the file is shorter than its header declares";

// Whether `count` bytes from `begin` lie within `size`, safe against overflow.
bool within(std::uint64_t begin, std::uint64_t count, std::uint64_t size) {
  return begin <= size && count <= size - begin;
}

template <class Struct>
bool read(std::ifstream& in, std::uint64_t offset, Struct& out) {
  in.seekg(static_cast<std::streamoff>(offset));
  return static_cast<bool>(in.read(reinterpret_cast<char*>(&out), sizeof out));
}

}  // namespace

std::string check_elf(const std::filesystem::path& file) {
  std::error_code failed;
  const std::uint64_t size = std::filesystem::file_size(file, failed);
  std::ifstream in(file, std::ios::binary);
  if (failed || !in) return "it cannot be read";
  ElfW(Ehdr) header;
  if (size < sizeof header) return "file too short";
  if (!read(in, 0, header)) return "it cannot be read";
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return "it is not an ELF file";
  // The loader itself rejects other machines and word sizes before it maps anything.
  if (header.e_ident[EI_CLASS] != (sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32)) return {};
  if (header.e_phentsize != sizeof(ElfW(Phdr))) return {};
  for (std::uint64_t k = 0; k < header.e_phnum; ++k) {
    const std::uint64_t offset = header.e_phoff + k * sizeof(ElfW(Phdr));
    ElfW(Phdr) segment;
    if (!within(offset, sizeof segment, size)) return truncated;
    if (!read(in, offset, segment)) return "it cannot be read";
    if (segment.p_type == PT_LOAD && !within(segment.p_offset, segment.p_filesz, size)) return truncated;
  }
  return {};
}

}  // namespace springnet

#else

namespace springnet {

std::string check_elf(const std::filesystem::path&) { return {}; }

}  // namespace springnet

#endif
