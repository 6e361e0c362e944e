// Check of a library file before the system's loader maps it. With a truncated file, for example one copied to a full
// disk, the loader ends the process with a bus error.
#pragma once

#include <filesystem>
#include <string>

namespace springnet {

// Empty if the file is a complete ELF library of this machine's word size, or the system does not use ELF; else what is
// wrong. Throws nothing but std::bad_alloc.
[[nodiscard]] std::string check_elf(const std::filesystem::path& file);

}  // namespace springnet
