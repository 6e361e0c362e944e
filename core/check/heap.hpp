// Memory in use, to find what is not given back.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace springnet::check {

// Bytes that the process has of its heap, of all threads' allocations by malloc and new. Empty where the system or a
// sanitizer does not tell.
[[nodiscard]] std::optional<std::size_t> heap_in_use();

// Bytes that each call of `what` keeps, if that grows steadily over calls; 0: nothing, or not known.
[[nodiscard]] double kept_by_each(const std::function<void()>& what, int calls);

}  // namespace springnet::check
