// Text in pages.
#pragma once

#include <string>
#include <string_view>

namespace springnet {

// Text with the special characters of HTML escaped.
[[nodiscard]] inline std::string escape_html(std::string_view text) {
  std::string result;
  for (const char character : text) {
    switch (character) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += character;
    }
  }
  return result;
}

}  // namespace springnet
