#include "scene/depth.hpp"

#include <algorithm>
#include <vector>

namespace springnet::scene {
namespace {

// The position after the string that begins with a quotation mark at `place`; the end of the text if it is not closed.
std::size_t skip_string(std::string_view text, std::size_t place) {
  const char quote = text[place];
  const bool escapes = quote == '"';
  const auto quotes_at = [&](std::size_t k) {
    std::size_t count = 0;
    while (k + count < text.size() && text[k + count] == quote) ++count;
    return count;
  };
  const std::size_t opening = quotes_at(place);
  if (opening == 2) return place + 2;  // empty
  const bool long_string = opening >= 3;
  for (place += long_string ? 3 : 1; place < text.size(); ++place) {
    if (text[place] == '\\' && escapes) {
      ++place;
    } else if (text[place] == '\n' && !long_string) {
      return place;  // not TOML
    } else if (text[place] == quote) {
      if (!long_string) return place + 1;
      const std::size_t count = quotes_at(place);
      // Up to two quotation marks may precede the three that end it.
      if (count >= 3) return place + std::min<std::size_t>(count, 5);
      place += count - 1;
    }
  }
  return text.size();
}

TextPlace place_of(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const std::size_t newline = before.rfind('\n');
  return {1 + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n')),
          newline == std::string_view::npos ? offset + 1 : offset - newline};
}

}  // namespace

std::optional<TextPlace> find_too_deep(std::string_view text) {
  std::vector<std::size_t> outside;  // depth outside of each open bracket
  std::size_t levels = 0;            // depth within the innermost open bracket
  std::size_t dots = 0;              // since the last separator; one may be a decimal point
  for (std::size_t k = 0; k < text.size(); ++k) {
    switch (text[k]) {
      case '"':
      case '\'':
        k = skip_string(text, k) - 1;
        break;
      case '#':
        k = std::min(text.find('\n', k), text.size()) - 1;
        break;
      case '.':
        ++dots;
        break;
      case '[':
      case '{':
        outside.push_back(levels);
        levels += 1 + dots;
        dots = 0;
        break;
      case ']':
      case '}':
        if (!outside.empty()) {
          levels = outside.back();
          outside.pop_back();
        }
        dots = 0;
        break;
      case '\n':
      case ',':
        dots = 0;
        break;
      default:
        break;
    }
    if (levels + dots > deepest_level) return place_of(text, k);
  }
  return std::nullopt;
}

}  // namespace springnet::scene
