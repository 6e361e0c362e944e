// What a component says of itself to people, beyond what a plugin host insists on.
#pragma once

#include <springnet/plugin_host.hpp>

#include "check/report.hpp"

namespace springnet::check {

[[nodiscard]] Outcome check_texts(const Component& component);

}  // namespace springnet::check
