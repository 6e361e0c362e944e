#include <springnet/printable.hpp>

#include <cstdint>
#include <limits>

#include <fmt/format.h>

#include "text/grouped.hpp"

namespace springnet {
namespace {

struct Character {
  std::uint32_t code = 0;  // code point; the byte if it is not valid UTF-8
  std::size_t size = 1;    // bytes
  bool valid = false;
};

// The first character of `text`, which is not empty.
Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[k])); };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const Character wrong{lead};
  const std::size_t size = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < size) return wrong;
  std::uint32_t code = lead & (0x7fU >> size);
  for (std::size_t k = 1; k < size; ++k) {
    if ((byte(k) & 0xc0U) != 0x80U) return wrong;
    code = code << 6 | (byte(k) & 0x3fU);
  }
  const bool overlong = (size == 3 && code < 0x800) || (size == 4 && code < 0x10000);
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (overlong || surrogate || code > 0x10ffff) return wrong;
  return {code, size, true};
}

// Whether a terminal would execute this character or display a misleading text: control and direction characters.
bool misleads(std::uint32_t code) {
  const auto within = [code](std::uint32_t first, std::uint32_t last) { return code >= first && code <= last; };
  return code < 0x20 || within(0x7f, 0x9f) || within(0x200b, 0x200f) || within(0x2028, 0x202e) ||
         within(0x2060, 0x206f) || code == 0xfeff || within(0xe0000, 0xe007f);
}

std::string escaped(std::string_view text, std::size_t longest, bool keep_lines) {
  std::string result;
  std::size_t count = 0;
  for (std::size_t place = 0; place < text.size(); ++count) {
    const Character c = first_of(text.substr(place));
    const bool kept = keep_lines && (c.code == '\n' || c.code == '\t');
    if (count < longest) {
      if (!c.valid) {
        result += fmt::format("\\x{:02x}", c.code);
      } else if (misleads(c.code) && !kept) {
        result += fmt::format("\\u{:04x}", c.code);
      } else {
        result += text.substr(place, c.size);
      }
    }
    place += c.size;
  }
  if (count > longest) result += fmt::format("… ({} characters)", grouped(count));
  return result;
}

}  // namespace

std::string printable(std::string_view text, std::size_t longest) { return escaped(text, longest, false); }

std::string printable_message(std::string_view message) {
  return escaped(message, std::numeric_limits<std::size_t>::max(), true);
}

}  // namespace springnet
