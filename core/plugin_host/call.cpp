#include "plugin_host/call.hpp"

#include <string.h>

#include <fmt/format.h>

#include <springnet/printable.hpp>

namespace springnet {
namespace {

// Characters of a reason: leaves room in the message for the component's name and file.
constexpr std::size_t max_reason_length = 300;

}  // namespace

std::string text_of(const springnet_message& message) {
  return printable_message({message.text, strnlen(message.text, sizeof message.text)});
}

std::string full_name(const Component& component) {
  return fmt::format("{} '{}' of plugin {}", name_of(component.kind()), component.id(),
                     printable(component.plugin->id));
}

std::string full_name_with_file(const Component& component) {
  if (component.file.empty()) return full_name(component);
  return fmt::format("{} ({})", full_name(component), printable(component.file.string(), max_reason_length));
}

void write_failure(const Component& component, const springnet_message& reason, springnet_message& message) noexcept {
  try {
    const std::string why = printable({reason.text, strnlen(reason.text, sizeof reason.text)}, max_reason_length);
    const std::string text = why.empty() ? full_name_with_file(component) + " failed without giving a reason"
                                         : fmt::format("{} failed: {}", full_name(component), why);
    sdk::detail::write_message(&message, text.c_str());
  } catch (...) {  // out of memory
    sdk::detail::write_message(&message, component.description->id);
  }
}

}  // namespace springnet
