#include "view/base64.hpp"

#include <string_view>

namespace springnet::view {

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const std::size_t count = bytes.size() - k < 3 ? bytes.size() - k : 3;
    std::uint32_t triple = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      triple = triple << 8U | (i < count ? std::to_integer<std::uint32_t>(bytes[k + i]) : 0U);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      text += i <= count ? digits[triple >> (18U - 6U * i) & 63U] : '=';
    }
  }
  return text;
}

}  // namespace springnet::view
