#include "plugin_host/elf_file.hpp"

#if defined(__linux__)

#include <elf.h>
#include <link.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include <springnet/sdk/plugin.h>

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

// What a plugin's note says.
struct Version {
  std::uint32_t abi_major, abi_minor, needs_minor;
};

// Of a file with more than these there are none to find: segments may overlap, each with notes by the million.
constexpr std::size_t most_notes = 10'000;

// Looks for the plugin's note in a segment of notes, which lies within the file. False: it cannot be read. read_before:
// notes of this file.
bool find_note(std::ifstream& in, std::uint64_t begin, std::uint64_t size, std::size_t& read_before,
               std::optional<Version>& found) {
  constexpr std::uint64_t alignment = 4;
  const auto padded = [](std::uint64_t bytes) { return (bytes + alignment - 1) / alignment * alignment; };
  constexpr std::string_view name = SPRINGNET_NOTE_NAME;
  std::uint64_t at = 0;
  while (within(at, sizeof(ElfW(Nhdr)), size) && read_before++ < most_notes) {
    ElfW(Nhdr) header;
    if (!read(in, begin + at, header)) return false;
    const std::uint64_t text = at + sizeof header, description = text + padded(header.n_namesz);
    if (!within(description, header.n_descsz, size)) return true;  // damaged: no note
    if (header.n_type == SPRINGNET_NOTE_TYPE && header.n_namesz == name.size() + 1 &&
        header.n_descsz >= sizeof(Version)) {
      char owner[sizeof SPRINGNET_NOTE_NAME];
      Version version{};
      if (!read(in, begin + text, owner)) return false;
      if (std::memcmp(owner, name.data(), name.size()) == 0) {
        if (!read(in, begin + description, version)) return false;
        found = version;
        return true;
      }
    }
    at = description + padded(header.n_descsz);
  }
  return true;
}

std::string judge(const std::optional<Version>& note) {
  const char* const rebuild = "rebuild the plugin with the SDK of this springnet";
  if (!note)
    return fmt::format("it has no note with the plugin ABI that it was built for, so it was not opened: {}", rebuild);
  if (note->abi_major != SPRINGNET_ABI_MAJOR)
    return fmt::format(
        "built for plugin ABI {}.{}, this springnet reads {}.x (it has {}.{}): {}, or use a springnet of ABI {}",
        note->abi_major, note->abi_minor, SPRINGNET_ABI_MAJOR, SPRINGNET_ABI_MAJOR, SPRINGNET_ABI_MINOR, rebuild,
        note->abi_major);
  if (note->needs_minor > SPRINGNET_ABI_MINOR)
    return fmt::format("it needs plugin ABI {}.{}, this springnet has {}.{}: use a newer springnet, or {}",
                       note->abi_major, note->needs_minor, SPRINGNET_ABI_MAJOR, SPRINGNET_ABI_MINOR, rebuild);
  return {};
}

}  // namespace

ElfCheck check_elf(const std::filesystem::path& file) {
  std::error_code failed;
  const std::uint64_t size = std::filesystem::file_size(file, failed);
  std::ifstream in(file, std::ios::binary);
  if (failed || !in) return {"it cannot be read", {}};
  std::optional<Version> note;
  std::size_t notes = 0;
  ElfW(Ehdr) header;
  if (size < sizeof header) return {"file too short", {}};
  if (!read(in, 0, header)) return {"it cannot be read", {}};
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return {"it is not an ELF file", {}};
  // The loader itself rejects other machines and word sizes before it maps anything.
  if (header.e_ident[EI_CLASS] != (sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32)) return {};
  if (header.e_phentsize != sizeof(ElfW(Phdr))) return {};
  for (std::uint64_t k = 0; k < header.e_phnum; ++k) {
    const std::uint64_t offset = header.e_phoff + k * sizeof(ElfW(Phdr));
    ElfW(Phdr) segment;
    if (!within(offset, sizeof segment, size)) return {truncated, {}};
    if (!read(in, offset, segment)) return {"it cannot be read", {}};
    if ((segment.p_type == PT_LOAD || segment.p_type == PT_NOTE) && !within(segment.p_offset, segment.p_filesz, size))
      return {truncated, {}};
    if (segment.p_type != PT_NOTE || note) continue;
    if (!find_note(in, segment.p_offset, segment.p_filesz, notes, note)) return {"it cannot be read", {}};
  }
  return {{}, judge(note)};
}

}  // namespace springnet

#else

namespace springnet {

ElfCheck check_elf(const std::filesystem::path&) { return {}; }

}  // namespace springnet

#endif
