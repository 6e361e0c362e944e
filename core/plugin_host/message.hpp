// Texts for the messages of the C ABI.
#pragma once

#include <string>

#include <springnet/sdk/message.hpp>

namespace springnet {

inline void set_message(springnet_message& message, const std::string& text) noexcept {
  sdk::detail::write_message(&message, text.c_str());
}

}  // namespace springnet
