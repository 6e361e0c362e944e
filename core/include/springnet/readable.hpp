// Numbers for human readers.
#pragma once

#include <string>

#include <springnet/export.hpp>

namespace springnet {

// "12 bytes", "3.4 MB"
[[nodiscard]] SPRINGNET_API std::string readable_bytes(double bytes);

}  // namespace springnet
