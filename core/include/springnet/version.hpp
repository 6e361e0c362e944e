#pragma once

#include <string_view>

#include <springnet/export.hpp>

namespace springnet {

// Version of the library, "0.1.0".
[[nodiscard]] SPRINGNET_API std::string_view version() noexcept;

}  // namespace springnet
