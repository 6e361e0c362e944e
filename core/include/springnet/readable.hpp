// Numbers for human readers.
#pragma once

#include <string>

namespace springnet {

// "12 bytes", "3.4 MB"
[[nodiscard]] std::string readable_bytes(double bytes);

}  // namespace springnet
