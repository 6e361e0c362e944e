// Kinds of components as words of the command line.
#pragma once

#include <array>
#include <string_view>

#include <springnet/plugin_host.hpp>

namespace springnet::tool {

struct KindWord {
  const char* word;
  ComponentKind kind;
};
// In the order in which they are listed.
inline constexpr std::array<KindWord, 4> kind_words{{{"spring", ComponentKind::spring_function},
                                                     {"viscosity", ComponentKind::viscosity_function},
                                                     {"neuron", ComponentKind::neuron},
                                                     {"integrator", ComponentKind::integrator}}};

// "spring"
[[nodiscard]] constexpr std::string_view kind_word(ComponentKind kind) noexcept {
  for (const KindWord& each : kind_words)
    if (each.kind == kind) return each.word;
  return {};
}
// Of a word that is none of these the first kind; options refuse such words before.
[[nodiscard]] constexpr ComponentKind kind_of(std::string_view word) noexcept {
  for (const KindWord& each : kind_words)
    if (each.word == word) return each.kind;
  return kind_words.front().kind;
}

}  // namespace springnet::tool
