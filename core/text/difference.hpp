// Two values that should be the same, shown where they differ.
#pragma once

#include <string>
#include <string_view>

namespace springnet {

// "0.1 s there, 0.2 s here"; of long values what is about the first difference: "…, unsettled 0 there, …, unsettled 2
// here".
[[nodiscard]] std::string difference_of(std::string_view there, std::string_view here,
                                        std::string_view here_word = "here");

}  // namespace springnet
