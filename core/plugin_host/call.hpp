// Calls of a plugin's functions. The ABI forbids exceptions and requires a reason for failures, but a plugin may not
// comply: an exception becomes a failure, and every failure names the component, its plugin and a reason.
#pragma once

#include <exception>
#include <string>

#include <springnet/plugin_host.hpp>
#include <springnet/sdk/message.hpp>

#include "plugin_host/calling.hpp"

namespace springnet {

// The text of a message, safe to display: a plugin may leave it unterminated or with control characters.
[[nodiscard]] std::string text_of(const springnet_message& message);

// "spring function 'linear' of plugin org.springnet.laws"
[[nodiscard]] std::string full_name(const Component& component);
// The same with the plugin's file, if there is one: "… (/usr/lib/springnet/plugins/laws.springnet.so)".
[[nodiscard]] std::string full_name_with_file(const Component& component);

// Writes to `message` that the component failed, with `reason` unless it is empty.
void write_failure(const Component& component, const springnet_message& reason, springnet_message& message) noexcept;

// Runs `function(own_message)`, which calls the component for `members` and returns its status. Unless the status is
// SPRINGNET_OK, `message` says which component failed and why. Throws nothing; statuses other than OK and RECOVERABLE
// become FAILED.
template <class Function>
springnet_status call_component(const Component& component, springnet_message& message, const Function& function,
                                const CalledMembers& members = {}) noexcept {
  springnet_message own;
  own.text[0] = '\0';
  springnet_status status = SPRINGNET_FAILED;
  try {
    const Calling calling(component, members);
    status = function(own);
  } catch (const std::exception& error) {
    sdk::detail::write_message(&own, error.what());
  } catch (...) {
    sdk::detail::write_message(&own, "it threw something that is not a std::exception");
  }
  if (status == SPRINGNET_OK) return status;
  write_failure(component, own, message);
  return status == SPRINGNET_RECOVERABLE ? status : SPRINGNET_FAILED;
}

}  // namespace springnet
