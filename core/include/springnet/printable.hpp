// Makes text from files, plugins and hosts safe for terminals and logs.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <springnet/export.hpp>

namespace springnet {

// One line: control characters, invisible ones and those that change the direction of writing appear as \u001b, bytes
// that are not UTF-8 as \xff. A text of more than `longest` characters is cut: "its beginning… (10,000,000
// characters)". For names, keys and files quoted in messages.
[[nodiscard]] SPRINGNET_API std::string printable(std::string_view text, std::size_t longest = 60);

// A whole message: the same, but newlines and tabs stay, and nothing is cut. For messages that leave the program.
[[nodiscard]] SPRINGNET_API std::string printable_message(std::string_view message);

}  // namespace springnet
