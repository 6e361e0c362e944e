// The page without its data: markup, style, libraries and program, put together when the library is built.
#pragma once

#include <array>
#include <string_view>

namespace springnet::view {

// The data go between `before_data` and `after_data`.
extern const std::string_view before_data;
extern const std::string_view after_data;

}  // namespace springnet::view
