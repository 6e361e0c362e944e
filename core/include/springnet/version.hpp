#pragma once

#include <string_view>

namespace springnet {

// Version of the library, "0.1.0".
[[nodiscard]] std::string_view version() noexcept;

}  // namespace springnet
