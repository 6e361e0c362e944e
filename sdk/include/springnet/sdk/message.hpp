// Messages of failures across the C boundary.
#pragma once

#include <cstddef>
#include <cstring>
#include <exception>

#include <springnet/sdk/plugin.h>

namespace springnet::sdk::detail {

// Zero-terminated, cut at a whole UTF-8 character where it does not fit. `message` may be null.
inline void write_message(springnet_message* message, const char* text) noexcept {
  if (message == nullptr) return;
  std::size_t length = std::strlen(text);
  if (length >= sizeof message->text) {
    length = sizeof message->text - 1;
    while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xc0u) == 0x80u) --length;
  }
  std::memcpy(message->text, text, length);
  message->text[length] = '\0';
}

// Runs `body`, which returns a status; exceptions become SPRINGNET_FAILED and a message.
template <class Body>
springnet_status guarded(springnet_message* message, const Body& body) noexcept {
  try {
    return body();
  } catch (const std::exception& error) {
    write_message(message, error.what());
  } catch (...) {
    write_message(message, "the component threw something that is not a std::exception");
  }
  return SPRINGNET_FAILED;
}

}  // namespace springnet::sdk::detail
