// Whether a law can be used on springs, or on an element.
#pragma once

#include <string>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet::layers {

// What follows the name of a law that is for other things than springs, with what to do: "is for …; use …". Empty: it
// fits.
[[nodiscard]] std::string misfit(const Component& law);
// Likewise of an element, which may have a shape at rest, or a reference value, that the law cannot have.
[[nodiscard]] std::string misfit(const Component& law, const Element& element);

}  // namespace springnet::layers
