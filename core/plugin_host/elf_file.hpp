// Check of a library file before the system's loader maps it. With a truncated file, for example one copied to a full
// disk, the loader ends the process with a bus error; and opening a library runs its constructors, so what it needs is
// read before.
#pragma once

#include <filesystem>
#include <string>

namespace springnet {

struct ElfCheck {
  std::string damage;   // why it cannot be a complete ELF library of this machine's word size; empty: nothing
  std::string version;  // why its note (springnet_note) says that this host cannot use it, or that there is none
};

// Both empty where the system does not use ELF. Throws nothing but std::bad_alloc.
[[nodiscard]] ElfCheck check_elf(const std::filesystem::path& file);

}  // namespace springnet
