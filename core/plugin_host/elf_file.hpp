// A library's file before the system's loader maps it: where the file ends within what its header promises, as one that
// was copied to a full disk, the loader ends the process with a bus error.
#pragma once

#include <filesystem>
#include <string>

namespace springnet {

// Empty if the file is an ELF library of this machine's word size that is all there, or a library of another kind of
// system; else what is wrong. Throws nothing but std::bad_alloc.
[[nodiscard]] std::string check_elf(const std::filesystem::path& file);

}  // namespace springnet
